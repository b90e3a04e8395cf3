"""Names of the anatomies that need no file: SOURCE of the command line."""

from __future__ import annotations

HEADS = {"builtin": "standard", "builtin-draft": "draft", "builtin-fine": "fine"}
CYLINDERS = "cylinders"
SOURCE_HELP = "'builtin' (a head; also 'builtin-draft', 'builtin-fine'), 'cylinders', a folder, or an anatomy file."
