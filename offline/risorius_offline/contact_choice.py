"""What tissue may touch."""

from __future__ import annotations

from enum import StrEnum


class ContactChoice(StrEnum):
    """Nothing, the seed's natural boundary; bones with teeth and eyeballs; these and lips at their seam; or all of it."""

    NONE = "none"
    BONES = "bones"
    LIPS = "lips"
    FULL = "full"
