"""A mixture of true and projected second derivatives takes each part once."""

import numpy as np

from risorius_offline.effects import NodeBlocks
from risorius_offline.tangents import PROJECTED, TRUE, Projection, Tangents


class Counted:
    """Parts of a tangent of three entries: 1 true and 3 projected of obstacles, 10 and 30 of tissue."""

    def __init__(self):
        self.asked = []

    def obstacles(self, project):
        self.asked.append(("obstacles", project))
        matrices = np.full((1, 3, 3), 300.0 if project else 100.0)
        return np.full(3, 3.0 if project else 1.0), [NodeBlocks(np.zeros((1, 1), dtype=np.int64), matrices)]

    def tissue(self, project):
        self.asked.append(("tissue", project))
        return np.full(3, 30.0 if project else 10.0)


def test_shares_are_those_of_the_projection():
    parts = Counted()
    tangents = Tangents(parts.obstacles, parts.tissue)
    for projection, entry, block in (
        (TRUE, 11.0, 100.0),
        (Projection(True, 0.0), 13.0, 300.0),
        (Projection(True, 0.25), 18.0, 300.0),
        (PROJECTED, 33.0, 300.0),
    ):
        values, blocks = tangents.mixed(projection)
        np.testing.assert_allclose(values, entry)
        assert sum(one.matrices[0, 0, 0] for one in blocks) == block
    assert sorted(parts.asked) == [("obstacles", False), ("obstacles", True), ("tissue", False), ("tissue", True)]


def test_what_is_not_asked_for_is_not_computed():
    parts = Counted()
    Tangents(parts.obstacles, parts.tissue).mixed(TRUE)
    assert sorted(parts.asked) == [("obstacles", False), ("tissue", False)]
