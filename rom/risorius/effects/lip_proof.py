"""The surer and slower look at lips, for the few frames in which something speaks against the quick one."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from risorius.effects.contact_proof import prove
from risorius.effects.retreat import Retreat

GROUP = 12  # triangles at most, that are left out together where they are far
Numbers = npt.NDArray[np.int32]
Arrays = tuple[Any, ...]


class LipProof:
    """Looks at all points of the lips. Not thread-safe: it owns what it works with.

    lips, patches: as `ContactLook` hands them to kernels; side_of (n,) of vertices. rest (n, 3): where these are at
    rest, as far as a retreat tells.
    """

    def __init__(self, lips: Arrays, side_of: Numbers, patches: Arrays, retreat: Retreat) -> None:
        self._lips, self._patches = lips, patches
        vertices, triangles, across = lips[0], lips[3], lips[4]
        self.rest = np.zeros((len(side_of), 3), np.float32)
        self.rest[retreat.vertices] = retreat.places
        groups, group_sides = _groups(self.rest[triangles].mean(axis=1), side_of[triangles[:, 0]])
        border = np.zeros(len(side_of), bool)
        border[np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)[across < 0]] = True
        members, starts = np.concatenate([np.zeros(0, np.int32), *groups]), np.cumsum([0, *map(len, groups)])
        self._groups = members.astype(np.int32), starts.astype(np.int32), group_sides, border
        count = len(groups)
        self._work = (
            np.zeros((count, 3)), np.zeros(count), np.zeros(len(patches[0])), np.zeros((len(triangles), 4)),
            np.zeros(count, np.int32), np.zeros(3),
        )  # fmt: skip
        self._sides = side_of[vertices]
        self._surface = retreat.skin, self.rest, np.full(len(vertices), np.nan)

    def depth(self, x: npt.NDArray[np.float32], corners: Arrays, state: Arrays) -> float:
        """Metres that any point of vertices (n, 3) is in anything, negative where none is; sets the lips' gaps anew."""
        return float(
            prove(x, self._lips, self._sides, self._patches, corners, self._groups, self._work, self._surface, state)
        )


def _groups(centres: npt.NDArray[np.floating], sides: Numbers) -> tuple[list[Numbers], Numbers]:
    """Numbers of triangles with centres (t, 3) that are next to each other and on one of sides (t,), and which."""
    waiting = [np.flatnonzero(sides == side) for side in np.unique(sides)]
    groups: list[Numbers] = []
    while waiting:
        group = waiting.pop()
        if len(group) <= GROUP:
            groups.append(group.astype(np.int32))
            continue
        along = centres[group]
        group = group[np.argsort(along[:, np.ptp(along, axis=0).argmax()], kind="stable")]
        waiting += [group[: len(group) // 2], group[len(group) // 2 :]]
    return groups, np.array([sides[group[0]] for group in groups], np.int32)
