"""A body reduced to few weighted elements, as a model file holds it, and how it is made from snapshots."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

import h5py
import numpy as np
import numpy.typing as npt

from risorius.hyper_reduction.correction import Correction
from risorius.hyper_reduction.cubature import Cubature, choose, element_forces, node_components
from risorius.hyper_reduction.muscles import ReducedMuscles
from risorius.hyper_reduction.reduced_body import ReducedBody
from risorius.hyper_reduction.terms import Floats, Term
from risorius.hyper_reduction.tissue import Tissue
from risorius.hyper_reduction.wall import Walls
from risorius.jaw import FloatArray
from risorius.mechanics.body import Body, PassiveElements, WallCells, read_tables, write_tables

# Training states whose forces the elements have to give, and those whose mean stiffness is the metric.
FORCE_STATES, STIFFNESS_STATES = 110, 6
TOLERANCE = 1e-3  # of the forces: fewer elements than asked for will do where they miss no more
QUIET = 0.99


Table = TypeVar("Table", PassiveElements, WallCells)


@dataclass(frozen=True)
class Equilibria:
    """Training snapshots in reduced coordinates: muscle activations (s, m) and coordinates (s, r)."""

    activations: FloatArray
    states: FloatArray

    def some(self, count: int) -> Iterator[tuple[FloatArray, FloatArray]]:
        """At most so many of them, evenly chosen."""
        rows = np.unique(np.linspace(0, len(self.states) - 1, min(count, len(self.states))).astype(np.int64))
        return zip(self.activations[rows], self.states[rows], strict=True)


@dataclass(frozen=True)
class SampledBody:
    """passive, walls: weighted elements; connectivity into the sampled nodes.

    fields: (r, k, 3) displacement of these per unit coordinate, the first `lifts` of them prescribed; muscles: of the
    same coordinates; stiffness: typical, of the modal ones. quiet: length of the preconditioned residual that
    equilibria themselves have when they are projected on the modes: less tells nothing.
    """

    passive: tuple[PassiveElements, ...]
    walls: tuple[WallCells, ...]
    fields: Floats
    lifts: int
    muscles: ReducedMuscles
    stiffness: Floats
    quiet: float

    @property
    def size(self) -> int:
        """Number of elements."""
        return sum(len(table.weights) for table in self.passive) + sum(len(table.weights) for table in self.walls)

    def leading(self, rank: int) -> SampledBody:
        """Return the same with the leading modes only."""
        kept = self.lifts + rank
        muscles = ReducedMuscles(self.muscles.stiffness[:, :kept, :kept], self.muscles.pull[:, :kept])
        return replace(self, fields=self.fields[:kept], muscles=muscles, stiffness=self.stiffness[:rank, :rank])

    def within(self, coordinates: npt.NDArray[np.int64], lifts: int, muscles: npt.NDArray[np.int64]) -> SampledBody:
        """Return the same with some muscles and coordinates, so many lifts and all modes, only; the others are 0."""
        fewer = self.muscles.within(muscles, coordinates)
        return replace(self, fields=self.fields[coordinates], lifts=lifts, muscles=fewer)

    def thinned(self, every: int) -> SampledBody:
        """Return the same with one of `every` elements of each kind, counted so many times."""
        return replace(
            self,
            passive=tuple(_thinned(table, every) for table in self.passive),
            walls=tuple(_thinned(table, every) for table in self.walls),
        )

    def correction(self, dtype: npt.DTypeLike = np.float32) -> Correction:
        """Return what corrects coordinates; it owns its state."""
        terms = [Tissue(table, dtype) for table in self.passive] + [Walls(table, dtype) for table in self.walls]
        return Correction(ReducedBody(terms, self.fields.astype(dtype), self.lifts, self.muscles), self.stiffness)

    def write(self, group: h5py.Group) -> None:
        """Store all fields."""
        write_tables(group, "passive", self.passive)
        write_tables(group, "walls", self.walls)
        group["fields"], group["stiffness"] = self.fields, self.stiffness
        group["muscle_stiffness"], group["muscle_pull"] = self.muscles.stiffness, self.muscles.pull
        group.attrs["lifts"], group.attrs["quiet"] = self.lifts, self.quiet

    @classmethod
    def read(cls, group: h5py.Group) -> SampledBody:
        """Load what `write` stored."""
        return cls(
            passive=tuple(PassiveElements(**table) for table in read_tables(group, "passive")),
            walls=tuple(WallCells(**table) for table in read_tables(group, "walls")),
            fields=group["fields"][()],
            lifts=int(group.attrs["lifts"]),
            muscles=ReducedMuscles(group["muscle_stiffness"][()], group["muscle_pull"][()]),
            stiffness=group["stiffness"][()],
            quiet=float(group.attrs["quiet"]),
        )


def sample_body(
    body: Body, points: FloatArray, fields: FloatArray, lifts: int, equilibria: Equilibria, elements: int
) -> SampledBody:
    """Choose so many elements of a body with nodes `points` (n, 3) for the coordinates of `fields` (r, n, 3).

    The first `lifts` fields are prescribed. Forces are compared as the displacements that they cause, in units of a
    coordinate.
    """
    muscles = ReducedMuscles.of(body, points, fields)
    acting = (_acting(table, fields, equilibria) for table in body.walls)
    body = replace(body, walls=tuple(table for table in acting if len(table.weights)))
    terms: list[Term] = [Tissue(table) for table in body.passive] + [Walls(table) for table in body.walls]
    whole = ReducedBody(terms, fields, lifts, muscles)
    stiffness = np.mean([_stiffness(whole, *one) for one in equilibria.some(STIFFNESS_STATES)], axis=0)
    metric, modes = np.linalg.inv(stiffness), fields[lifts:]
    states = [state for _, state in equilibria.some(FORCE_STATES)]
    sizes = [len(term.connectivity) for term in terms]
    columns = np.empty((sum(sizes), len(states), len(modes)), np.float32)
    for number, state in enumerate(states):
        columns[:, number] = element_forces(terms, np.tensordot(state, fields, axes=1), modes) @ metric
    cubature = choose(columns.reshape(len(columns), -1), sizes, elements, TOLERANCE)
    sampled = _sampled(body, cubature, fields, lifts, muscles, stiffness)
    return replace(sampled, quiet=float(np.quantile(_residuals(sampled, equilibria), QUIET)))


def _acting(table: WallCells, fields: FloatArray, equilibria: Equilibria) -> WallCells:
    """Return the walls that any of the states feels: few of all."""
    term = Walls(table)
    dofs, felt = node_components(term.connectivity), np.zeros(len(table.weights), bool)
    for _, state in equilibria.some(FORCE_STATES):
        term.deform(np.ascontiguousarray(np.tensordot(state, fields, axes=1).reshape(-1)[dofs]))
        felt |= term.forces().any(axis=0)
    chosen = np.flatnonzero(felt)
    return table.weighted(chosen, np.ones(len(chosen)))


def _sampled(
    body: Body,
    cubature: Cubature,
    fields: FloatArray,
    lifts: int,
    muscles: ReducedMuscles,
    stiffness: FloatArray,
) -> SampledBody:
    """Keep the chosen elements and their nodes."""
    count = len(body.passive)
    chosen = list(zip(cubature.elements, cubature.weights, strict=True))
    passive = [table.weighted(*one) for table, one in zip(body.passive, chosen[:count], strict=True)]
    walls = [table.weighted(*one) for table, one in zip(body.walls, chosen[count:], strict=True)]
    used = [table.connectivity.ravel() for table in passive] + [table.connectivity.ravel() for table in walls]
    nodes = np.unique(np.concatenate(used))
    single = np.float32
    return SampledBody(
        passive=tuple(_renumbered(table, nodes) for table in passive if len(table.weights)),
        walls=tuple(_renumbered(table, nodes) for table in walls if len(table.weights)),
        fields=fields[:, nodes].astype(single),
        lifts=lifts,
        muscles=ReducedMuscles(muscles.stiffness.astype(single), muscles.pull.astype(single)),
        stiffness=stiffness,
        quiet=0.0,
    )


def _thinned(table: Table, every: int) -> Table:
    chosen = np.arange(0, len(table.weights), every)
    return table.weighted(chosen, np.full(len(chosen), float(every)))


def _renumbered(table: Table, nodes: npt.NDArray[np.int64]) -> Table:
    return replace(table, connectivity=np.searchsorted(nodes, table.connectivity))


def _stiffness(whole: ReducedBody, activations: FloatArray, state: FloatArray) -> FloatArray:
    whole.set_activations(activations)
    whole.deform(state)
    return whole.stiffness()


def _residuals(sampled: SampledBody, equilibria: Equilibria) -> list[float]:
    correction, residuals = sampled.correction(), []
    for activations, state in zip(equilibria.activations, equilibria.states, strict=True):
        correction.body.set_activations(activations)
        residuals.append(correction.residual(state))
    return residuals
