"""Depth of soft tissue on the skull: published means at landmarks, and a smooth field through them.

Adult pooled means of forensic tissue depth tables, rounded (design source: docs/head.md); landmarks in the frame of
`skin.py`, millimetres, left side and midline.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import RBFInterpolator

from risorius.jaw import FloatArray
from risorius_offline.head import chart

LANDMARKS = {
    "frontal eminence": ((28.0, 78.0, 79.0), 4.5),
    "glabella": ((0.0, 38.0, 97.0), 5.5),
    "nasion": ((0.0, 28.0, 92.0), 6.5),
    "rhinion": ((0.0, 5.0, 100.0), 3.0),
    "mid-philtrum": ((0.0, -34.0, 99.0), 11.5),
    "upper lip": ((0.0, -41.0, 101.0), 11.5),
    "lower lip": ((0.0, -51.0, 100.0), 13.0),
    "labiomental": ((0.0, -62.0, 92.0), 11.0),
    "pogonion": ((0.0, -78.0, 94.0), 11.5),
    "menton": ((0.0, -90.5, 82.0), 7.5),
    "supraorbital": ((30.0, 34.0, 86.0), 6.0),
    "infraorbital": ((32.0, -2.0, 80.0), 6.5),
    "zygoma": ((50.0, -5.0, 62.0), 9.0),
    "zygion": ((66.0, 0.0, 25.0), 7.5),
    "mid-masseter": ((54.0, -35.0, 32.0), 18.0),
    "gonion": ((51.0, -56.0, 24.0), 13.0),
    "mid-mandibular border": ((37.0, -72.0, 52.0), 11.0),
}
# Ours, to keep the field plausible where tables have no landmark.
_BETWEEN = (
    ((0.0, 92.0, 80.0), 4.5), ((60.0, 50.0, 35.0), 6.0), ((48.0, 25.0, 62.0), 5.0), ((0.0, -14.0, 117.0), 13.0),
    ((11.0, -18.0, 106.0), 11.0), ((25.0, -46.0, 90.0), 13.0), ((34.0, -25.0, 80.0), 16.0), ((45.0, -40.0, 60.0), 18.0),
    ((24.0, -62.0, 84.0), 11.0), ((0.0, -85.0, 50.0), 13.0), ((30.0, -80.0, 10.0), 13.0),
)  # fmt: skip
SMOOTHING = 0.5
WITHIN = (0.8, 1.25)  # of the published depth, between which the sculpted bone decides
THINNEST = 2.4


class DepthField:
    """Thickness of soft tissue (millimetres) along the chart's rays."""

    def __init__(self) -> None:
        known = [*LANDMARKS.values(), *_BETWEEN]
        uv = chart.coordinates(np.array([point for point, _ in known]))
        depth = np.array([value for _, value in known])
        aside = uv[:, 0] > 1.0
        both = np.concatenate([uv, uv[aside] * [-1.0, 1.0]])
        self._field = RBFInterpolator(
            both, np.concatenate([depth, depth[aside]]), kernel="thin_plate_spline", smoothing=SMOOTHING
        )

    def published(self, uv: FloatArray) -> FloatArray:
        """Interpolated published depth (n,) at (n, 2)."""
        result: FloatArray = np.clip(self._field(np.column_stack([np.abs(uv[:, 0]), uv[:, 1]])), THINNEST, 20.0)
        return result

    def limited(self, uv: FloatArray, sculpted: FloatArray) -> FloatArray:
        """Sculpted thickness (n,), held near the published one."""
        published = self.published(uv)
        return np.clip(sculpted, WITHIN[0] * published, WITHIN[1] * published)
