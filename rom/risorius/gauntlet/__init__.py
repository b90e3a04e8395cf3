"""Hard cases for any reduced model: what may arrive or be asked for, and what must hold of every frame."""

from __future__ import annotations

from risorius.gauntlet.judge import VERDICTS
from risorius.gauntlet.run import Result, all_cases, run

__all__ = ["VERDICTS", "Result", "all_cases", "run"]
