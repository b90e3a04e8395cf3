"""What is known to go wrong with a choice of elements, and by how much; docs/elements.md has the measurements."""

from __future__ import annotations

import numpy as np

from risorius.mechanics.material import Yeoh
from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.discretisation import Discretisation
from risorius_offline.jacobian_bounds import jacobian_bounds

# Above this Poisson's ratio linear tetrahedra lock.
LOCKING = 0.45
# By Poisson's ratio: relative L2 error (%) of the displacement of a layered cheek in linear tetrahedra, and in
# quadratic ones with mean dilatation that have as many nodes. Measured by benchmarks/element_choice.py slab.
ERRORS = {0.45: (13, 1.9), 0.49: (20, 1.8), 0.499: (38, 1.9)}


def advice(anatomy: Anatomy) -> tuple[str, ...]:
    """One line for each choice of elements that makes results of an anatomy a draft; none where nothing is known."""
    return (*_locking(anatomy), *_inverted(anatomy))


def _locking(anatomy: Anatomy) -> tuple[str, ...]:
    poisson = np.array([_poisson(material) for material in anatomy.materials])
    layers = [block.layer for block in anatomy.cells if block.cell_type == "tetra"]
    locking = [ratio for layer in layers for ratio in poisson[layer] if ratio > LOCKING]
    if not locking:
        return ()
    nearest = min(ERRORS, key=lambda measured: abs(measured - max(locking)))
    linear, quadratic = ERRORS[nearest]
    return (
        f"{anatomy.name}: {len(locking)} linear tetrahedra with Poisson's ratio up to {max(locking):.3g} are a draft: "
        f"at {nearest:g} a layered cheek comes out {linear} % wrong, and {quadratic} % with as many nodes in quadratic "
        "tetrahedra; export the mesh as tetra10",
    )


def _inverted(anatomy: Anatomy) -> tuple[str, ...]:
    at_rest = jacobian_bounds(Discretisation(anatomy.points, anatomy.cells), np.zeros_like(anatomy.points))
    inverted = int((at_rest.lower <= 0.0).sum())
    if not inverted:
        return ()
    return (
        f"{anatomy.name}: {inverted} cell(s) are inverted somewhere between their quadrature points at rest; J > 0 is "
        "kept at quadrature points only there; move their nodes",
    )


def _poisson(material: Yeoh) -> float:
    """Poisson's ratio of small strains."""
    shear = 2.0 * material.c10
    return (3.0 * material.bulk - 2.0 * shear) / (6.0 * material.bulk + 2.0 * shear)
