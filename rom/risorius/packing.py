"""Arrays packed as they lie in a snapshot file, so that the process that solves compresses, not the one that writes."""

from __future__ import annotations

from itertools import count

import h5py
import numpy as np
import numpy.typing as npt

FILTERS = {"shuffle": True, "compression": "gzip", "compression_opts": 1, "fletcher32": True}
"""Of a dataset of chunks; lossless, with a checksum."""
_names = count()


def packed(values: npt.NDArray[np.float32]) -> bytes:
    """Chunk that holds nothing but these values, after FILTERS; HDF5 itself filters, in a file in memory."""
    with h5py.File(f"packing {next(_names)}", "w", driver="core", backing_store=False) as file:
        data = file.create_dataset("values", data=values, dtype=np.float32, chunks=values.shape, **FILTERS)
        chunk: bytes = data.id.read_direct_chunk((0,) * values.ndim)[1]
        return chunk


def write_packed(dataset: h5py.Dataset, row: int, chunk: bytes) -> None:
    """Put a chunk where the row of a dataset is that has one chunk a row, with FILTERS."""
    dataset.id.write_direct_chunk((row, *(0,) * (dataset.ndim - 1)), chunk)


def rows_of_chunks(group: h5py.Group, name: str, each: tuple[int, ...]) -> None:
    """Make an empty dataset for `write_packed`, with rows of shape `each`."""
    group.create_dataset(name, (0, *each), np.float32, maxshape=(None, *each), chunks=(1, *each), **FILTERS)
