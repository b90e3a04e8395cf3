"""The learned map, corrected by physics where physics can tell that it is off.

The map's coordinates are the start of guarded Newton-CG steps on a hyper-reduced body. Equilibria, projected on the
modes, are no equilibria of the reduced body: where the residual of the start is no larger than theirs, the map is
closer to the truth than the reduced body's own minimum, and stays as it is.
"""

from __future__ import annotations

from functools import cached_property

import h5py
import numpy as np

from risorius.evaluators.rational import RationalMap
from risorius.evaluators.setting import Setting
from risorius.hyper_reduction.correction import Correction
from risorius.hyper_reduction.sampled_body import SampledBody
from risorius.jaw import FloatArray
from risorius.poses import Poses


class CorrectedMap:
    """predictor: the learned map; sampled: the body of the same modes; poses of the face. Not thread-safe.

    doubt: length of the preconditioned residual of the map's answer, in units of a coordinate.
    """

    name = "corrected"

    def __init__(self, predictor: RationalMap, sampled: SampledBody, poses: Poses, steps: int = 1) -> None:
        self._predictor, self._sampled, self._poses, self._steps = predictor, sampled, poses, steps
        self._start = np.zeros(len(sampled.fields))
        self._muscles = len(sampled.muscles.pull)
        self.doubt = 0.0

    @cached_property
    def _correction(self) -> Correction:
        """Made for the first answer: a model holds the map whether it is run or not."""
        return self._sampled.correction()

    @property
    def elements(self) -> int:
        """Number of weighted elements."""
        return self._sampled.size

    def coordinates(self, parameters: FloatArray, out: FloatArray) -> None:
        """Write the modal coordinates (r,) of parameters (p,) into `out`."""
        lifts, body = self._sampled.lifts, self._correction.body
        self._predictor.coordinates(parameters, out)
        self._poses.lift_coordinates(parameters[self._muscles :], out=self._start[:lifts])
        self._start[lifts:] = out
        body.set_activations(parameters[: self._muscles])
        self.doubt = self._correction.residual(self._start)
        if self.doubt > self._sampled.quiet:
            self._correction.improve(self._steps)
            out[:] = body.q[lifts:]

    def at(self, setting: Setting) -> CorrectedMap:
        """Return that of the leading modes, with the steps of a setting."""
        return CorrectedMap(
            self._predictor.at(setting), self._sampled.leading(setting.rank), self._poses, setting.steps
        )

    def write(self, group: h5py.Group) -> None:
        """Store the body and the poses; the learned map is the one that the model has."""
        self._sampled.write(group.create_group("body"))
        self._poses.write(group)
        group["predictor"] = h5py.SoftLink(f"{group.parent.name}/{RationalMap.name}")

    @classmethod
    def read(cls, group: h5py.Group) -> CorrectedMap:
        """Load what `write` stored."""
        return cls(RationalMap.read(group["predictor"]), SampledBody.read(group["body"]), Poses.read(group))
