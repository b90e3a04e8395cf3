"""Whether the offline extra is installed."""

from __future__ import annotations

import importlib.util

from risorius.errors import MissingExtraError


def require_offline(feature: str) -> None:
    """Raise MissingExtraError when a package of the `offline` extra is missing."""
    for module in ("skfem", "meshio", "distributed"):
        if importlib.util.find_spec(module) is None:
            raise MissingExtraError(feature, "offline", module)
