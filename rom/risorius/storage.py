"""HDF5 files that are either whole or absent: schema name and version, SI units, checksums, atomic writes."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
import scipy.sparse as sp

from risorius.errors import Error, FileFormatError, InputError

if TYPE_CHECKING:
    from risorius.journalled_file import View

UNITS = "SI"
TEXT = h5py.string_dtype()
_SPARSE_PARTS = ("data", "indices", "indptr")


@contextmanager
def replaced_when_complete(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`; rename it to `path` on success, remove it on any failure."""
    require_folder_of(path)
    partial = path.with_name(path.name + f".{os.getpid()}.part")
    try:
        yield partial
        partial.replace(path)
    except OSError as error:
        raise Error(f"{path}: could not be written ({error}); free some space or choose another place") from error
    finally:
        partial.unlink(missing_ok=True)


def require_folder_of(path: Path) -> None:
    """Raise InputError when the folder of an output does not exist: better before the work than after it."""
    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist; create it or choose another place")


@contextmanager
def writing(path: Path, schema: str, version: int) -> Iterator[h5py.File]:
    """Open a new HDF5 file of a schema; it appears under its name only when complete, with its checksum."""
    with replaced_when_complete(path) as partial, h5py.File(partial, "w") as file:
        write_header(file, schema, version)
        yield file
        file.attrs["sha256"] = content_checksum(file)


def write_header(file: h5py.File, schema: str, version: int) -> None:
    """Store schema, version and units."""
    file.attrs["schema"], file.attrs["schema_version"], file.attrs["units"] = schema, version, UNITS


@contextmanager
def reading(path: Path, schema: str, version: int) -> Iterator[h5py.File]:
    """Open an HDF5 file after checking schema, version, units and checksum.

    Raises FileFormatError that says what the file is instead, also for a field that turns out to be missing.
    """
    require_file(path)
    with opened(path, path, "r") as file:
        require_header(file, path, schema, version)
        require_checksum(file, path)
        yield file


def require_file(path: Path) -> None:
    """Raise InputError when there is no such file."""
    if not path.is_file():
        raise InputError(f"{path}: no such file; `risorius train SOURCE -o {path.name}` makes a model")


@contextmanager
def opened(path: Path, source: Path | View, mode: str) -> Iterator[h5py.File]:
    """Open `source`, a file or a view of one, as HDF5; errors name `path`.

    Raises FileFormatError when it is not HDF5, or for a field that turns out to be missing.
    """
    try:
        file = h5py.File(source, mode)
    except OSError as error:
        raise FileFormatError(f"{path}: not a readable HDF5 file ({error}); it is truncated or foreign") from error
    with file:
        try:
            yield file
        except KeyError as error:
            raise FileFormatError(f"{path}: field missing: {error.args[0]}; make the file anew") from error


def require_header(file: h5py.File, path: Path, schema: str, version: int) -> None:
    """Raise FileFormatError unless schema, version and units are those expected."""
    found = file.attrs.get("schema")
    if found != schema:
        raise FileFormatError(f"{path}: holds {found or 'no Risorius data'}, expected {schema}; give another file")
    if file.attrs.get("schema_version") != version:
        raise FileFormatError(
            f"{path}: schema version {file.attrs.get('schema_version')}, this release reads {version}; "
            "make the file anew with this release"
        )
    if file.attrs.get("units") != UNITS:
        raise FileFormatError(f"{path}: units {file.attrs.get('units')!r}, expected {UNITS!r}; make the file anew")


def require_checksum(group: h5py.Group, path: Path) -> None:
    """Raise FileFormatError unless a file or group is as its checksum has it."""
    if group.attrs.get("sha256") != content_checksum(group):
        raise FileFormatError(f"{path}: checksum differs, the content was damaged; make or copy the file again")


def content_checksum(group: h5py.Group) -> str:
    """SHA-256 over names, shapes, types and bytes of all data sets and attributes but the checksum itself."""
    digest = hashlib.sha256()

    def add(name: str, item: h5py.HLObject) -> None:
        digest.update(name.encode())
        for key in sorted(item.attrs):
            if (name, key) != (group.name, "sha256"):
                digest.update(f"{key}={np.asarray(item.attrs[key]).tolist()!r}".encode())
        if isinstance(item, h5py.Dataset):
            values = item[()]
            digest.update(f"{item.shape}{item.dtype}".encode())
            digest.update(repr(values.tolist()).encode() if item.dtype.hasobject else values.tobytes())

    add(group.name, group)
    group.visititems(add)
    return digest.hexdigest()


def write_sparse(group: h5py.Group, matrix: sp.csr_matrix) -> None:
    """Store a matrix in compressed rows."""
    for part in _SPARSE_PARTS:
        group[part] = getattr(matrix, part)
    group.attrs["nodes"] = matrix.shape[1]


def read_sparse(group: h5py.Group) -> sp.csr_matrix:
    """Load what `write_sparse` stored."""
    data, indices, starts = (group[part][()] for part in _SPARSE_PARTS)
    return sp.csr_matrix((data, indices, starts), shape=(len(starts) - 1, int(group.attrs["nodes"])))


def text_list(dataset: h5py.Dataset) -> tuple[str, ...]:
    """Strings of a one-dimensional data set."""
    return tuple(dataset.asstr()[()])


def plain_attributes(group: h5py.Group) -> dict[str, Any]:
    """Attributes of a group as Python numbers, strings and (nested) tuples."""
    return {key: _plain(value) for key, value in group.attrs.items()}


def _plain(value: Any) -> Any:
    array = np.asarray(value)
    return tuple(map(_plain, array)) if array.ndim else array.item()
