"""Moving skin out of what it has been found in; nothing is allocated, nothing is random.

Loops are in functions that call none with arrays: numba would count references to each of them at every call.
"""

from __future__ import annotations

import math

import numba

from risorius.effects.contact_gaps import approach, deepest
from risorius.effects.contact_patches import below, take_off_shifts, take_off_shifts_apart

_compiled = numba.njit(cache=True, error_model="numpy")

SWEEPS = 5  # at most, of a frame
LITTLE, FIRST = 0.2e-3, 2  # metres: no sweep for less after the first ones
ENOUGH = 0.1e-3  # metres: no sweep for less
GAIN = 1.25  # of a sweep, which moves by weighted means and so falls short of the deepest
SHARED = 0.75  # of a depth in the other lip, which gives way, too
SPARE = 0.1e-3  # metres: what is moved out goes so far beyond, for what lies between the points
FARTHEST = 8e-3  # metres: no more is moved in a frame, whatever is wanted


@_compiled
def gather(vertices, gaps, ways, factor, starts, controls, shares, wanted, total):  # type: ignore[no-untyped-def]
    """Add what points with a negative gap want of the controls, weighted by depth."""
    for number in range(len(vertices)):
        depth = -gaps[number]
        if depth <= 0.0:
            continue
        depth = factor * (depth + SPARE)
        dx, dy, dz = depth * ways[number, 0], depth * ways[number, 1], depth * ways[number, 2]
        p = vertices[number]
        for entry in range(starts[p], starts[p + 1]):
            share, control = shares[entry] * depth, controls[entry]
            total[control] += share
            wanted[control, 0] += share * dx
            wanted[control, 1] += share * dy
            wanted[control, 2] += share * dz


@_compiled
def move(x, wanted, total, moved, shifts, acting, starts, vertices, shares):  # type: ignore[no-untyped-def]
    """Move the vertices by what is wanted of the controls in the mean, up to FARTHEST in all; nothing is wanted then.

    moved (c, 3): by how much the controls have moved in this frame; shifts (n, 3): the vertices now, by those that are
    acting (c,), zero elsewhere. Returns metres that any vertex has moved now at the most.
    """
    for control in range(len(acting)):
        if acting[control]:
            for entry in range(starts[control], starts[control + 1]):
                vertex = vertices[entry]
                shifts[vertex, 0], shifts[vertex, 1], shifts[vertex, 2] = 0.0, 0.0, 0.0
        acting[control] = total[control] > 0.0
    for control in range(len(acting)):
        if not acting[control]:
            continue
        scale = GAIN / total[control]
        dx, dy, dz = wanted[control, 0] * scale, wanted[control, 1] * scale, wanted[control, 2] * scale
        wanted[control, 0], wanted[control, 1], wanted[control, 2], total[control] = 0.0, 0.0, 0.0, 0.0
        ax, ay, az = moved[control, 0] + dx, moved[control, 1] + dy, moved[control, 2] + dz
        short = min(1.0, FARTHEST / max(math.sqrt(ax * ax + ay * ay + az * az), 1e-12))
        dx, dy, dz = short * ax - moved[control, 0], short * ay - moved[control, 1], short * az - moved[control, 2]
        moved[control, 0], moved[control, 1], moved[control, 2] = short * ax, short * ay, short * az
        for entry in range(starts[control], starts[control + 1]):
            vertex, share = vertices[entry], shares[entry]
            a, b, c = share * dx, share * dy, share * dz
            shifts[vertex, 0] += a
            shifts[vertex, 1] += b
            shifts[vertex, 2] += c
            x[vertex, 0] += a
            x[vertex, 1] += b
            x[vertex, 2] += c
    square = 0.0
    for control in range(len(acting)):
        if acting[control]:
            for entry in range(starts[control], starts[control + 1]):
                vertex = vertices[entry]
                a, b, c = shifts[vertex, 0], shifts[vertex, 1], shifts[vertex, 2]
                square = max(square, a * a + b * b + c * c)
    return math.sqrt(square)


@_compiled
def sweep(x, teeth, lips, rows, columns, state):  # type: ignore[no-untyped-def]
    """Move vertices x (n, 3) out of what the last look has found."""
    at, which, which_lips, gaps, ways, gaps_lips, ways_lips, wanted, total, moved, shifts, _unsure, acting = state
    for number in range(SWEEPS):
        if deepest(gaps, gaps_lips) < (ENOUGH if number < FIRST else LITTLE):
            break
        gather(teeth[0], gaps, ways, 1.0, rows[0], rows[1], rows[2], wanted, total)
        gather(lips[0], gaps_lips, ways_lips, SHARED, rows[0], rows[1], rows[2], wanted, total)
        farthest = move(x, wanted, total, moved, shifts, acting, columns[0], columns[1], columns[2])
        take_off_shifts(teeth[0], shifts, farthest, gaps)
        take_off_shifts_apart(lips[0], lips[3], at, shifts, farthest, gaps_lips)
        count, count_lips = below(0.0, gaps, which), below(0.0, gaps_lips, which_lips)
        approach(x, teeth, lips, count, count_lips, state)


@_compiled
def adopt(proven, doubted, proof, state):  # type: ignore[no-untyped-def]
    """Take over what a look that makes sure tells of the points (l,) of the lips that are doubted, by their numbers.

    proven (l,): numbers among the points that it looks at, whose flags are doubted, and of which proof holds triangles
    that they are at, gaps, ways out.
    """
    at, gaps_lips, ways_lips = state[0], state[5], state[6]
    at_proven, _space, gaps_proven, ways_proven = proof
    for number in range(len(proven)):
        k = proven[number]
        if gaps_proven[k] < 0.0:
            at[number], gaps_lips[number] = at_proven[k], gaps_proven[k]
            for i in range(3):
                ways_lips[number, i] = ways_proven[k, i]
        elif doubted[k]:
            gaps_lips[number] = abs(gaps_lips[number])
