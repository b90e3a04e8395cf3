"""The built-in head, sculpted once for all tests of it."""

import numpy as np
import pytest

from risorius_offline.head.head import sculpted_head as sculpted
from risorius_offline.head.proportions import ADULT, NORMS, Proportions
from risorius_offline.head.reshape import reshaped


@pytest.fixture(scope="session")
def sculpted_head():
    return sculpted("draft")


@pytest.fixture(scope="session")
def adult_head(sculpted_head):
    return reshaped(sculpted_head, ADULT)


@pytest.fixture(scope="session")
def thirty_proportions():
    """All fields at once anywhere within two standard deviations of their means."""
    rng = np.random.default_rng(4)
    return [
        Proportions(**{name: mean + deviation * rng.uniform(-2.0, 2.0) for name, (mean, deviation) in NORMS.items()})
        for _ in range(30)
    ]
