"""From the muscles of a model to what its equations take: active tensors at the points, dead loads at the nodes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
import scipy.sparse as sp

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.mechanics.fibres import FibrePoints
from risorius_offline.discretisation import Discretisation, IntArray
from risorius_offline.muscles.loads import ActiveStress, ForceDensity
from risorius_offline.muscles.muscle import Muscle


def fibre_points(discretisation: Discretisation, muscles: Sequence[Muscle]) -> list[FibrePoints]:
    """Points with active fibres of every volume block, sorted by element and point.

    They are those of the muscles whose load is an active stress; raises InputError for one without tissue.
    """
    numbers, directions, muscle, stress = _active_fields(discretisation, muscles)
    sizes = np.array([block.weights.size for block in discretisation.volumes])
    ends = sizes.cumsum()
    result = []
    for block, start, end in zip(discretisation.volumes, ends - sizes, ends, strict=True):
        here = slice(*np.searchsorted(numbers, (start, end)))
        element, point = np.divmod(numbers[here] - start, block.weights.shape[1])
        result.append(FibrePoints(element, point, directions[here], muscle[here], stress[here]))
    return result


def active_tensors(discretisation: Discretisation, fibres: Sequence[FibrePoints], muscle_count: int) -> sp.csr_matrix:
    """Sparse (6 volume quadrature points, muscles): T a0 (x) a0 of (7.2) as xx, yy, zz, xy, yz, zx, in pascals.

    Every muscle at full activation; a muscle that is a dead load has an empty column.
    """
    blocks = []
    for block, listed in zip(discretisation.volumes, fibres, strict=True):
        x, y, z = listed.direction.T
        tensors = listed.stress[:, None] * np.stack([x * x, y * y, z * z, x * y, y * z, z * x], axis=1)
        rows = 6 * (listed.element * block.weights.shape[1] + listed.point)[:, None] + np.arange(6)
        entries = (tensors.ravel(), (rows.ravel(), np.repeat(listed.muscle, 6)))
        blocks.append(sp.csr_matrix(entries, shape=(6 * block.weights.size, muscle_count)))
    return sp.vstack(blocks, format="csr")


def dead_loads(discretisation: Discretisation, muscles: Sequence[Muscle]) -> FloatArray:
    """(3 n, muscles) nodal forces in newtons of the force densities (7.3) at full activation.

    A muscle with an active stress has a zero column. Raises InputError for a muscle without tissue.
    """
    columns = np.zeros((discretisation.dof_count, len(muscles)))
    for number, muscle in enumerate(muscles):
        if isinstance(muscle.load, ForceDensity):
            with _naming(muscle):
                density = force_density(discretisation, muscle, muscle.load)
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


def force_density(discretisation: Discretisation, muscle: Muscle, load: ForceDensity) -> FloatArray:
    """(p, 3) force density (7.3) of a muscle at full activation at all volume points, N/m^3."""
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
