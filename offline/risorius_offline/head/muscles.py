"""The mimic muscles of the built-in head, by landmarks on its skin and a depth between bone and skin.

Origins and insertions after standard anatomy (docs/head.md has the table). Each line runs from the origin to the
insertion; a point is (x, y, z, depth): near a place on the skin in the frame of `skin.py`, and its share of the way
from the deep surface (0) to the skin (1) along the chart's ray.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from risorius.jaw import FloatArray
from risorius_offline.head import chart

Place = tuple[float, float, float, float]
PIECES = 12


@dataclass(frozen=True)
class Course:
    """Left half of a muscle. radius: of the tissue about each line, mm. stress: at full activation, pascals."""

    name: str
    radius: float
    stress: float
    lines: tuple[tuple[Place, ...], ...]

    def surface_points(self) -> list[tuple[FloatArray, FloatArray]]:
        """Chart coordinates (k, 2) and depths (k,) along each line, smooth through its places."""
        result = []
        for line in self.lines:
            table = np.array(line)
            nodes = np.column_stack([chart.coordinates(table[:, :3]), table[:, 3]])
            at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(nodes[:, :2], axis=0), axis=1))])
            fine = np.linspace(0.0, at[-1], PIECES + 1)
            smooth = CubicSpline(at, nodes, bc_type="natural")(fine) if len(at) > 2 else _straight(at, nodes, fine)
            result.append((smooth[:, :2], np.clip(smooth[:, 2], 0.0, 1.0)))
        return result


def _straight(at: FloatArray, nodes: FloatArray, fine: FloatArray) -> FloatArray:
    return np.column_stack([np.interp(fine, at, column) for column in nodes.T])


STRESS = 100e3

COURSES = (
    Course("zygomaticus_major", 3.5, 1.4 * STRESS, (
        ((56, -4, 48, 0.05), (46, -20, 64, 0.4), (36, -36, 78, 0.55), (28.5, -45.5, 86, 0.6)),)),
    Course("zygomaticus_minor", 2.5, STRESS, (
        ((47, -2, 62, 0.05), (36, -16, 76, 0.5), (25, -32, 88, 0.65), (17, -38, 94, 0.7)),)),
    Course("levator_labii_superioris", 2.5, 0.5 * STRESS, (
        ((22, 4, 82, 0.05), (19, -14, 90, 0.5), (13, -36, 97, 0.7)),
        ((28, 3, 80, 0.05), (24, -15, 87, 0.5), (18, -36, 94, 0.7)))),
    Course("levator_labii_superioris_alaeque_nasi", 2.0, 1.5 * STRESS, (
        ((9, 18, 88, 0.1), (12, 2, 92, 0.5), (15, -14, 97, 0.6), (14, -24, 99, 0.6), (11, -35, 98, 0.65)),)),
    Course("levator_anguli_oris", 3.0, STRESS, (
        ((20, -12, 88, 0.05), (24, -28, 90, 0.35), (28, -44, 87, 0.5)),)),
    Course("risorius", 2.5, 1.3 * STRESS, (
        ((58, -38, 32, 0.6), (44, -42, 62, 0.6), (29.5, -46.5, 85, 0.6)),
        ((57, -46, 32, 0.6), (44, -48, 60, 0.6), (29.5, -47.5, 85, 0.6)))),
    Course("buccinator", 3.0, STRESS, (
        ((46, -30, 50, 0.1), (37, -37, 70, 0.15), (29, -45, 85, 0.35)),
        ((48, -42, 48, 0.1), (38, -44, 68, 0.15), (29, -46.5, 85, 0.35)),
        ((46, -54, 48, 0.1), (37, -52, 68, 0.15), (29, -48, 85, 0.35)))),
    Course("depressor_anguli_oris", 3.0, STRESS, (
        ((34, -74, 58, 0.1), (31, -60, 78, 0.5), (28.5, -48, 86, 0.6)),
        ((22, -81, 76, 0.1), (26, -63, 84, 0.5), (28.5, -48, 86, 0.6)))),
    Course("depressor_labii_inferioris", 2.5, 0.7 * STRESS, (
        ((24, -77, 72, 0.1), (18, -64, 88, 0.45), (12, -54, 94, 0.7)),
        ((17, -81, 80, 0.1), (12, -66, 91, 0.45), (6, -54, 96, 0.7)))),
    Course("mentalis", 3.0, 0.8 * STRESS, (
        ((5, -61, 92, 0.05), (6, -69, 94, 0.5), (7.5, -79, 94, 0.85)),)),
    Course("incisivus_labii_superioris", 2.0, 1.5 * STRESS, (
        ((9, -31, 98, 0.05), (17, -38, 96, 0.35), (26, -44.5, 88, 0.5)),)),
    Course("incisivus_labii_inferioris", 2.0, 1.5 * STRESS, (
        ((8, -59, 94, 0.05), (17, -54, 92, 0.35), (26, -48.5, 87, 0.5)),)),
    Course("orbicularis_oris_marginalis_superior", 2.0, STRESS, (
        ((0, -44.4, 101.5, 0.3), (9, -44.2, 100.5, 0.3), (18, -44.8, 95.5, 0.35), (26, -45.6, 88, 0.35)),)),
    Course("orbicularis_oris_marginalis_inferior", 2.0, STRESS, (
        ((0, -47.4, 101, 0.3), (9, -47.2, 100, 0.3), (18, -46.8, 94.5, 0.35), (26, -46.6, 88, 0.35)),)),
    Course("orbicularis_oris_peripheralis_superior", 3.0, 1.5 * STRESS, (
        ((0, -36.5, 100, 0.2), (11, -37, 98, 0.2), (21, -40.5, 93, 0.2), (30, -46, 85, 0.2)),)),
    Course("orbicularis_oris_peripheralis_inferior", 3.0, 1.5 * STRESS, (
        ((0, -56.5, 98, 0.2), (11, -56, 96, 0.2), (21, -53, 91, 0.2), (30, -47.5, 85, 0.2)),)),
    Course("orbicularis_oculi_palpebralis", 1.8, 0.12 * STRESS, (
        ((16.6, 17.2, 76, 0.5), (23, 24.4, 80, 0.6), (30.5, 25.8, 80, 0.6), (38, 23.6, 77, 0.6), (43.5, 18, 71, 0.5)),
        ((16.6, 16.6, 76, 0.5), (23, 12.2, 79, 0.6), (30.5, 10.8, 79, 0.6), (38, 12.4, 76, 0.6), (43.5, 17, 71, 0.5)))),
    Course("orbicularis_oculi_orbitalis", 3.0, 0.4 * STRESS, (
        ((13, 19, 84, 0.2), (16, 31, 86, 0.5), (29, 37, 84, 0.6), (44, 32, 74, 0.6), (50, 17, 64, 0.6)),
        ((13, 15, 84, 0.2), (17, 1, 84, 0.5), (31, -5, 80, 0.6), (44, 1, 70, 0.6), (50, 16, 64, 0.6)))),
    Course("frontalis_medialis", 5.0, 0.9 * STRESS, (
        ((5, 88, 82, 0.5), (6, 62, 95, 0.5), (7, 37, 97, 0.7)),
        ((14, 87, 80, 0.5), (15, 62, 93, 0.5), (16, 37, 92, 0.7)))),
    Course("frontalis_lateralis", 5.0, 0.65 * STRESS, (
        ((24, 84, 77, 0.5), (26, 60, 88, 0.5), (28, 38, 86, 0.7)),
        ((34, 80, 70, 0.5), (37, 58, 80, 0.5), (40, 36, 78, 0.7)))),
    Course("corrugator_supercilii", 3.0, 2.4 * STRESS, (
        ((5.5, 36, 94, 0.05), (16, 38, 92.5, 0.4), (31, 39.5, 86, 0.75)),
        ((9, 30, 90, 0.05), (14, 34.5, 91.5, 0.4), (19, 38, 90, 0.8)))),
    Course("depressor_supercilii", 2.0, 0.7 * STRESS, (
        ((8, 23, 88, 0.05), (10, 30, 90, 0.5), (13, 36.5, 93, 0.8)),)),
    Course("procerus", 3.0, 0.55 * STRESS, (
        ((3, 13, 93, 0.1), (4, 26, 92, 0.5), (6, 42, 97, 0.8)),)),
    Course("nasalis_alaris", 2.0, STRESS, (
        ((13, -30, 96, 0.05), (14.5, -24, 99, 0.5), (14, -17, 101, 0.65)),)),
    Course("nasalis_transversa", 2.0, STRESS, (
        ((18, -21, 97, 0.05), (13, -8, 98, 0.5), (3, 0, 103, 0.6)),)),
    Course("depressor_septi_nasi", 2.0, STRESS, (
        ((4, -33, 99, 0.05), (3, -28, 102, 0.5), (2.5, -24.5, 108, 0.6)),)),
    Course("platysma", 3.0, STRESS, (
        ((30, -108, 8, 0.5), (37, -80, 42, 0.6), (31, -60, 78, 0.65), (29, -50, 85, 0.65)),
        ((48, -92, 2, 0.5), (50, -66, 36, 0.6), (42, -52, 62, 0.65)))),
)  # fmt: skip
