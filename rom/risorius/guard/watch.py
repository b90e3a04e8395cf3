"""Where tissue folds first: few points whose J tells whether a state of the face is one that tissue can be in."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import h5py
import numpy as np
import numpy.typing as npt

from risorius.evaluators import Evaluator
from risorius.inputs import InputTable
from risorius.jaw import FloatArray
from risorius.mechanics.body import Body
from risorius.poses import Poses
from risorius.whole_steps import rounded_fields

POINTS = 128
RANDOM_STATES = 256  # of the evaluator, for inputs that no snapshot was made of
ACTIVE_SHARES = (0.1, 0.3, 1.0)  # of the inputs of a random state
SQUEEZED = 0.5  # J: a point that samples do not squeeze further is not about to fold
NEGLIGIBLE_CHANGE = 0.02  # of J, by coordinates that a part of a model is without
BLOCK = 1024  # points whose J are found at once


@dataclass(frozen=True)
class Watch:
    """gradients: (r, k, 9) float32, deformation gradient less identity at k points, row by row, per unit coordinate.
    Those of bodies and of files are rounded to 16 bits, so that reading them takes half the time.

    longest: Euclidean length of the longest modal coordinates that training has seen an equilibrium have.
    places: (k, 3), metres, middles of the elements at rest that the points are in; None where nobody knows.
    """

    gradients: npt.NDArray[np.float32]
    longest: float
    places: FloatArray | None = None

    def __len__(self) -> int:
        return self.gradients.shape[1]

    def leading(self, count: int) -> Watch:
        """Return that of the first coordinates only."""
        return replace(self, gradients=self.gradients[:count])

    def within(self, coordinates: npt.NDArray[np.int64], states: FloatArray) -> Watch | None:
        """Return that of some coordinates, at points that states (s, r) squeeze and the others hardly have a part in.

        None where there is no such point.
        """
        lost = np.abs(states).max(axis=0)
        lost[coordinates] = 0.0
        change = np.tensordot(lost, np.linalg.norm(self.gradients, axis=2), axes=1)
        smallest = np.min([self.jacobians(state) for state in states], axis=0)
        points = np.flatnonzero((change <= NEGLIGIBLE_CHANGE) & (smallest < SQUEEZED))
        if not len(points):
            return None
        gradients = np.ascontiguousarray(self.gradients[np.ix_(coordinates, points)])
        return replace(self, gradients=gradients, places=None if self.places is None else self.places[points])

    def in_axes(self, order: tuple[int, int, int]) -> Watch:
        """Return that of a model whose places have their components in another order."""
        return self if self.places is None else replace(self, places=np.ascontiguousarray(self.places[:, list(order)]))

    def jacobians(self, coordinates: FloatArray) -> FloatArray:
        """J (k,) of coordinates (r,), or fewer: what is left out is zero."""
        used = min(len(coordinates), len(self.gradients))
        change = np.tensordot(coordinates[:used], self.gradients[:used].astype(np.float64), axes=1)
        return np.asarray(np.linalg.det(np.eye(3) + change.reshape(-1, 3, 3)))

    def write(self, group: h5py.Group) -> None:
        """Store all fields."""
        group["gradients"] = self.gradients
        group.attrs["longest"] = self.longest
        if self.places is not None:
            group["places"] = self.places

    @classmethod
    def read(cls, group: h5py.Group) -> Watch:
        """Load what `write` stored."""
        places = group["places"][()] if "places" in group else None
        return cls(rounded_fields(group["gradients"][()]), float(group.attrs["longest"]), places)

    @classmethod
    def choose(
        cls, body: Body, nodes: FloatArray, fields: FloatArray, lifts: int, equilibria: FloatArray, others: FloatArray
    ) -> Watch:
        """Choose points of a body, for coordinates of fields (r, n, 3) of its nodes (n, 3), `lifts` of the poses first.

        equilibria (s, r): states that the face takes; others (t, r): states that an evaluator gives, folded or not.
        Points are taken that tell of most folded states, until every folded state is told of by as many as there is
        room for; without folded states, those that are squeezed most.
        """
        states = np.concatenate([equilibria, others])
        folded, smallest = [], []
        for gradients in _gradients(body, fields):
            jacobians = _jacobians(gradients, states)
            folded.append(jacobians <= 0.0)
            smallest.append(jacobians.min(axis=0))
        chosen = np.sort(_covering(np.concatenate(folded, axis=1), np.concatenate(smallest), POINTS))
        longest = float(np.linalg.norm(equilibria[:, lifts:], axis=1).max())
        gradients = rounded_fields(_at(chosen, _gradients(body, fields)).transpose(2, 0, 1))
        return cls(gradients, longest, _middles(body, nodes)[chosen])


def random_states(evaluator: Evaluator, inputs: InputTable, poses: Poses, rank: int) -> FloatArray:
    """Coordinates (RANDOM_STATES, lifts + rank) of an evaluator for random inputs, few of them active to all."""
    rng, names, lifts = np.random.default_rng(0), len(inputs.names), poses.lift_count
    states = np.empty((RANDOM_STATES, lifts + rank))
    for number, state in enumerate(states):
        active = rng.random(names) < ACTIVE_SHARES[number % len(ACTIVE_SHARES)]
        weights = np.where(active, rng.uniform(inputs.lower, 1.0), 0.0)
        parameters = inputs.to_parameters(weights)
        poses.lift_coordinates(parameters[len(inputs.muscles) :], out=state[:lifts])
        evaluator.coordinates(parameters, state[lifts:])
    return states


def _gradients(body: Body, fields: FloatArray) -> Iterator[npt.NDArray[np.float32]]:
    """(b, 9, r) of block after block of the points of the tissue."""
    for table in body.passive:
        points = table.weights.shape[1]
        elements = max(BLOCK // points, 1)
        for start in range(0, len(table.weights), elements):
            here = slice(start, start + elements)
            nodal = fields[:, table.connectivity[here]]
            change = np.einsum("reai,eqaj->eqijr", nodal, table.gradients[here], optimize=True)
            yield change.reshape(-1, 9, len(fields)).astype(np.float32)


def _middles(body: Body, nodes: FloatArray) -> FloatArray:
    """(p, 3) middles of the elements that the points of the tissue are in, of nodes (n, 3)."""
    middles = [
        np.repeat(nodes[table.connectivity].mean(axis=1), table.weights.shape[1], axis=0) for table in body.passive
    ]
    return np.concatenate(middles)


def _at(chosen: npt.NDArray[np.int64], blocks: Iterator[npt.NDArray[np.float32]]) -> npt.NDArray[np.float32]:
    """Rows of blocks that follow each other, chosen in order; all of them together may not fit in memory."""
    kept, start = [], 0
    for block in blocks:
        kept.append(block[chosen[(chosen >= start) & (chosen < start + len(block))] - start])
        start += len(block)
    return np.concatenate(kept)


def _jacobians(gradients: npt.NDArray[np.float32], states: FloatArray) -> FloatArray:
    """J (s, b) of states (s, r) at points with gradients (b, 9, r)."""
    change = (gradients @ states.T.astype(np.float32)).transpose(2, 0, 1)
    return np.asarray(np.linalg.det(np.eye(3) + change.reshape(*change.shape[:2], 3, 3)))


def _covering(folded: npt.NDArray[np.bool_], smallest: FloatArray, count: int) -> npt.NDArray[np.int64]:
    """Numbers of points: greedily those of most folded states (s, p) that fewest of the taken ones tell of yet."""
    candidates = np.flatnonzero(folded.any(axis=0))
    told, matrix = np.zeros(len(folded)), folded[:, candidates].astype(np.float64)
    taken: list[int] = []
    for _ in range(min(count, len(candidates))):
        worth = (0.5**told) @ matrix
        worth[taken] = -1.0
        taken.append(int(worth.argmax()))
        told += matrix[:, taken[-1]]
    chosen = candidates[taken]
    others = np.argsort(smallest)
    others = others[~np.isin(others, chosen)]
    return np.concatenate([chosen, others[: count - len(chosen)]])
