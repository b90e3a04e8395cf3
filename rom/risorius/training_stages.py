"""What a training of minutes tells of itself while it runs."""

from __future__ import annotations

from typing import Protocol


class Stages(Protocol):
    """Is told what is at work."""

    def begin(self, name: str) -> None:
        """Say what begins; what was at work before is done."""
        ...

    def reached(self, share: float) -> None:
        """Say what share of it is done, 0 to 1, where that is known."""
        ...


class Untold:
    """Tells nobody."""

    def begin(self, name: str) -> None:
        """Tell nothing."""

    def reached(self, share: float) -> None:
        """Tell nothing."""


UNTOLD = Untold()
