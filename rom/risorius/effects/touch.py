"""Forces on the skin: linear elasticity of the tissue at rest, which bones, teeth and the other lip stop.

The stiffness of the tissue is kept, sparse, and factorised when an engine is made. What a force on a vertex does, and
what each spring does that it presses against, is solved for when that is first touched, and kept.
"""

from __future__ import annotations

import operator
from collections import OrderedDict
from functools import cached_property
from typing import ClassVar

import h5py
import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from risorius import storage
from risorius.effects.effect import Surroundings, Touch
from risorius.effects.reactions import Reactions
from risorius.errors import InputError
from risorius.evaluators.setting import Setting
from risorius.guard import UNFOLDED
from risorius.jaw import FloatArray
from risorius.mechanics.one_sided import OneSidedSprings
from risorius.mechanics.stiffness import stiffness
from risorius.part import Part
from risorius.snapshot_file import SnapshotSet

FARTHEST = 5e-3  # metres: of larger displacements, linear response tells too little
KEPT = 32  # vertices


class Tissue:
    """Tissue at rest: upper (m, m), the upper triangle of its stiffness in N/m, sparse; springs that stop it."""

    def __init__(self, upper: sp.csr_matrix, springs: OneSidedSprings) -> None:
        self.upper, self.springs = upper, springs

    @cached_property
    def factors(self) -> spla.SuperLU:
        """Factors of the stiffness."""
        return spla.splu((self.upper + sp.triu(self.upper, 1).T).tocsc())


class TouchResponse:
    """tissue at rest; weights (3 n, m), sparse: displacement of the visible vertices, component by component, from that
    of the tissue, in the frame of the head; order: of the components that are asked for. Not thread-safe.
    """

    name: ClassVar[str] = "touch"
    needs: ClassVar[str] = "snapshots of this release without the force-length relation"
    energy: ClassVar[float] = 0.0
    gave_way: ClassVar[float] = 0.0

    def __init__(self, tissue: Tissue, weights: sp.csr_matrix, order: tuple[int, int, int], carriers: int) -> None:
        self.fields: npt.NDArray[np.float32] = np.zeros((0, carriers, 3), np.float32)
        self._tissue, self._weights, self._order = tissue, weights, order
        seen = np.unique(weights.indices).astype(np.int64)
        self._seen, self._weights_of_seen = seen, weights[:, seen]
        self._reactions = Reactions(tissue.springs, lambda loads: tissue.factors.solve(loads), seen)
        self._columns: OrderedDict[int, tuple[FloatArray, FloatArray]] = OrderedDict()
        self._touches: tuple[Touch, ...] = ()
        self._answered: tuple[Touch, ...] | None = None
        self._answer = np.zeros((0, 3))

    @classmethod
    def train(cls, snapshots: SnapshotSet, fields: FloatArray) -> TouchResponse | None:
        """See `Effect`."""
        body, surface, springs = snapshots.body, snapshots.surface, snapshots.springs
        if body is None or (snapshots.contact is not None and springs is None):
            return None
        free = np.flatnonzero(~np.repeat(body.prescribed, 3))
        at_rest = stiffness(body, np.zeros_like(snapshots.points), np.zeros(len(snapshots.muscles)))
        weights = sp.kron(surface.weights, sp.identity(3), format="csr")[:, free]
        springs = (springs or OneSidedSprings.none(snapshots.points.size)).on(free)
        tissue = Tissue(sp.triu(at_rest[free][:, free], format="csr"), springs)
        return cls(tissue, weights.tocsr(), (0, 1, 2), len(np.unique(surface.weights.indices)))

    def check(self, surroundings: Surroundings) -> None:
        """Refuse touches of no vertex, and those that move tissue too far."""
        if not surroundings.touches:
            return
        count = self._weights.shape[0] // 3
        for touch in surroundings.touches:
            if not _is_number_below(touch.vertex, count):
                raise InputError(f"touch: there is no vertex {touch.vertex!r}; give one of 0 to {count - 1}")
        moved = self._moved(surroundings.touches)
        farthest = max(float(np.linalg.norm(moved[touch.vertex])) for touch in surroundings.touches)
        if farthest > FARTHEST:
            forces = ", ".join(
                f"{np.linalg.norm(touch.force):.3g} N on {touch.vertex}" for touch in surroundings.touches
            )
            raise InputError(
                f"touch: {forces} moves the skin by {1e3 * farthest:.1f} mm, more than the {1e3 * FARTHEST:g} mm of "
                f"which linear response can tell; give {100 * FARTHEST / farthest:.0f} % of it"
            )

    def drive(self, parameters: FloatArray, surroundings: Surroundings) -> Surroundings:
        """Change nothing: muscles do not feel it."""
        return surroundings

    def respond(
        self, parameters: FloatArray, coordinates: FloatArray, own: FloatArray, surroundings: Surroundings
    ) -> None:
        """Remember the touches for `finish`."""
        self._touches = surroundings.touches

    def finish(
        self, coordinates: FloatArray, vertices: npt.NDArray[np.float32], folds: FloatArray | None = UNFOLDED
    ) -> None:
        """Move the touched skin."""
        if self._touches:
            vertices += self._moved(self._touches)[:, list(self._order)]

    def _moved(self, touches: tuple[Touch, ...]) -> FloatArray:
        """Displacement (n, 3) of the vertices in the frame of the head."""
        if touches is self._answered:  # as `check` was asked
            return self._answer
        moved, opening = np.zeros(len(self._seen)), np.zeros(len(self._tissue.springs.play))
        for touch in touches:
            moves, opens = self._column(touch.vertex)
            moved += moves @ touch.force
            opening += opens @ touch.force
        moved += self._reactions.displacement(opening, tuple(touch.vertex for touch in touches))
        self._answered, self._answer = touches, np.asarray(self._weights_of_seen @ moved).reshape(-1, 3)
        return self._answer

    def _column(self, vertex: int) -> tuple[FloatArray, FloatArray]:
        """What a newton on a vertex along x, y and z moves of what is seen (c, 3), and opens of the gaps (k, 3)."""
        if vertex not in self._columns:
            loads = self._weights[3 * vertex : 3 * vertex + 3].toarray()
            found = self._tissue.factors.solve(loads.T)
            self._columns[vertex] = found[self._seen], self._tissue.springs.rows @ found
        self._columns.move_to_end(vertex)
        while len(self._columns) > KEPT:
            self._columns.popitem(last=False)
        return self._columns[vertex]

    def restart(self) -> None:
        """Forget which springs took part."""
        self._touches, self._answered = (), None
        self._reactions.restart()

    def at(self, setting: Setting) -> TouchResponse:
        """See `Effect`; tissue is factorised here, so that no frame waits for it."""
        _ = self._tissue.factors
        return TouchResponse(self._tissue, self._weights, self._order, self.fields.shape[1])

    def within(self, part: Part) -> TouchResponse:
        """See `Effect`."""
        rows = (3 * part.vertices[:, None] + np.arange(3)).ravel()
        return TouchResponse(self._tissue, self._weights[rows], self._order, len(part.carriers))

    def in_axes(self, order: tuple[int, int, int]) -> TouchResponse:
        """See `Effect`."""
        x, y, z = (self._order[axis] for axis in order)
        return TouchResponse(self._tissue, self._weights, (x, y, z), self.fields.shape[1])

    def write(self, group: h5py.Group) -> None:
        """Store tissue and weights."""
        storage.write_sparse(group.create_group("stiffness"), self._tissue.upper)
        storage.write_sparse(group.create_group("weights"), self._weights)
        self._tissue.springs.write(group.create_group("springs"))
        group.attrs["carriers"], group.attrs["order"] = self.fields.shape[1], self._order

    @classmethod
    def read(cls, group: h5py.Group) -> TouchResponse:
        """Load what `write` stored."""
        x, y, z = (int(axis) for axis in group.attrs["order"])
        tissue = Tissue(storage.read_sparse(group["stiffness"]), OneSidedSprings.read(group["springs"]))
        return cls(tissue, storage.read_sparse(group["weights"]), (x, y, z), int(group.attrs["carriers"]))


def _is_number_below(vertex: object, count: int) -> bool:
    try:
        return 0 <= operator.index(vertex) < count  # type: ignore[arg-type]
    except TypeError:
        return False
