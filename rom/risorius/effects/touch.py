"""Forces on the skin: the displacement K^-1 f of linear elasticity at rest, added to the face as it is.

The stiffness of the tissue is kept, sparse, and factorised when an engine is made. What a force on a vertex does is
solved for when that vertex is first touched, and kept while it is one of the last that were. Bones and teeth close
behind the skin would stop a finger that presses; where snapshots know of them, this is no model of a touch.
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
from risorius.errors import InputError
from risorius.evaluators.setting import Setting
from risorius.jaw import FloatArray
from risorius.mechanics.stiffness import stiffness
from risorius.part import Part
from risorius.snapshot_file import SnapshotSet

FARTHEST = 5e-3  # metres: of larger displacements, linear response tells too little
KEPT = 32  # vertices


class Tissue:
    """Tissue at rest: upper (m, m), the upper triangle of its stiffness in N/m, sparse."""

    def __init__(self, upper: sp.csr_matrix) -> None:
        self.upper = upper

    @cached_property
    def factors(self) -> spla.SuperLU:
        """Factors of the stiffness."""
        return spla.splu((self.upper + sp.triu(self.upper, 1).T).tocsc())


class TouchResponse:
    """tissue at rest; weights (3 n, m), sparse: displacement of the visible vertices, component by component, from that
    of the tissue, in the frame of the head; order: of the components that are asked for.
    """

    name: ClassVar[str] = "touch"
    needs: ClassVar[str] = "snapshots without contact and without the force-length relation"
    energy: ClassVar[float] = 0.0

    def __init__(self, tissue: Tissue, weights: sp.csr_matrix, order: tuple[int, int, int], carriers: int) -> None:
        self.fields: npt.NDArray[np.float32] = np.zeros((0, carriers, 3), np.float32)
        self._tissue, self._weights, self._order = tissue, weights, order
        self._columns: OrderedDict[int, npt.NDArray[np.float32]] = OrderedDict()
        self._touches: tuple[Touch, ...] = ()

    @classmethod
    def train(cls, snapshots: SnapshotSet, fields: FloatArray) -> TouchResponse | None:
        """See `Effect`."""
        body, surface = snapshots.body, snapshots.surface
        if body is None or snapshots.contact is not None:
            return None
        free = np.flatnonzero(~np.repeat(body.prescribed, 3))
        at_rest = stiffness(body, np.zeros_like(snapshots.points), np.zeros(len(snapshots.muscles)))
        weights = sp.kron(surface.weights, sp.identity(3), format="csr")[:, free]
        carriers = len(np.unique(surface.weights.indices))
        return cls(Tissue(sp.triu(at_rest[free][:, free], format="csr")), weights.tocsr(), (0, 1, 2), carriers)

    def check(self, surroundings: Surroundings) -> None:
        """Refuse touches of no vertex, and those that move tissue too far."""
        if not surroundings.touches:
            return
        count = self._weights.shape[0] // 3
        for touch in surroundings.touches:
            if not _is_number_below(touch.vertex, count):
                raise InputError(f"touch: there is no vertex {touch.vertex!r}; give one of 0 to {count - 1}")
        farthest = max(self._distance(touch.vertex, surroundings.touches) for touch in surroundings.touches)
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

    def finish(self, coordinates: FloatArray, vertices: npt.NDArray[np.float32]) -> None:
        """Move the touched skin."""
        if self._touches:
            vertices += self._moved(self._touches).reshape(-1, 3)

    def _moved(self, touches: tuple[Touch, ...]) -> npt.NDArray[np.float32]:
        """Displacement (3 n,) of the vertices."""
        moved = np.zeros(self._weights.shape[0], np.float32)
        for touch in touches:
            moved += self._column(touch.vertex) @ touch.force.astype(np.float32)
        return moved

    def _distance(self, vertex: int, touches: tuple[Touch, ...]) -> float:
        """How far a vertex moves: nothing moves farther than what is touched."""
        rows = slice(3 * vertex, 3 * vertex + 3)
        return float(np.linalg.norm(sum(self._column(touch.vertex)[rows] @ touch.force for touch in touches)))

    def _column(self, vertex: int) -> npt.NDArray[np.float32]:
        """Displacement (3 n, 3) of the vertices by a newton on one of them along x, y and z of the head."""
        if vertex not in self._columns:
            loads = self._weights[3 * vertex : 3 * vertex + 3].toarray()
            found = (self._weights @ self._tissue.factors.solve(loads.T)).reshape(-1, 3, 3)
            self._columns[vertex] = np.ascontiguousarray(found[:, list(self._order)].reshape(-1, 3), np.float32)
        self._columns.move_to_end(vertex)
        while len(self._columns) > KEPT:
            self._columns.popitem(last=False)
        return self._columns[vertex]

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
        group.attrs["carriers"], group.attrs["order"] = self.fields.shape[1], self._order

    @classmethod
    def read(cls, group: h5py.Group) -> TouchResponse:
        """Load what `write` stored."""
        x, y, z = (int(axis) for axis in group.attrs["order"])
        tissue, weights = Tissue(storage.read_sparse(group["stiffness"])), storage.read_sparse(group["weights"])
        return cls(tissue, weights, (x, y, z), int(group.attrs["carriers"]))


def _is_number_below(vertex: object, count: int) -> bool:
    try:
        return 0 <= operator.index(vertex) < count  # type: ignore[arg-type]
    except TypeError:
        return False
