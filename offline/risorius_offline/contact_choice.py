"""What tissue may touch."""

from __future__ import annotations

from enum import StrEnum


class ContactChoice(StrEnum):
    """Nothing, the seed's natural boundary; bones with teeth and eyeballs; lips at their seam too; or everything."""

    NONE = "none"
    BONES = "bones"
    LIPS = "lips"
    FULL = "full"
