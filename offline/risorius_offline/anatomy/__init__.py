"""Anatomies: the data class, its file, the import folder and the artificial model of the seed."""

from risorius_offline.anatomy.anatomy import Anatomy
from risorius_offline.anatomy.source import load_source

__all__ = ["Anatomy", "load_source"]
