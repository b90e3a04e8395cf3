"""The built-in head: a parametric face of our own, from published distances."""

from risorius_offline.head.head import built_in_head

__all__ = ["built_in_head"]
