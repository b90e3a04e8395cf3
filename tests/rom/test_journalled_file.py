"""A file that changes by whole commits: every crash that its system calls allow, full disks, readers meanwhile."""

import errno
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

from risorius import journalled_file
from risorius.errors import Error, InputError
from risorius.journalled_file import FileReader, FileWriter, journal_of

LAST = 3


class Crash(BaseException):
    pass


class Calls:
    """System calls that change files, the last of which is half done when the program dies of it."""

    def __init__(self, monkeypatch):
        self.done, self.fatal = 0, None
        for name in ("pwrite", "ftruncate"):
            monkeypatch.setattr(journalled_file.os, name, self.guarded(getattr(os, name)))

    def guarded(self, call):
        def guard(descriptor, what, *where):
            self.done += 1
            if self.done == self.fatal:
                if where:
                    call(descriptor, what[: len(what) // 2], *where)
                raise Crash
            return call(descriptor, what, *where)

        return guard


def field(number):
    return np.random.default_rng(number).normal(size=(100, 3))


def make(path):
    with h5py.File(path, "w", userblock_size=512) as file:
        file.create_dataset("field", (0, 100, 3), "f8", maxshape=(None, 100, 3), chunks=(1, 100, 3), compression="gzip")
        file.create_dataset("reason", (0,), h5py.string_dtype(), maxshape=(None,), chunks=(4,))
    with path.open("r+b") as raw:
        raw.write(b"test file 1".ljust(64))


def append(view, file):
    number = len(file["field"])
    for data in file.values():
        data.resize(number + 1, axis=0)
    file["field"][number], file["reason"][number] = field(number), f"reason {number}"
    file.flush()
    view.commit()


def fill(path, count, told=lambda number: None):
    view = FileWriter(path)
    try:
        with h5py.File(view, "r+") as file:
            while len(file["field"]) < count:
                append(view, file)
                told(len(file["field"]))
    except Error:  # a program that goes on tidies up, a crash does not
        view.close()
        raise
    view.close()


def number_of_whole_entries(path):
    view = FileReader(path)
    with h5py.File(view, "r") as file:
        count = len(file["field"])
        for number in range(count):
            np.testing.assert_array_equal(file["field"][number], field(number))
            assert file["reason"][number].decode() == f"reason {number}"
    view.close()
    return count


def fill_and_die(path, fatal):
    """Die in the middle of a system call; return whether there were so many, and how many entries were committed.

    In a process of its own: one that is gone keeps no lock.
    """
    receiving, telling = os.pipe()
    child = os.fork()
    if child:
        os.close(telling)
        with os.fdopen(receiving, "rb") as pipe:
            committed = max(pipe.read(), default=0)
        return os.waitpid(child, 0)[1] != 0, committed
    with pytest.MonkeyPatch.context() as patch:
        calls = Calls(patch)
        calls.fatal = fatal
        try:
            fill(path, LAST, lambda number: os.write(telling, bytes([number])))
        except BaseException:  # noqa: BLE001
            os._exit(1)
        os._exit(0)


def test_a_crash_at_any_system_call_loses_nothing_that_was_committed(tmp_path):
    fatal, died = 0, True
    while died:
        fatal += 1
        path = tmp_path / f"{fatal}.h5"
        make(path)
        fill(path, 1)
        died, committed = fill_and_die(path, fatal)
        assert max(1, committed) <= number_of_whole_entries(path) <= LAST
        fill(path, LAST)  # it goes on
        assert number_of_whole_entries(path) == LAST
        assert not journal_of(path).exists()
    assert fatal > 2 * 4  # two commits of several calls each


def test_a_process_that_is_killed_again_and_again_gets_to_the_end(tmp_path):
    path = tmp_path / "s.h5"
    make(path)
    script = (
        "import sys; sys.path[:0] = sys.argv[2:]\n"
        "from pathlib import Path\n"
        "from tests.rom.test_journalled_file import fill\n"
        "print('ready', flush=True)\n"
        "fill(Path(sys.argv[1]), 100000)\n"
    )
    root = str(Path(__file__).parents[2])
    rng, before = np.random.default_rng(0), 0
    for _ in range(6):
        with subprocess.Popen([sys.executable, "-c", script, path, root], stdout=subprocess.PIPE) as process:
            process.stdout.readline()
            time.sleep(rng.uniform(0.0, 0.1))
            process.kill()
        after = number_of_whole_entries(path)
        assert after >= before
        before = after
    assert before > 0


def test_a_full_disk_is_told_and_leaves_the_file_as_it_was(tmp_path):
    path = tmp_path / "s.h5"
    make(path)
    fill(path, 3)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (path.stat().st_size + 5000, limits[1]))
    try:
        with pytest.raises(Error, match=r"s\.h5: could not be written .*; what was finished before is kept in it"):
            fill(path, 100)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, before)
    assert 3 <= number_of_whole_entries(path) < 100
    fill(path, 100)
    assert number_of_whole_entries(path) == 100


def test_what_the_disk_refuses_to_take_in_place_stays_in_the_journal(tmp_path, monkeypatch):
    path = tmp_path / "s.h5"
    make(path)
    fill(path, 1)
    end, write = path.stat().st_size, journalled_file._write_all

    def refuse(descriptor, data, offset):
        if 0 < offset < end and len(data) == journalled_file.PAGE:
            raise OSError(errno.ENOSPC, "no space")
        write(descriptor, data, offset)

    with monkeypatch.context() as patch:
        patch.setattr(journalled_file, "_write_all", refuse)
        patch.setattr(journalled_file, "WAIT_SECONDS", 0.0)
        fill(path, 4)
    assert journal_of(path).exists()
    assert number_of_whole_entries(path) == 4
    fill(path, 5)
    assert number_of_whole_entries(path) == 5
    assert not journal_of(path).exists()


@pytest.mark.parametrize("reader", ["ours", "plain h5py"])
def test_a_reader_sees_one_commit_and_does_not_hold_up_the_writer(reader, tmp_path):
    path = tmp_path / "s.h5"
    make(path)
    fill(path, 3)
    view = FileReader(path) if reader == "ours" else path
    with h5py.File(view, "r") as early:
        writer = FileWriter(path)
        with h5py.File(writer, "r+") as file:
            for _ in range(20):
                append(writer, file)
            assert number_of_whole_entries(path) == 23  # whoever opens it now
            assert len(early["field"]) == len(early["reason"]) == 3
            for number in range(3):
                np.testing.assert_array_equal(early["field"][number], field(number))
    if reader == "ours":
        view.close()
    writer.close()
    with h5py.File(path, "r") as file:
        assert len(file["field"]) == 23
    assert not journal_of(path).exists()


def test_two_writers_are_refused(tmp_path):
    path = tmp_path / "s.h5"
    make(path)
    first = FileWriter(path)
    with pytest.raises(InputError, match=r"s\.h5: another run is writing it"):
        FileWriter(path)
    first.close()
    FileWriter(path).close()


def test_the_journal_of_another_file_is_not_taken(tmp_path):
    path, other = tmp_path / "s.h5", tmp_path / "other.h5"
    make(path)
    fill(path, 1)
    for fatal in range(1, 20):  # until a whole commit is in the journal, and not yet in the file
        fill_and_die(path, fatal)
        if journal_of(path).exists() and journal_of(path).stat().st_size:
            break
    make(other)
    with other.open("r+b") as raw:
        raw.write(b"test file 2".ljust(64))
    fill(other, 2)
    other.replace(path)
    assert number_of_whole_entries(path) == 2
    fill(path, 3)
    assert number_of_whole_entries(path) == 3
