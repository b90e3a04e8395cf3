"""The built-in head: a parametric face of our own, from published distances."""
