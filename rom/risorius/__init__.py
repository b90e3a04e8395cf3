"""Risorius: facial action units in, a physically deformed face out."""

from importlib.metadata import version

from risorius import arkit, intensities, openface
from risorius.budget import Budget
from risorius.effects import Touch
from risorius.engine import Engine, Frame
from risorius.errors import Error, FileFormatError, InputError, MissingExtraError, SolverError
from risorius.model import ReducedModel, load
from risorius.scene import Scene

__version__ = version("risorius")

__all__ = [
    "Budget",
    "Engine",
    "Error",
    "FileFormatError",
    "Frame",
    "InputError",
    "MissingExtraError",
    "ReducedModel",
    "Scene",
    "SolverError",
    "Touch",
    "arkit",
    "intensities",
    "load",
    "openface",
]
