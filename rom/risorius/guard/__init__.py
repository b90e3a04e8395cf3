"""Stands between the answer of an evaluator and the face that is shown: tissue neither folds nor explodes."""

from __future__ import annotations

from risorius.guard.guard import UNFOLDED, Guard, Verdict
from risorius.guard.watch import Watch

__all__ = ["UNFOLDED", "Guard", "Verdict", "Watch"]
