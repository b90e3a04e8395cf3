"""Landmarks that can be read off the surfaces: the sellion, the condyles, the incisal edge."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from risorius.jaw import FloatArray, JawMotion

MIDLINE = 0.006  # a point this near to the plane of symmetry lies on the profile, metres
NASAL_ROOT = 0.075  # the sellion is at most this far above the tip of the nose, metres
# Full opening between the incisors, and how far the condyles slide; adult means (architecture of the jaw inputs).
INCISAL_OPENING, OPENING_SLIDE, FORWARD_SLIDE, SIDEWAYS_SLIDE = 0.045, 0.008, 0.005, 0.008


def sellion(skin: FloatArray) -> FloatArray:
    """Deepest point of the nasal root on the mid-sagittal profile of skin points (n, 3), with x = 0.

    It is the profile point farthest behind the line from the tip of the nose to the foremost point of the forehead.
    """
    profile = skin[np.abs(skin[:, 0]) < MIDLINE]
    nose = profile[profile[:, 2].argmax()]
    above = profile[(profile[:, 1] > nose[1]) & (profile[:, 1] < nose[1] + NASAL_ROOT)]
    brow = above[above[:, 1].argmax()]
    chord = (brow - nose)[1:] / np.linalg.norm((brow - nose)[1:])
    depth = (above[:, 1] - nose[1]) * chord[1] - (above[:, 2] - nose[2]) * chord[0]
    root = above[depth.argmax()]
    return np.array([0.0, root[1], root[2]])


def jaw_motion(mandible: FloatArray) -> JawMotion:
    """Hinge and range of a mandible (n, 3) with teeth: full opening parts the incisors by 45 mm."""
    centre = _condyle_centre(mandible)
    incisor = _incisal_edge(mandible)
    unit = JawMotion((0.0, float(centre[1]), float(centre[2])), 1.0, 0.0, 0.0, 0.0)
    fields = unit.unit_motions(incisor[None])[:, 0]

    def excess(angle: float) -> float:
        moved = np.sin(angle) * fields[0] + (1.0 - np.cos(angle)) * fields[1] + OPENING_SLIDE * fields[2]
        return float(np.linalg.norm(moved)) - INCISAL_OPENING

    angle = brentq(excess, 0.1, 1.2)
    return JawMotion(unit.condyle_centre, float(angle), OPENING_SLIDE, FORWARD_SLIDE, SIDEWAYS_SLIDE)


def _condyle_centre(mandible: FloatArray) -> FloatArray:
    """Midpoint of the two condyles: the points of each half that lie farthest up and back."""
    height = mandible[:, 1] - mandible[:, 2]
    sides = [mandible[:, 0] > 0.0, mandible[:, 0] <= 0.0]
    tops = [mandible[side][height[side] >= np.quantile(height[side], 0.98)].mean(axis=0) for side in sides]
    return np.mean(tops, axis=0)


def _incisal_edge(mandible: FloatArray) -> FloatArray:
    """Highest point of the front teeth near the midline."""
    front = mandible[(np.abs(mandible[:, 0]) < MIDLINE) & (mandible[:, 2] > mandible[:, 2].max() - 0.02)]
    return front[front[:, 1].argmax()]
