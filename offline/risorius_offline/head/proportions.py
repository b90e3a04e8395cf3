"""Proportions of the built-in head: distances between landmarks of the face, after Farkas.

Landmarks, on the skin unless said otherwise: eu, the cranium's widest point; zy, the widest point of the zygomatic
arch; go, the angle of the mandible, on the bone; g, midline between the brows; op, the cranium's most posterior point;
n, the deepest point of the nasal root; sn, the deepest midline point between nose and upper lip; gn, the lowest midline
point of the chin; al, where the nostril's wing is most sagittal; ch, the corner of the mouth; en and ex, inner and
outer corner of the lids, half way between eyeball and skin.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields
from typing import NamedTuple

from risorius.errors import InputError

WITHIN = 4.0  # standard deviations from the mean


class Norm(NamedTuple):
    """Adult mean and standard deviation, metres."""

    mean: float
    deviation: float


# Means: rounded after Farkas 1994, both sexes together. Deviations: ours (docs/head.md).
NORMS = {
    "eu_eu": Norm(0.150, 0.006),
    "zy_zy": Norm(0.136, 0.005),
    "go_go": Norm(0.102, 0.006),
    "g_op": Norm(0.192, 0.007),
    "n_gn": Norm(0.119, 0.006),
    "sn_gn": Norm(0.070, 0.005),
    "al_al": Norm(0.034, 0.0025),
    "ch_ch": Norm(0.052, 0.0035),
    "en_en": Norm(0.032, 0.0025),
    "ex_ex": Norm(0.088, 0.004),
}


@dataclass(frozen=True)
class Proportions:
    """Distances in metres between the landmarks of a symmetric head; by default those of the mean adult.

    eu_eu: width of the cranium. zy_zy: of the face. go_go: of the mandible, on the bone. g_op: length of the head.
    n_gn: height of the face. sn_gn: of its lower part. al_al: width of the nose. ch_ch: of the mouth. en_en, ex_ex:
    between the inner and between the outer corners of the eyes. Raises InputError beyond four standard deviations.
    """

    eu_eu: float = NORMS["eu_eu"].mean
    zy_zy: float = NORMS["zy_zy"].mean
    go_go: float = NORMS["go_go"].mean
    g_op: float = NORMS["g_op"].mean
    n_gn: float = NORMS["n_gn"].mean
    sn_gn: float = NORMS["sn_gn"].mean
    al_al: float = NORMS["al_al"].mean
    ch_ch: float = NORMS["ch_ch"].mean
    en_en: float = NORMS["en_en"].mean
    ex_ex: float = NORMS["ex_ex"].mean

    def __post_init__(self) -> None:
        for field in fields(self):
            mean, deviation = NORMS[field.name]
            value = getattr(self, field.name)
            low, high = mean - WITHIN * deviation, mean + WITHIN * deviation
            if not (math.isfinite(value) and low <= value <= high):
                raise InputError(
                    f"proportions: {field.name} = {value:g} m; give a distance from {low:g} to {high:g} m "
                    f"(adult mean {mean:g}, standard deviation {deviation:g})"
                )

    def provenance(self) -> dict[str, float]:
        """What a file remembers of them, metres."""
        return asdict(self)

    def farthest(self) -> tuple[str, float]:
        """Field that is farthest from its mean, and how far, in standard deviations."""
        off = {name: (value - NORMS[name].mean) / NORMS[name].deviation for name, value in asdict(self).items()}
        name = max(off, key=lambda field: abs(off[field]))
        return name, off[name]


ADULT = Proportions()
