"""From the muscles of a model to what its equations take: active tensors at the points, dead loads at the nodes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.discretisation import Discretisation, IntArray
from risorius_offline.muscles.loads import ActiveStress, ForceDensity
from risorius_offline.muscles.muscle import Muscle


@dataclass(frozen=True)
class FibrePoints:
    """Points with active fibres, sorted by block, element and point; a point of several muscles occurs for each.

    block, element, point (k,): place in `Discretisation.volumes`. directions (k, 3): unit tangents a0. muscle (k,):
    number of the muscle. stress (k,): T at full activation, pascals.
    """

    block: IntArray
    element: IntArray
    point: IntArray
    directions: FloatArray
    muscle: IntArray
    stress: FloatArray


def fibre_points(discretisation: Discretisation, muscles: Sequence[Muscle]) -> FibrePoints:
    """Fibre points of the muscles whose load is an active stress; raises InputError for one without tissue."""
    numbers, directions, muscle, stress = _active_fields(discretisation, muscles)
    sizes = np.array([block.weights.size for block in discretisation.volumes])
    per_element = np.array([block.weights.shape[1] for block in discretisation.volumes])
    ends = sizes.cumsum()
    block = np.searchsorted(ends, numbers, side="right")
    element, point = np.divmod(numbers - (ends - sizes)[block], per_element[block])
    return FibrePoints(block, element, point, directions, muscle, stress)


def active_tensors(discretisation: Discretisation, muscles: Sequence[Muscle]) -> sp.csr_matrix:
    """Sparse (6 volume quadrature points, muscles): T a0 (x) a0 of (7.2) as xx, yy, zz, xy, yz, zx, in pascals.

    Every muscle at full activation; a muscle that is a dead load has an empty column.
    """
    numbers, directions, muscle, stress = _active_fields(discretisation, muscles)
    x, y, z = directions.T
    tensors = stress[:, None] * np.stack([x * x, y * y, z * z, x * y, y * z, z * x], axis=1)
    rows = 6 * numbers[:, None] + np.arange(6)
    count = sum(block.weights.size for block in discretisation.volumes)
    entries = (tensors.ravel(), (rows.ravel(), np.repeat(muscle, 6)))
    return sp.csr_matrix(entries, shape=(6 * count, len(muscles)))


def dead_loads(discretisation: Discretisation, muscles: Sequence[Muscle]) -> FloatArray:
    """(3 n, muscles) nodal forces in newtons of the force densities (7.3) at full activation.

    A muscle with an active stress has a zero column. Raises InputError for a muscle without tissue.
    """
    columns = np.zeros((discretisation.dof_count, len(muscles)))
    for number, muscle in enumerate(muscles):
        if isinstance(muscle.load, ForceDensity):
            with _naming(muscle):
                density = _force_density(discretisation, muscle, muscle.load)
            columns[:, number] = _nodal_forces(discretisation, density)
    return columns


def _active_fields(
    discretisation: Discretisation, muscles: Sequence[Muscle]
) -> tuple[IntArray, FloatArray, IntArray, FloatArray]:
    """Point numbers (k,) in ascending order, directions (k, 3), muscle (k,) and stress (k,) of all active stresses."""
    numbers, directions = [np.zeros(0, np.int64)], [np.zeros((0, 3))]
    owner, stress = [np.zeros(0, np.int64)], [np.zeros(0)]
    for number, muscle in enumerate(muscles):
        if isinstance(muscle.load, ActiveStress):
            with _naming(muscle):
                field = muscle.fibres.field(discretisation)
            numbers.append(field.points)
            directions.append(field.directions)
            owner.append(np.full(len(field.points), number))
            stress.append(np.full(len(field.points), muscle.load.max_stress))
    flat = np.concatenate(numbers)
    order = np.argsort(flat, kind="stable")
    return flat[order], np.concatenate(directions)[order], np.concatenate(owner)[order], np.concatenate(stress)[order]


def _force_density(discretisation: Discretisation, muscle: Muscle, load: ForceDensity) -> FloatArray:
    """(p, 3) force density at all volume points, N/m^3."""
    density = np.zeros((sum(block.weights.size for block in discretisation.volumes), 3))
    field = muscle.fibres.field(discretisation)
    density[field.points] = load.magnitude * field.directions
    if load.insertion:
        cone = load.insertion.cone.field(discretisation, muscle.fibres.insertion_end(discretisation))
        density[cone.points] = load.insertion.magnitude * cone.directions
    return density


def _nodal_forces(discretisation: Discretisation, density: FloatArray) -> FloatArray:
    """(3 n,) consistent nodal forces of a force density (p, 3) at the volume points."""
    forces = np.zeros_like(discretisation.points)
    first = 0
    for block in discretisation.volumes:
        here = density[first : first + block.weights.size].reshape(*block.weights.shape, 3)
        shapes = block.cells.element.shape_functions(block.cells.element.points)
        np.add.at(forces, block.cells.connectivity, np.einsum("qa,eq,eqi->eai", shapes, block.weights, here))
        first += block.weights.size
    return forces.ravel()


@contextmanager
def _naming(muscle: Muscle) -> Iterator[None]:
    """Put the muscle's name before what its construction or load has to say."""
    try:
        yield
    except InputError as error:
        raise InputError(f"muscle {muscle.name!r}: {error}") from error
