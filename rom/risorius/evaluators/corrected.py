"""The learned map, corrected by physics where physics can tell that it is off.

The map's coordinates are the start of guarded Newton-CG steps on a hyper-reduced body. Equilibria, projected on the
modes, are no equilibria of the reduced body: where the residual of the start is no larger than theirs, the map is
closer to the truth than the reduced body's own minimum, and stays as it is. It stays, too, where steps that lower the
energy leave a longer residual.
"""

from __future__ import annotations

from functools import cached_property

import h5py
import numpy as np
import numpy.typing as npt

from risorius.evaluators.network import NetworkMap
from risorius.evaluators.rational import RationalMap
from risorius.evaluators.setting import Setting
from risorius.hyper_reduction.correction import Correction
from risorius.hyper_reduction.muscles import ReducedMuscles
from risorius.hyper_reduction.sampled_body import SampledBody
from risorius.jaw import FloatArray
from risorius.part import Part
from risorius.poses import Poses

Predictor = RationalMap | NetworkMap
PREDICTORS: dict[str, type[Predictor]] = {kind.name: kind for kind in (RationalMap, NetworkMap)}


class CorrectedMap:
    """predictor: the learned map; sampled: the body of the same modes; poses of the face. Not thread-safe.

    modes: numbers of those that are asked for, all unless given: an equilibrium needs every one, whoever looks.

    doubt: length of the preconditioned residual of the map's answer, in units of a coordinate.
    """

    name = "corrected"

    def __init__(
        self,
        predictor: Predictor,
        sampled: SampledBody,
        poses: Poses,
        steps: int = 1,
        modes: npt.NDArray[np.int64] | None = None,
    ) -> None:
        self._predictor, self._sampled, self._poses, self._steps = predictor, sampled, poses, steps
        self._start = np.zeros(len(sampled.fields))
        self._modal = self._start[sampled.lifts :]
        self._modes = np.arange(len(self._modal)) if modes is None else modes
        self._muscles = len(sampled.muscles.pull)
        self.doubt = 0.0

    @cached_property
    def _correction(self) -> Correction:
        """Made for the first answer: a model holds the map whether it is run or not."""
        return self._sampled.correction()

    @property
    def muscles(self) -> ReducedMuscles:
        """Energy of the muscles in the coordinates of the face, lifts first."""
        return self._sampled.muscles

    @property
    def elements(self) -> int:
        """Number of weighted elements."""
        return self._sampled.size

    @property
    def quiet(self) -> float:
        """Residual below which the map's answer stays."""
        return self._sampled.quiet

    def residual(self, parameters: FloatArray, coordinates: FloatArray) -> float:
        """Length of the preconditioned residual of lifts and modes (r,) at parameters (p,), in coordinates."""
        self._correction.body.set_activations(parameters[: self._muscles])
        return self._correction.residual(coordinates)

    def coordinates(self, parameters: FloatArray, out: FloatArray) -> None:
        """Write the modal coordinates (r,) of parameters (p,) into `out`."""
        lifts, body = self._sampled.lifts, self._correction.body
        self._predictor.coordinates(parameters, self._modal)
        self._poses.lift_coordinates(parameters[self._muscles :], out=self._start[:lifts])
        body.set_activations(parameters[: self._muscles])
        self.doubt = self._correction.residual(self._start)
        if self.doubt > self.quiet and self._correction.improve(self._steps) < self.doubt:
            self._modal[:] = body.q[lifts:]
        np.take(self._modal, self._modes, out=out)

    def at(self, setting: Setting) -> CorrectedMap:
        """Return that of the leading modes, with the steps of a setting."""
        asked = self._modes[: setting.rank]
        leading = Setting(setting.method, int(asked[-1]) + 1)
        return CorrectedMap(
            self._predictor.at(leading), self._sampled.leading(leading.rank), self._poses, setting.steps, asked
        )

    def within(self, part: Part) -> CorrectedMap:
        """Return that of a part: the body keeps all its modes, and loses muscles and lifts that never act."""
        whole = part.with_modes(np.arange(len(self._modal)))
        muscles = part.parameters[part.parameters < self._muscles]
        return CorrectedMap(
            self._predictor.within(whole),
            self._sampled.within(whole.coordinates, len(part.lifts), muscles),
            self._poses.within(part.parameters[len(muscles) :] - self._muscles),
            self._steps,
            self._modes[part.modes],
        )

    def thinned(self, every: int) -> CorrectedMap:
        """Return that of a body with one of `every` elements."""
        return CorrectedMap(self._predictor, self._sampled.thinned(every), self._poses, self._steps, self._modes)

    def write(self, group: h5py.Group) -> None:
        """Store the body and the poses; the learned map is the one that the model has."""
        self._sampled.write(group.create_group("body"))
        self._poses.write(group)
        group["predictor"] = h5py.SoftLink(f"{group.parent.name}/{self._predictor.name}")

    @classmethod
    def read(cls, group: h5py.Group) -> CorrectedMap:
        """Load what `write` stored."""
        name = group.get("predictor", getlink=True).path.rsplit("/", 1)[-1]
        return cls(PREDICTORS[name].read(group["predictor"]), SampledBody.read(group["body"]), Poses.read(group))
