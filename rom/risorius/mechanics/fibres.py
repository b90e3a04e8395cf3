"""Muscle fibres whose active stress depends on their stretch: energy, forces, tangent and integrals over the muscles.

A fibre point contributes w T a W(stretch) to the energy: stretch |F a0|, w its volume (m3), T the stress (Pa) at full
activation and unit stretch, a the activation of its muscle, W' = f the law. Its first Piola-Kirchhoff stress is
T a f n (x) a0 with n the direction of F a0: f scales force per undeformed area.

Arrays of one block of cells: u (n, 3), connectivity (e, a), gradients (e, q, a, 3), weights (e, q) as in `elements`,
activations (m,). SI units. The stretch must be positive, which it is where J > 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np
import numpy.typing as npt

from risorius.mechanics.point import inlined

_compiled = numba.njit(cache=True, error_model="numpy", fastmath={"contract", "nsz", "arcp", "reassoc"})

# Laws, for the argument `law` of the kernels.
PROPORTIONAL = 0
HILL = 1

# Width of the active force-length curve (Thelen 2003, Table 1).
GAMMA = 0.45


class FibrePoints(NamedTuple):
    """Fibre points of one block, in any order (the tangent is fastest by element): arrays of length k.

    element, point: where in the block's (e, q). direction (k, 3): unit vectors a0. muscle: number in the activations.
    stress: T, pascals. A point of several muscles is listed once for each.
    """

    element: npt.NDArray[np.int64]
    point: npt.NDArray[np.int64]
    direction: npt.NDArray[np.float64]
    muscle: npt.NDArray[np.int64]
    stress: npt.NDArray[np.float64]


@inlined
def proportional(stretch):  # type: ignore[no-untyped-def]
    """W = stretch^2 / 2, f and f': constant stress T a0 (x) a0 in the undeformed tissue, (7.2)."""
    return 0.5 * stretch * stretch, stretch, 1.0


@inlined
def hill(stretch):  # type: ignore[no-untyped-def]
    """W, f = exp(-(stretch - 1)^2 / gamma) and f': Hill's active force-length relation (Thelen 2003); W(1) = 0."""
    x = stretch - 1.0
    f = math.exp(-x * x / GAMMA)
    return 0.5 * math.sqrt(math.pi * GAMMA) * math.erf(x / math.sqrt(GAMMA)), f, -2.0 * x / GAMMA * f


@_compiled
def force_length(law, stretch):  # type: ignore[no-untyped-def]
    """W, f and f' of a law at a stretch, without unit."""
    if law == HILL:
        return hill(stretch)
    return proportional(stretch)


@_compiled
def _stretch(u, nodes, gradient, direction, along, n):  # type: ignore[no-untyped-def]
    """Stretch of a fibre; writes the derivatives of the shape functions along it (a,) and its unit direction n (3,)."""
    n[:] = direction
    for a in range(len(nodes)):
        along[a] = gradient[a, 0] * direction[0] + gradient[a, 1] * direction[1] + gradient[a, 2] * direction[2]
        for i in range(3):
            n[i] += u[nodes[a], i] * along[a]
    stretch = math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2])
    for i in range(3):
        n[i] /= stretch
    return stretch


@_compiled
def energy_and_forces(  # type: ignore[no-untyped-def]
    u, connectivity, gradients, weights, fibres, activations, law, with_forces, forces
):
    """Energy (J) of the fibres; adds their nodal forces dE/du (N) to `forces` (n, 3)."""
    along, n = np.empty(connectivity.shape[1]), np.empty(3)
    total = 0.0
    for k in range(len(fibres.element)):
        e, q = fibres.element[k], fibres.point[k]
        scale = weights[e, q] * fibres.stress[k] * activations[fibres.muscle[k]]
        if scale == 0.0:
            continue
        nodes = connectivity[e]
        W, f, _ = force_length(law, _stretch(u, nodes, gradients[e, q], fibres.direction[k], along, n))
        total += scale * W
        if with_forces:
            for a in range(len(nodes)):
                for i in range(3):
                    forces[nodes[a], i] += scale * f * n[i] * along[a]
    return total


@_compiled
def add_muscle_forces(u, connectivity, gradients, weights, fibres, law, columns):  # type: ignore[no-untyped-def]
    """Add the nodal forces dE/du (N) of every muscle at full activation to `columns` (n, 3, m).

    They are the derivatives of the nodal forces by the activations: an equilibrium follows these by -K^-1 columns.
    """
    along, n = np.empty(connectivity.shape[1]), np.empty(3)
    for k in range(len(fibres.element)):
        e, q = fibres.element[k], fibres.point[k]
        nodes = connectivity[e]
        _, f, _ = force_length(law, _stretch(u, nodes, gradients[e, q], fibres.direction[k], along, n))
        f *= weights[e, q] * fibres.stress[k]
        for a in range(len(nodes)):
            for i in range(3):
                columns[nodes[a], i, fibres.muscle[k]] += f * n[i] * along[a]


@_compiled
def _add_stiffness(along, n, axial, across, K, S):  # type: ignore[no-untyped-def]
    """Add the stiffness of a fibre: `across` to S (a, a), for every component alike; axial - across along n to K."""
    nodes = len(along)
    for a in range(nodes):
        for b in range(nodes):
            S[a, b] += across * along[a] * along[b]
        for i in range(3):
            row = (axial - across) * n[i] * along[a]
            for b in range(nodes):
                for j in range(3):
                    K[3 * a + i, 3 * b + j] += row * n[j] * along[b]


@_compiled
def _scatter(K, S, positions, values):  # type: ignore[no-untyped-def]
    """Add K + S (x) I to the stored entries of a sparse matrix, and clear both."""
    for a in range(S.shape[0]):
        for i in range(3):
            for b in range(S.shape[0]):
                K[3 * a + i, 3 * b + i] += S[a, b]
    for r in range(K.shape[0]):
        for c in range(K.shape[1]):
            if positions[r, c] >= 0:
                values[positions[r, c]] += K[r, c]
    K[:] = 0.0
    S[:] = 0.0


@_compiled
def tangent(  # type: ignore[no-untyped-def]
    u, connectivity, gradients, weights, fibres, activations, law, project, scatter, values
):
    """Add the second derivatives of the energy (N/m) to `values`, the entries of a sparse matrix.

    scatter (e, 3 a, 3 a): position in `values` of every entry, -1 for entries that are not stored. `project` leaves
    out the negative stiffness f' along a fibre that is longer than at its best.
    """
    count, nodes = len(fibres.element), connectivity.shape[1]
    along, n = np.empty(nodes), np.empty(3)
    K, S = np.zeros((3 * nodes, 3 * nodes)), np.zeros((nodes, nodes))
    waiting = False
    for k in range(count):
        e, q = fibres.element[k], fibres.point[k]
        scale = weights[e, q] * fibres.stress[k] * activations[fibres.muscle[k]]
        if scale != 0.0:
            waiting = True
            stretch = _stretch(u, connectivity[e], gradients[e, q], fibres.direction[k], along, n)
            _, f, slope = force_length(law, stretch)
            if project:
                slope = max(slope, 0.0)
            _add_stiffness(along, n, scale * slope, scale * f / stretch, K, S)
        if waiting and (k + 1 == count or fibres.element[k + 1] != e):
            _scatter(K, S, scatter[e], values)
            waiting = False


@_compiled
def add_integrals(u, connectivity, gradients, weights, fibres, activations, law, sums):  # type: ignore[no-untyped-def]
    """Add integrals over the undeformed volume of every muscle to `sums` (m, 4).

    Its volume (m3); its volume times stretch (m3; over the volume, the mean stretch); the integral of the fibre stress
    T a f (N m; over the length of the muscle, its force); the energy T a (W(1) - W) that it has released (J).
    """
    along, n = np.empty(connectivity.shape[1]), np.empty(3)
    at_rest, _, _ = force_length(law, 1.0)
    for k in range(len(fibres.element)):
        e, q, m = fibres.element[k], fibres.point[k], fibres.muscle[k]
        stretch = _stretch(u, connectivity[e], gradients[e, q], fibres.direction[k], along, n)
        W, f, _ = force_length(law, stretch)
        stress = fibres.stress[k] * activations[m]
        sums[m, 0] += weights[e, q]
        sums[m, 1] += weights[e, q] * stretch
        sums[m, 2] += weights[e, q] * stress * f
        sums[m, 3] += weights[e, q] * stress * (at_rest - W)
