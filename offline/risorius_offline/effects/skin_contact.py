"""Contact of the skin that is seen, between the nodes that carry it, with the teeth that are seen.

Nodes slide on bones that are smoothed over the distance between them (`bone_contact.py`), and a lip whose rim gets past
the edge of such a bone may curl around it into a tooth. A point x = X + W u of the visible surface, with the weights W
of the nodes that carry it, at the gap g from a tooth has the energy A p0 d / 3 ((d - g) / d)^3 below the gap tolerance
d, none above, A its share of the surface. Where it lies nearer than d at rest, its gap counts from rest, as d: rest is
free of contact forces.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from risorius.companion import JAW, Companion
from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius_offline.anatomy.anatomy import Anatomy, Surface
from risorius_offline.contact_geometry import TEETH
from risorius_offline.discretisation import IntArray
from risorius_offline.effects.bone_contact import STILL, JawPose, Pose, penalty_hessians, positive_part
from risorius_offline.effects.contact_surface import ContactSurface
from risorius_offline.effects.effect import NodeBlocks, Unobstructed
from risorius_offline.effects.signed_distance import SignedDistance
from risorius_offline.effects.skin_points import carriers

GAP_TOLERANCE, PRESSURE = 1e-3, 50e3  # metres; pascals at zero gap
REACH = 5.5e-3  # from teeth at rest; what of the built-in head's skin gets into them lies nearer


@dataclass(frozen=True)
class _Tooth:
    """A row of teeth with the distances (k,) at which points begin to feel it, and whether it goes with the jaw."""

    distance: SignedDistance
    onset: FloatArray
    moves: bool


class SkinContact(Unobstructed):
    """The effect for an anatomy that has teeth among its companions.

    weights (k, n): of the nodes that carry the k points. Raises InputError that names teeth that are not usable.
    """

    def __init__(self, anatomy: Anatomy) -> None:
        skin, teeth = anatomy.visible_surface, teeth_of(anatomy)
        distances = {name: _distance(name, item) for name, item in teeth.items()}
        at_rest = {name: distance.values(skin.points) for name, distance in distances.items()}
        near = np.any([at_rest[name] < REACH for name in teeth], axis=0)
        areas = ContactSurface.of_triangles(skin.points, skin.triangles).areas
        self.weights, self._rest = sp.csr_matrix(skin.weights)[near], skin.points[near]
        self._scale = areas[near] * PRESSURE / GAP_TOLERANCE**2
        self._jaw = JawPose(anatomy)
        self._teeth = tuple(
            _Tooth(distances[name], np.minimum(at_rest[name][near], GAP_TOLERANCE), item.moves_with == JAW)
            for name, item in teeth.items()
        )

    def set_parameters(self, parameters: FloatArray) -> None:
        """Take the pose of the jaw from the parameters (p,)."""
        self._jaw.set_parameters(parameters)

    def energy(self, u: FloatArray) -> float:
        """Joules; finite everywhere."""
        places = self._places(u)
        return sum(self._energy(self._scale, np.maximum(self._overlap(t, places), 0.0)) for t in self._teeth)

    def add_forces(self, u: FloatArray, forces: FloatArray) -> float:
        """Add dE/du in newtons to `forces` (n, 3) and return the energy."""
        energy = 0.0
        for touching, overlap, gradient, _ in self._touching(u):
            scale = self._scale[touching]
            forces -= self.weights[touching].T @ ((scale * overlap**2)[:, None] * gradient)
            energy += self._energy(scale, overlap)
        return energy

    def second_derivatives(self, u: FloatArray, *, project: bool) -> NodeBlocks:
        """A block for every point in contact."""
        points, matrices = [], []
        for touching, overlap, gradient, hessian in self._touching(u):
            points.append(touching)
            matrices.append(penalty_hessians(self._scale[touching], overlap, gradient, hessian))
        if not points:
            return NodeBlocks.none()
        nodes, shares = carriers(self.weights[np.concatenate(points)])
        found = np.concatenate(matrices)
        blocks = np.einsum("ka,kij,kb->kaibj", shares, positive_part(found) if project else found, shares)
        size = 3 * nodes.shape[1]
        return NodeBlocks(nodes, blocks.reshape(-1, size, size))

    def _places(self, u: FloatArray) -> FloatArray:
        places: FloatArray = self._rest + self.weights @ u
        return places

    def _overlap(self, tooth: _Tooth, places: FloatArray) -> FloatArray:
        return tooth.onset - tooth.distance.values(self._pose(tooth).at_rest(places))

    def _pose(self, tooth: _Tooth) -> Pose:
        return self._jaw.pose if tooth.moves else STILL

    def _touching(self, u: FloatArray) -> Iterator[tuple[IntArray, FloatArray, FloatArray, FloatArray]]:
        """Of teeth that points touch: numbers (c,) of these, overlap (c,) and derivatives of the distance there."""
        places = self._places(u)
        for tooth in self._teeth:
            overlap, pose = self._overlap(tooth, places), self._pose(tooth)
            touching = np.flatnonzero(overlap > 0.0)
            if len(touching):
                gradient, hessian = tooth.distance.derivatives(pose.at_rest(places[touching]))
                turned = pose.rotation @ hessian @ pose.rotation.T
                yield touching, overlap[touching], gradient @ pose.rotation.T, turned

    def _energy(self, scale: FloatArray, overlap: FloatArray) -> float:
        return float(scale @ overlap**3) / 3.0


def teeth_of(anatomy: Anatomy) -> dict[str, Companion]:
    """Companions of an anatomy that are teeth."""
    return {name: item for name, item in anatomy.companions.items() if name.startswith(TEETH)}


def _distance(name: str, teeth: Companion) -> SignedDistance:
    try:
        return SignedDistance.of(Surface(teeth.points, teeth.triangles))
    except InputError as error:
        raise InputError(f"{name!r}: {error}") from error
