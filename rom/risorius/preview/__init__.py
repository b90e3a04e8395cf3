"""The live preview: a meshcat page that shows every frame and carries slider values back."""

from __future__ import annotations

from risorius.errors import MissingExtraError

_OF_THE_EXTRA = ("meshcat", "tornado", "umsgpack", "zmq", "PIL")

try:
    from risorius.preview.server import Preview
except ModuleNotFoundError as error:
    if (error.name or "").partition(".")[0] not in _OF_THE_EXTRA:
        raise
    raise MissingExtraError("the live preview", "view", str(error.name)) from error

__all__ = ["Preview"]
