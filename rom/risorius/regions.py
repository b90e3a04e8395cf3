"""Regions of a face by name: where the muscles of mouth, eyes or brows move the skin, whatever face it is."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from risorius.errors import InputError
from risorius.evaluators import Superposition
from risorius.inputs import without_side
from risorius.jaw import FloatArray
from risorius.model import ReducedModel

Numbers = npt.NDArray[np.int64]

MOVERS: dict[str, tuple[str, ...]] = {
    "mouth": (
        "orbicularis_oris",
        "incisivus",
        "levator_labii_superioris",
        "levator_anguli_oris",
        "zygomaticus",
        "risorius",
        "depressor_anguli_oris",
        "depressor_labii",
        "mentalis",
    ),
    "eyes": ("orbicularis_oculi", "levator_palpebrae", "upper_lid"),
    "brows": ("frontalis", "corrugator", "depressor_supercilii", "procerus"),
}
"""How the names of the parameters of each region begin."""
# Of what a muscle does where it moves the skin most; without the weaker parts a mouth has a gap above the chin.
SHARES = {"mouth": 0.3, "eyes": 0.5, "brows": 0.5}


def region_vertices(model: ReducedModel, region: str | tuple[int, ...]) -> Numbers:
    """Numbers (n,) of the vertices of a region, ascending.

    A named one is where one of its muscles alone, at full activation, moves the skin by one of SHARES
    of its largest motion. Raises InputError for vertices that do not exist, or where the model has none of them.
    """
    count = len(model.rest_vertices)
    if region == "full":
        return np.arange(count)
    if isinstance(region, str):
        return _moved(model, region)
    numbers = np.unique(np.array(region, np.int64))
    outside = numbers[(numbers < 0) | (numbers >= count)]
    if len(outside) or not len(numbers):
        raise InputError(
            f"scene: region: {'no vertex' if not len(numbers) else f'vertex {outside[0]}'} given; "
            f"give numbers from 0 to {count - 1}"
        )
    return numbers


def triangles_within(triangles: npt.NDArray[np.int32], vertices: Numbers) -> npt.NDArray[np.int32]:
    """Triangles (t, 3) whose three corners are among some vertices (n,), in the numbers of these."""
    number = np.full(max(int(triangles.max(initial=-1)), int(vertices.max(initial=-1))) + 1, -1, np.int32)
    number[vertices] = np.arange(len(vertices))
    found = number[triangles]
    return np.ascontiguousarray(found[(found >= 0).all(axis=1)])


def _moved(model: ReducedModel, region: str) -> Numbers:
    chosen = [
        number for number, name in enumerate(model.inputs.parameters) if without_side(name).startswith(MOVERS[region])
    ]
    if not chosen:
        raise InputError(
            f"scene: region: {region!r} is where {', '.join(MOVERS[region])} move the skin, and model {model.name!r} "
            "has none of them; give vertex numbers"
        )
    inside = np.zeros(len(model.rest_vertices), bool)
    for number in chosen:
        size = np.linalg.norm(_single_action(model, number), axis=1)
        inside |= size >= SHARES[region] * size.max()
    whole = model.triangles[inside[model.triangles].all(axis=1)]
    return np.unique(whole).astype(np.int64)  # a vertex without a triangle is not seen


def _single_action(model: ReducedModel, parameter: int) -> FloatArray:
    """Displacement (n, 3) of one parameter at weight 1, metres."""
    superposition = model.evaluators[Superposition.name]
    weights = np.zeros(len(model.inputs.parameters))
    weights[parameter] = 1.0
    coordinates = np.zeros(model.rank)
    model.poses.lift_coordinates(weights[len(model.inputs.muscles) :], out=coordinates[: model.lifts])
    superposition.coordinates(weights, coordinates[model.lifts :])
    basis = model.carried_basis
    carried = np.tensordot(coordinates, basis.fields, axes=1)
    return np.asarray(basis.weights @ carried)
