"""The exception family. Every message names the file or field, the offending value and the remedy."""


class Error(Exception):
    """Base of all errors that Risorius raises on purpose. The command line exits with `exit_code`."""

    exit_code = 1


class InputError(Error):
    """Something the caller gave is wrong: a file, a name, a value. Nothing was computed or written."""

    exit_code = 2


class FileFormatError(InputError):
    """A file is truncated, foreign, damaged or of another schema version."""


class MissingExtraError(InputError):
    """A feature needs an optional dependency that is not installed."""

    def __init__(self, feature: str, extra: str, module: str) -> None:
        super().__init__(
            f"{feature} needs the Python package {module!r}, which is not installed here; "
            f"install it with: pip install 'risorius[{extra}]'"
        )


class SolverError(Error):
    """A computation did not reach what it promises."""
