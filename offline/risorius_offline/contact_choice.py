"""What tissue may touch."""

from __future__ import annotations

from enum import StrEnum


class ContactChoice(StrEnum):
    """Nothing, which is the seed's natural boundary; bones with teeth and eyeballs; or these and itself."""

    NONE = "none"
    BONES = "bones"
    FULL = "full"
