"""Landmarks, depths and openings of a built head, measured on its mesh. Metres from the sellion, as in the anatomy."""

import numpy as np

from risorius_offline.head import chart
from risorius_offline.head.border import border_edges
from risorius_offline.head.depths import LANDMARKS as DEPTHS
from risorius_offline.head.reshape import MILLIMETRES, SELLION

LEVELS = 5
FINE = 12  # points along an edge of a deep triangle, to which distances are taken


def level(head, number):
    """Nodes (n, 3) of one level: 0 is the deep side, LEVELS - 1 the skin."""
    return head.points.reshape(LEVELS, -1, 3)[number]


def triangles(head):
    """Triangles (m, 3) of any level, by its own numbers."""
    return head.skin - (LEVELS - 1) * len(level(head, 0))


def carried(sculpted, head, number, place):
    """Where the point of a level on the chart's ray through a place (millimetres, of the sculpture) is in a head."""
    origins, directions = chart.rays(chart.coordinates(np.array([place])))
    corners = level(sculpted, number)[triangles(sculpted)]
    triangle, shares = hit(corners, (origins[0] - SELLION) / MILLIMETRES, directions[0])
    return shares @ level(head, number)[triangles(head)[triangle]]


def hit(corners, origin, direction):
    """Number of the last triangle of (m, 3, 3) on a ray, and barycentric shares (3,) of the point on it."""
    a, b, c = corners.transpose(1, 0, 2)
    system = np.stack([b - a, c - a, np.broadcast_to(-direction, a.shape)], axis=-1)
    s, t, along = np.linalg.solve(system, (origin - a)[..., None])[..., 0].T
    inside = np.flatnonzero((s > -1e-9) & (t > -1e-9) & (s + t < 1.0 + 1e-9))
    found = inside[along[inside].argmax()]
    return found, np.array([1.0 - s[found] - t[found], s[found], t[found]])


def openings(head):
    """Nodes on the edge of mouth, left and right eye, by the sheet's own numbers."""
    border = np.unique(border_edges(triangles(head)))
    x, y, z = level(head, LEVELS - 1)[border].T
    near = z > -0.04
    mouth = near & (y < -0.04) & (np.abs(x) < 0.05) & (y > -0.09)
    return border[mouth], border[near & (np.abs(y) < 0.03) & (x > 0.0)], border[near & (np.abs(y) < 0.03) & (x < 0.0)]


def outer_skin(head):
    """Points (v, 3) of the visible surface without the inside of lips and lids."""
    on_skin = np.arange(len(head.points)) >= head.skin.min()
    return head.surface.points[head.surface.weights @ on_skin > 1.0 - 1e-9]


def distances(sculpted, head):
    """The ten distances of `Proportions`, each by its definition as far as the mesh has it."""
    skin = outer_skin(head)
    around = np.concatenate([skin, head.companions["head"].points])
    midline = skin[np.abs(skin[:, 0]) < 1e-9]
    root = _least(midline[np.abs(midline[:, 1]) < 0.015], 2)
    tip = midline[midline[:, 2].argmax()]
    lips = midline[(midline[:, 1] < tip[1] - 0.006) & (midline[:, 1] > tip[1] - 0.020)]
    subnasale = _least(lips, 2)
    chin = _least(midline[midline[:, 2] > -0.040], 1)
    cranium = around[around[:, 1] > 0.005]
    glabella = midline[np.abs(midline[:, 1] - 0.019).argmin()]
    arch = around[(around[:, 1] < -0.008) & (around[:, 1] > -0.040) & (around[:, 2] < -0.03) & (around[:, 2] > -0.11)]
    mouth, eye, _ = openings(head)
    lids = 0.5 * (level(head, 0) + level(head, LEVELS - 1))[eye, 0]
    wing = carried(sculpted, head, LEVELS - 1, (16.6, -18.5, 95.0))
    angle = carried(sculpted, head, 0, DEPTHS["gonion"][0])
    return {
        "eu_eu": 2.0 * cranium[:, 0].max(),
        "zy_zy": 2.0 * arch[:, 0].max(),
        "go_go": 2.0 * angle[0],
        "g_op": np.linalg.norm(cranium[np.abs(cranium[:, 0]) < 1e-3] - glabella, axis=1).max(),
        "n_gn": np.linalg.norm(root - chin),
        "sn_gn": np.linalg.norm(subnasale - chin),
        "al_al": 2.0 * wing[0],
        "ch_ch": 2.0 * level(head, LEVELS - 1)[mouth, 0].max(),
        "en_en": 2.0 * lids.min(),
        "ex_ex": 2.0 * lids.max(),
    }


def soft_tissue_depths(sculpted, head):
    """Published depth, and the measured one square to the bone, metres, by landmark.

    The way from the skin to the nearest point of the deep side is square to that side.
    """
    deep = level(head, 0)[triangles(head)]
    lattice = np.array([(i, j, FINE - i - j) for i in range(FINE + 1) for j in range(FINE + 1 - i)]) / FINE
    found = {}
    for name, (place, published) in DEPTHS.items():
        skin = carried(sculpted, head, LEVELS - 1, place)
        near = deep[np.linalg.norm(deep.mean(axis=1) - skin, axis=1) < 0.05]
        nearest = np.linalg.norm(np.einsum("lc,tcd->tld", lattice, near) - skin, axis=-1).min()
        found[name] = published / MILLIMETRES, nearest
    return found


def _least(points, axis):
    return points[points[:, axis].argmin()]
