"""From the sculpted head to one with given proportions: a map of space, applied to all that was built on the sculpture.

Heights are mapped first, then widths, then depths, each by a function that increases along its own coordinate, whatever
the other two are: none of the three can fold. Away from the eyes they are

    y' = h(y),  x' = x exp(f(y', z)),  z' = d(z);

about each eyeball heights and depths pass over into scaling by one factor, so that lids turn about its centre as
before, and widths into scaling by the factor of the palpebral fissure. The eyeball itself stays a sphere. All lengths
in millimetres.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import PchipInterpolator

from risorius.jaw import FloatArray
from risorius_offline.head.proportions import Proportions
from risorius_offline.head.skin import EYE_CENTRE, EYE_RADIUS

# Landmarks of `proportions.py` on the sculpture, in the frame of `skin.py`; the left ones where there are two.
LANDMARKS = {
    "eu": (73.0, 52.8, 0.9),
    "zy": (70.55, -1.9, 12.5),
    "go": (47.0, -53.8, 23.3),
    "g": (0.0, 40.0, 98.65),
    "op": (0.0, 51.9, -96.0),
    "n": (0.0, 20.97, 96.42),
    "sn": (0.0, -29.1, 98.37),
    "gn": (0.0, -91.78, 77.85),
    "al": (16.6, -18.5, 95.0),
    "ch": (24.46, -45.1, 86.8),
    "en": (18.9, 16.3, 76.8),
    "ex": (43.3, 17.9, 75.4),
}
_STRETCHED = {"eu": "eu_eu", "zy": "zy_zy", "go": "go_go", "al": "al_al", "ch": "ch_ch"}
_UNSTRETCHED = ((132.0, 0.0), (-150.0, -30.0), (-130.0, 20.0))  # (y, z) at the vertex and in the neck
_SOFTENING = 20.0  # of the weights of these places
_FRONT = 60.0  # in front of which depths stay
_SIMILAR, _BLENDED = 13.5, 42.0  # from the eyeball's centre: nothing but its scaling, no more of it
_KNOTS = (-14.5, -13.5, 13.5, 14.5)  # about the eyeball's centre, so that between the inner ones all is linear
_TEMPLE, _ABOVE, _BEHIND = 80.0, 85.0, 20.0  # x, y, z where columns through the eye are like others again
_FAR = 300.0


@dataclass(frozen=True)
class Warp:
    """Map that puts the landmarks of the sculpture at the distances of `proportions`."""

    proportions: Proportions

    def __call__(self, points: FloatArray) -> FloatArray:
        """Places (n, 3) of points (n, 3); mirror images stay mirror images."""
        x, y, z = np.abs(points[:, 0]), points[:, 1], points[:, 2]
        (_, _, eye_z), (new_x, new_y, _) = EYE_CENTRE, self._eye_centre
        y = self._new_heights(x, y, z)
        share = _share((y - new_y) / self._eye_scale, z - eye_z)
        x = share * self._widths_at_eye(x) + (1.0 - share) * x * np.exp(self._stretch(y, z))
        share = _share((x - new_x) / self._fissure, (y - new_y) / self._eye_scale)
        z = share * self._depths_at_eye(z) + (1.0 - share) * self._depths(z)
        return np.column_stack([np.copysign(x, points[:, 0]), y, z])

    def _new_heights(self, x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
        share = _share(x - EYE_CENTRE[0], z - EYE_CENTRE[2])
        result: FloatArray = share * self._heights_at_eye(y) + (1.0 - share) * self._heights(y)
        return result

    def eyeball(self, points: FloatArray) -> FloatArray:
        """Places (n, 3) of points (n, 3) of one eyeball: a similarity."""
        side = np.array([np.copysign(1.0, points[:, 0].sum()), 1.0, 1.0])
        result: FloatArray = side * self._eye_centre + self._eye_scale * (points - side * EYE_CENTRE)
        return result

    @cached_property
    def _fissure(self) -> float:
        """Width of the palpebral fissure, as a multiple of the sculpted one."""
        return (self._half("ex_ex") - self._half("en_en")) / (LANDMARKS["ex"][0] - LANDMARKS["en"][0])

    @cached_property
    def _eye_scale(self) -> float:
        """Of the eyeball: less than a wide fissure asks for, but all that a narrow one does, lest it pierce lids."""
        return min(self._fissure, math.sqrt(self._fissure))

    @cached_property
    def _eye_centre(self) -> tuple[float, float, float]:
        """Of the left eyeball, whose front stays as deep as it is."""
        x, y, z = EYE_CENTRE
        across = self._half("en_en") + self._fissure * (x - LANDMARKS["en"][0])
        return across, float(self._heights(y)), z - (self._eye_scale - 1.0) * EYE_RADIUS

    @cached_property
    def _heights(self) -> PchipInterpolator:
        """Nasal root and all above stay."""
        n, sn, gn = (LANDMARKS[name] for name in ("n", "sn", "gn"))
        chin = n[1] - _leg(1e3 * self.proportions.n_gn, n[2] - gn[2])
        nose = chin + _leg(1e3 * self.proportions.sn_gn, sn[2] - gn[2])
        return _increasing([(gn[1], chin), (sn[1], nose), (n[1], n[1])])

    @cached_property
    def _depths(self) -> PchipInterpolator:
        g, op = (LANDMARKS[name] for name in ("g", "op"))
        back = g[2] - _leg(1e3 * self.proportions.g_op, float(self._heights(g[1]) - self._heights(op[1])))
        return _increasing([(op[2], back), (_FRONT, _FRONT)])

    @cached_property
    def _heights_at_eye(self) -> PchipInterpolator:
        mouth, chin = LANDMARKS["ch"][1], LANDMARKS["gn"][1]
        below = [(y, float(self._heights(y))) for y in (chin, mouth)]
        return _increasing([*below, *self._knots(1, self._eye_scale), (_ABOVE, _ABOVE)])

    @cached_property
    def _widths_at_eye(self) -> PchipInterpolator:
        outside = _TEMPLE * self._half("zy_zy") / LANDMARKS["zy"][0]
        return _increasing([(0.0, 0.0), *self._knots(0, self._fissure), (_TEMPLE, outside)])

    @cached_property
    def _depths_at_eye(self) -> PchipInterpolator:
        front = LANDMARKS["n"][2]
        return _increasing([(_BEHIND, float(self._depths(_BEHIND))), *self._knots(2, self._eye_scale), (front, front)])

    def _knots(self, axis: int, scale: float) -> list[tuple[float, float]]:
        old, new = EYE_CENTRE[axis], self._eye_centre[axis]
        return [(old + off, new + scale * off) for off in _KNOTS]

    def _stretch(self, y: FloatArray, z: FloatArray) -> FloatArray:
        """Logarithm f (n,): a mean of values at a few places, weighted by distance."""
        places, values = self._stretched
        # No product of matrices: its last bits depend on the rows beside.
        result: FloatArray = (_weights(y, z, places) * values).sum(axis=1)
        return result

    @cached_property
    def _stretched(self) -> tuple[FloatArray, FloatArray]:
        """Places (k, 2) that decide about widths, and values (k,) with which the landmarks come out right."""
        old = np.array([*(LANDMARKS[name] for name in _STRETCHED), EYE_CENTRE])
        new = np.array([*(self._half(field) for field in _STRETCHED.values()), self._eye_centre[0]])
        own = np.column_stack([self._new_heights(*old.T), old[:, 2]])
        places = np.concatenate([own, _UNSTRETCHED])
        values = np.concatenate([np.log(new / old[:, 0]), np.zeros(len(_UNSTRETCHED))])
        weights = _weights(places[:, 0], places[:, 1], places)
        return places, np.linalg.solve(weights, values)

    def _half(self, field: str) -> float:
        return 0.5e3 * float(getattr(self.proportions, field))


def _share(across: FloatArray, along: FloatArray) -> FloatArray:
    """Share (n,) of the scaling about the eye at distances (n,) from the eyeball's centre in a plane."""
    away = np.hypot(across, along)
    linear = np.clip((_BLENDED - away) / (_BLENDED - _SIMILAR), 0.0, 1.0)
    result: FloatArray = linear**2 * (3.0 - 2.0 * linear)
    return result


def _weights(y: FloatArray, z: FloatArray, places: FloatArray) -> FloatArray:
    """Weights (n, k) of places (k, 2) at heights and depths (n,), of sum 1."""
    squared = (y[:, None] - places[:, 0]) ** 2 + (z[:, None] - places[:, 1]) ** 2
    near = (squared + _SOFTENING**2) ** -2
    result: FloatArray = near / near.sum(axis=1, keepdims=True)
    return result


def _leg(distance: float, other: float) -> float:
    """Second leg of a right triangle with a hypotenuse and a leg."""
    return float(np.sqrt(distance**2 - other**2))


def _increasing(pairs: Iterable[tuple[float, float]]) -> PchipInterpolator:
    """Smooth increasing function through pairs in increasing order; far beyond them it only shifts."""
    (first, first_value), *_, (last, last_value) = pairs = list(pairs)
    before = [(first - far, first_value - far) for far in (2.0 * _FAR, _FAR)]
    after = [(last + far, last_value + far) for far in (_FAR, 2.0 * _FAR)]
    return PchipInterpolator(*np.array([*before, *pairs, *after]).T)
