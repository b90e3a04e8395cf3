"""Contact of the tissue's surface with bones and teeth: one-sided, frictionless, a penalty with a stated tolerance.

A node at the gap g from a bone carries the pressure p(g) = p0 ((d - g) / d)^2 below the gap tolerance d, none above, on
its share A of the surface. The energy A p0 d / 3 ((d - g) / d)^3 is twice continuously differentiable; pressures below
p0 leave a gap between 0 and d. Where tissue lies nearer than d at rest (published meshes hug the bone and cut it by
tenths of a millimetre), the node's gap counts from rest, as d: rest is free of contact forces. g is the distance to the
bone, smoothed over the spacing of the nodes that slide on it: facets as coarse as the mesh would hold single nodes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from risorius.errors import InputError
from risorius.jaw import FloatArray
from risorius.mechanics.one_sided import OneSidedSprings
from risorius_offline.anatomy.anatomy import Anatomy, Surface
from risorius_offline.anatomy.folder import JAW_BONE
from risorius_offline.anatomy.surface import boundary_faces
from risorius_offline.discretisation import IntArray
from risorius_offline.effects.effect import NodeBlocks, WithoutContactPairs
from risorius_offline.effects.signed_distance import SignedDistance

# A node deeper in a bone at rest is part of the mesh's rim inside the skull, and has no contact with that bone.
DEEPEST_AT_REST = 1e-3
# Nodes that start nearer to a bone than this slide on it; the bone is smoothed over the distance between them.
SLIDES_WITHIN = 3e-3
# No step takes a node farther into a bone than this: less than half a tooth, so that it comes out where it went in.
LARGEST_APPROACH = 2e-3


@dataclass(frozen=True)
class Pose:
    """Where a bone is: x at rest has gone to rotation x + translation."""

    rotation: FloatArray
    translation: FloatArray

    def at_rest(self, points: FloatArray) -> FloatArray:
        """Where points (k, 3) are as seen from the bone at rest."""
        return (points - self.translation) @ self.rotation


STILL = Pose(np.eye(3), np.zeros(3))


class JawPose:
    """Where the jaw of an anatomy is: `pose`, for the parameters last set."""

    def __init__(self, anatomy: Anatomy) -> None:
        self._motion, self._first_weight = anatomy.jaw_motion, len(anatomy.muscles)
        self.pose = STILL

    def set_parameters(self, parameters: FloatArray) -> None:
        """Take the pose from the parameters (p,)."""
        if self._motion is None:
            return
        frame = np.concatenate([np.zeros((1, 3)), np.eye(3)])
        weights = parameters[self._first_weight :][: len(self._motion.inputs)]
        lifts = self._motion.lift_coordinates(weights)
        moved = frame + np.tensordot(lifts, self._motion.unit_motions(frame), axes=1)
        self.pose = Pose((moved[1:] - moved[0]).T, moved[0])


@dataclass(frozen=True)
class _Bone:
    """A bone with the distances (k,) at which each contact node begins to feel it, and whether it goes with the jaw."""

    distance: SignedDistance
    onset: FloatArray
    moves: bool


class BoneContact(WithoutContactPairs):
    """Contact of all boundary nodes that are not prescribed with the bones of an anatomy; the jaw's moves with it.

    gap_tolerance: d in metres; pressure: p0 in pascals, at zero gap. Raises InputError that names a bone whose surface
    is not usable.
    """

    def __init__(self, anatomy: Anatomy, gap_tolerance: float = 3e-4, pressure: float = 50e3) -> None:
        self._tolerance, self._pressure = gap_tolerance, pressure
        self._motion = anatomy.jaw_motion
        if not anatomy.bones:
            raise InputError(f"anatomy {anatomy.name!r} has no bones; contact needs the surface of one at least")
        self._node_count = len(anatomy.points)
        areas = _nodal_areas(anatomy)
        self.nodes = np.flatnonzero((areas > 0.0) & ~anatomy.prescribed)
        self.areas, self._rest = areas[self.nodes], anatomy.points[self.nodes]
        self._bones = tuple(self._bone(anatomy, name) for name in anatomy.bones)
        self._jaw, self._jaw_nodes = JawPose(anatomy), anatomy.jaw
        if self._motion is not None:  # lift coordinates (4, 3 j) of a displacement of the jaw's prescribed nodes
            motions = self._motion.unit_motions(anatomy.points[anatomy.jaw])
            self._lifts = np.linalg.pinv(motions.reshape(len(motions), -1).T)

    def set_parameters(self, parameters: FloatArray) -> None:
        """Take the pose of the jaw from the parameters (p,)."""
        self._jaw.set_parameters(parameters)

    def gaps(self, u: FloatArray) -> FloatArray:
        """Gap (k,) in metres of every contact node to its nearest bone, counted from rest where it starts below d.

        A negative gap is a penetration. Gaps above the band of the distance fields are given as the band.
        """
        return self._tolerance - np.max([self._overlap(bone, u) for bone in self._bones], axis=0)

    def energy(self, u: FloatArray) -> float:
        """Joules; finite everywhere."""
        overlaps = (np.maximum(self._overlap(bone, u), 0.0) for bone in self._bones)
        return sum(self._energy(self.areas, overlap) for overlap in overlaps)

    def add_forces(self, u: FloatArray, forces: FloatArray) -> float:
        """Add dE/du in newtons to `forces` (n, 3) and return the energy."""
        energy = 0.0
        for bone in self._bones:
            touching, overlap, gradient, _ = self._touching(bone, u)
            areas = self.areas[touching]
            pressure = self._pressure * (overlap / self._tolerance) ** 2
            forces[self.nodes[touching]] -= (areas * pressure)[:, None] * gradient
            energy += self._energy(areas, overlap)
        return energy

    def second_derivatives(self, u: FloatArray, *, project: bool) -> NodeBlocks:
        """Blocks (k, 3, 3) of the nodes in contact; with `project` their negative eigenvalues are raised to zero."""
        nodes, matrices = [np.zeros(0, dtype=np.int64)], [np.zeros((0, 3, 3))]
        for bone in self._bones:
            touching, overlap, gradient, hessian = self._touching(bone, u)
            scale = self.areas[touching] * self._pressure / self._tolerance**2
            nodes.append(self.nodes[touching])
            matrices.append(penalty_hessians(scale, overlap, gradient, hessian))
        blocks = np.concatenate(matrices)
        return NodeBlocks(np.concatenate(nodes)[:, None], positive_part(blocks) if project else blocks)

    def admits(self, u: FloatArray) -> bool:
        """Whether no node is more than 2 mm inside a bone."""
        return bool(np.min(self.gaps(u), initial=np.inf) >= -LARGEST_APPROACH)

    def push_out(self, u: FloatArray) -> None:
        """Move nodes that are more than 1 mm inside a bone to there, along the derivative of the distance."""
        for bone in self._bones:
            touching, overlap, gradient, _ = self._touching(bone, u)
            deeper = np.maximum(overlap - self._tolerance - LARGEST_APPROACH / 2, 0.0)
            u[self.nodes[touching]] += deeper[:, None] * gradient

    def largest_step(self, u: FloatArray, direction: FloatArray) -> float:
        """Fraction of `direction` (n, 3) that takes no node 2 mm into a bone, or by 2 mm where it is in one.

        The bones move with their prescribed nodes: only what tissue moves relative to them counts.
        """
        fraction = 1.0
        for bone in self._bones:
            reach = LARGEST_APPROACH + np.maximum(self._tolerance - self._overlap(bone, u), 0.0)
            length = np.linalg.norm(direction[self.nodes] - self._bone_step(bone, u, direction), axis=1)
            fraction = min(fraction, float(np.min(reach / np.maximum(length, np.finfo(float).tiny), initial=1.0)))
        return fraction

    def springs_at_rest(self, reach: float) -> OneSidedSprings:
        """What stops tissue that is at rest and comes nearer to a bone by less than `reach` metres, to first order."""
        parts = []
        for bone in self._bones:
            play = -self._overlap(bone, np.zeros((self._node_count, 3)))
            near = np.flatnonzero(play < reach)
            gradient, _ = bone.distance.derivatives(self._rest[near])
            strength = self.areas[near] * self._pressure / self._tolerance**2
            nodes = self.nodes[near, None]
            parts.append(OneSidedSprings.between(nodes, gradient[:, None], self._node_count, play[near], strength))
        return OneSidedSprings.joined(parts)

    def _bone(self, anatomy: Anatomy, name: str) -> _Bone:
        try:
            finest = SignedDistance.of(anatomy.bones[name])
        except InputError as error:
            raise InputError(f"bone {name!r}: {error}") from error
        at_rest = finest.values(self._rest)
        inside = at_rest < -DEEPEST_AT_REST
        apart = np.sqrt(self.areas[~inside & (at_rest < SLIDES_WITHIN)])
        distance = _smoothed(anatomy.bones[name], finest, float(np.median(apart)) if apart.size else 0.0)
        onset = np.where(inside, -np.inf, np.minimum(distance.values(self._rest), self._tolerance))
        return _Bone(distance, onset, name == JAW_BONE)

    def _pose(self, bone: _Bone) -> Pose:
        return self._jaw.pose if bone.moves else STILL

    def _bone_step(self, bone: _Bone, u: FloatArray, direction: FloatArray) -> FloatArray:
        """What `direction` (n, 3) does to the bone, (k, 3) at the contact nodes as if they were part of it."""
        step = np.zeros_like(self._rest)
        if bone.moves and self._motion is not None:
            lifts = self._lifts @ direction[self._jaw_nodes].ravel()
            seen = self._pose(bone).at_rest(self._rest + u[self.nodes])
            step += np.tensordot(lifts, self._motion.unit_motions(seen), axes=1)
        return step

    def _overlap(self, bone: _Bone, u: FloatArray) -> FloatArray:
        """By how much (k,) the nodes are nearer than where contact begins; negative without contact."""
        return bone.onset - bone.distance.values(self._pose(bone).at_rest(self._rest + u[self.nodes]))

    def _touching(self, bone: _Bone, u: FloatArray) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
        """Numbers (c,) among the contact nodes, overlap (c,) and derivatives of the distance where they touch."""
        overlap = self._overlap(bone, u)
        touching = np.flatnonzero(overlap > 0.0)
        pose = self._pose(bone)
        positions = pose.at_rest(self._rest[touching] + u[self.nodes[touching]])
        gradient, hessian = bone.distance.derivatives(positions)
        return touching, overlap[touching], gradient @ pose.rotation.T, pose.rotation @ hessian @ pose.rotation.T

    def _energy(self, areas: FloatArray, overlap: FloatArray) -> float:
        return self._pressure / (3.0 * self._tolerance**2) * float(areas @ overlap**3)


def _smoothed(surface: Surface, finest: SignedDistance, spacing: float) -> SignedDistance:
    """Distance smoothed over a spacing in metres, or over what a bone is thick enough for.

    The splines at the surface reach two spacings deep, where a thin bone has its other side.
    """
    while spacing > finest.spacing:
        distance = SignedDistance.of(surface, spacing)
        if -distance.coefficients.min() >= 2.0 * spacing:
            return distance
        spacing /= 2.0
    return finest


def _nodal_areas(anatomy: Anatomy) -> FloatArray:
    """Share (n,) of every node in the area of the mesh's boundary, square metres; zero inside."""
    areas = np.zeros(len(anatomy.points))
    for faces in boundary_faces(anatomy.cells):
        x = anatomy.points[faces]
        area = 0.5 * np.linalg.norm(np.cross(x, np.roll(x, -1, axis=1)).sum(axis=1), axis=1)
        np.add.at(areas, faces, area[:, None] / faces.shape[1])
    return areas


def penalty_hessians(scale: FloatArray, overlap: FloatArray, gradient: FloatArray, hessian: FloatArray) -> FloatArray:
    """Second derivatives (c, 3, 3) of scale / 3 overlap^3, by those of the distance that an overlap falls with."""
    normal = (2.0 * scale * overlap)[:, None, None] * gradient[:, :, None] * gradient[:, None, :]
    matrices: FloatArray = normal - (scale * overlap**2)[:, None, None] * hessian
    return matrices


def positive_part(matrices: FloatArray) -> FloatArray:
    """Symmetric matrices (k, 3, 3) with negative eigenvalues raised to zero."""
    values, vectors = np.linalg.eigh(matrices)
    return (vectors * np.maximum(values, 0.0)[:, None]) @ np.swapaxes(vectors, 1, 2)
