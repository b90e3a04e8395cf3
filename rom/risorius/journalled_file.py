"""A binary file that changes by whole commits, whatever stops the program, while others read it.

What a commit adds at the end is written there at once: nothing refers to it yet. What it changes before the end goes
to a journal beside the file first, with its checksum, and into the file only afterwards (write-ahead logging, as data
bases do). A program that is killed leaves the file as the last whole commit in the journal has it.

Readers hold a shared lock (flock, as HDF5's own readers do) and see one commit for as long as they read. Meanwhile
commits stay in the journal. One writer at a time: it holds a lock on the journal.
"""

from __future__ import annotations

import fcntl
import os
import struct
import time
import zlib
from collections.abc import Mapping
from pathlib import Path

from risorius.errors import Error, InputError

PAGE = 4096
IDENTITY_BYTES = 64  # the first bytes of a file tell it from all others, and never change
WAIT_SECONDS = 10.0
_RECORD = struct.Struct("<QQI")  # size of the file after the commit, bytes that follow, their checksum
_CHANGE = struct.Struct("<QI")  # offset, length


class View:
    """Bytes of an open file with committed pages laid over it; what h5py needs of a file object."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._pages: dict[int, bytes] = {}
        self._committed = self._size = os.fstat(descriptor).st_size
        self._position = 0

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Move to an offset; only from the start or the end."""
        self._position = offset + (self._size if whence == os.SEEK_END else 0)
        return self._position

    def tell(self) -> int:
        """Return the offset of the next byte."""
        return self._position

    def read(self, size: int) -> bytes:
        """Read bytes."""
        data = bytearray(size)
        self.readinto(memoryview(data))
        return bytes(data)

    def readinto(self, buffer: memoryview) -> int:
        """Fill a buffer; past the end there are zeros, as HDF5 expects."""
        view = memoryview(buffer).cast("B")
        view[:] = self._bytes(self._position, self._position + len(view))
        self._position += len(view)
        return len(view)

    def _bytes(self, start: int, end: int) -> bytearray:
        data = bytearray(end - start)
        stored = os.pread(self._descriptor, max(0, min(end, self._committed) - start), start)
        data[: len(stored)] = stored
        _lay_pages(data, start, self._pages)
        return data

    def _lay_over(self, journal: Path) -> int:
        """Take the whole commits of a journal of this file; return the bytes of the journal that hold them."""
        try:
            content = journal.read_bytes()
        except FileNotFoundError:
            return 0
        if content[:IDENTITY_BYTES] != os.pread(self._descriptor, IDENTITY_BYTES, 0):
            return 0  # of another file that once had this name
        position = IDENTITY_BYTES
        while position + _RECORD.size <= len(content):
            size, length, checksum = _RECORD.unpack_from(content, position)
            payload = content[position + _RECORD.size : position + _RECORD.size + length]
            if len(payload) < length or _checksum(size, payload) != checksum:
                break
            self._pages.update(_changes(payload))
            self._committed = self._size = size
            position += _RECORD.size + length
        return position


class FileReader(View):
    """A journalled file as the last commit left it, until closed; meanwhile the writer is not held up.

    Raises OSError when the file cannot be opened, Error when a writer does not let go of it.
    """

    def __init__(self, path: Path) -> None:
        descriptor = os.open(path, os.O_RDONLY)
        try:
            _wait_for_lock(descriptor, path)
            super().__init__(descriptor)
            self._lay_over(journal_of(path))
        except BaseException:
            os.close(descriptor)
            raise

    def close(self) -> None:
        """Let go of the file."""
        os.close(self._descriptor)


class FileWriter(View):
    """The one writer of a journalled file; nothing it writes is there before `commit`.

    Raises InputError when another process is writing the file.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._journal = _lock_journal(journal_of(path))
        try:
            super().__init__(os.open(path, os.O_RDWR))
        except BaseException:
            os.close(self._journal)
            raise
        self._tail = bytearray()  # what was written since the last commit: beyond the end of the file,
        self._changed: dict[int, bytearray] = {}  # and pages before it
        self._journal_size = self._lay_over(journal_of(path))
        os.ftruncate(self._journal, self._journal_size)  # what follows the last whole commit is not to be read again
        self._put_in_place()

    def write(self, data: memoryview) -> int:
        """Write bytes, in memory so far."""
        source = memoryview(data).cast("B")
        start, end = self._position, self._position + len(source)
        inside = max(0, min(end, self._committed) - start)
        for offset in range(start - start % PAGE, start + inside, PAGE) if inside else ():
            page = self._bytes(offset, min(offset + PAGE, self._committed))
            first, last = max(start, offset), min(start + inside, offset + PAGE)
            page[first - offset : last - offset] = source[first - start : last - start]
            self._changed[offset] = page
        if inside < len(source):
            self._grow(end)
            position = start + inside - self._committed
            self._tail[position : position + len(source) - inside] = source[inside:]
        self._position = end
        return len(source)

    def truncate(self, size: int) -> int:
        """Set the size; what is committed is never cut off, since readers may still be using it."""
        self._size = max(self._committed, size)
        del self._tail[self._size - self._committed :]
        self._grow(self._size)
        return self._size

    def commit(self) -> None:
        """Make all that was written since the last commit the content of the file.

        Raises Error when the disk is full; the file then stays as the last commit left it.
        """
        if not self._changed and not self._tail:
            return
        payload = b"".join(_CHANGE.pack(at, len(page)) + page for at, page in sorted(self._changed.items()))
        record = _RECORD.pack(self._size, len(payload), _checksum(self._size, payload)) + payload
        try:
            _write_all(self._descriptor, self._tail, self._committed)
            os.fdatasync(self._descriptor)
            if not self._journal_size:
                record = os.pread(self._descriptor, IDENTITY_BYTES, 0) + record
            _write_all(self._journal, record, self._journal_size)
            os.fdatasync(self._journal)
        except OSError as error:
            os.ftruncate(self._journal, self._journal_size)
            os.ftruncate(self._descriptor, self._committed)
            raise Error(
                f"{self._path}: could not be written ({error.strerror}); what was finished before is kept in it; "
                "free some space and start the run again, it goes on"
            ) from error
        self._journal_size += len(record)
        self._committed = self._size
        self._pages.update((at, bytes(page)) for at, page in self._changed.items())
        self._tail.clear()
        self._changed.clear()
        self._put_in_place()

    def flush(self) -> None:
        """Do nothing: HDF5 flushes often, a commit is `commit`."""

    def close(self) -> None:
        """Drop what is not committed; put the rest in place as soon as readers let go, and remove the journal."""
        deadline = time.monotonic() + WAIT_SECONDS
        while not self._put_in_place() and time.monotonic() < deadline:
            time.sleep(0.05)  # a journal that stays is as good: whoever opens the file next takes it into account
        if not self._journal_size:
            journal_of(self._path).unlink(missing_ok=True)
        os.close(self._descriptor)
        os.close(self._journal)

    def _bytes(self, start: int, end: int) -> bytearray:
        data = super()._bytes(start, end)
        _lay_pages(data, start, self._changed)
        first = max(start, self._committed)
        if first < end:
            added = self._tail[first - self._committed : end - self._committed]
            data[first - start : first - start + len(added)] = added
        return data

    def _grow(self, size: int) -> None:
        self._size = max(self._size, size)
        missing = self._size - self._committed - len(self._tail)
        if missing > 0:
            self._tail.extend(bytes(missing))

    def _put_in_place(self) -> bool:
        """Write the committed changes into the file, if nobody is reading it and the disk lets us.

        Returns whether none is left. Those that are left are in the journal, where every reader of ours finds them.
        """
        if not self._journal_size:
            return True
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            for offset, page in self._pages.items():
                _write_all(self._descriptor, page, offset)
            os.ftruncate(self._descriptor, self._committed)
            os.fdatasync(self._descriptor)
            os.ftruncate(self._journal, 0)
        except OSError:
            return False
        finally:
            fcntl.flock(self._descriptor, fcntl.LOCK_UN)
        self._journal_size = 0
        self._pages.clear()
        return True


def journal_of(path: Path) -> Path:
    """Where the journal of a file is while somebody writes it."""
    return path.with_name(path.name + ".journal")


def _lock_journal(journal: Path) -> int:
    """Open the journal for the one writer; raises InputError when there is another."""
    while True:
        try:
            descriptor = os.open(journal, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            raise Error(f"{journal}: could not be made ({error.strerror}); its folder has to be writable") from error
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(descriptor)
            name = journal.with_suffix("")
            raise InputError(f"{name}: another run is writing it; wait for that run or choose another output") from None
        if journal.exists() and os.path.samestat(os.fstat(descriptor), journal.stat()):
            return descriptor
        os.close(descriptor)  # the writer before us was just removing it


def _wait_for_lock(descriptor: int, path: Path) -> None:
    """Take a shared lock; a writer that is putting changes in place needs milliseconds."""
    deadline = time.monotonic() + WAIT_SECONDS
    while True:
        try:
            return fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > deadline:
                raise Error(f"{path}: another program keeps it locked; end that program and try again") from None
            time.sleep(0.005)


def _lay_pages(data: bytearray, start: int, pages: Mapping[int, bytes | bytearray]) -> None:
    """Copy pages, by offset, over data that begin at `start`."""
    for offset in range(start - start % PAGE, start + len(data), PAGE) if pages else ():
        page = pages.get(offset, b"")
        first, last = max(start, offset), min(start + len(data), offset + len(page))
        if first < last:
            data[first - start : last - start] = page[first - offset : last - offset]


def _changes(payload: bytes) -> dict[int, bytes]:
    changes, position = {}, 0
    while position < len(payload):
        offset, length = _CHANGE.unpack_from(payload, position)
        position += _CHANGE.size
        changes[offset] = payload[position : position + length]
        position += length
    return changes


def _checksum(size: int, payload: bytes) -> int:
    return zlib.crc32(payload, zlib.crc32(size.to_bytes(8, "little")))


def _write_all(descriptor: int, data: bytes | bytearray, offset: int) -> None:
    view = memoryview(data)
    while view:
        written = os.pwrite(descriptor, view, offset)
        view, offset = view[written:], offset + written
