"""Linear algebra on one thread, whatever the environment says.

Threads of a product wait for each other. Beside other work on the same cores they do so nearly all of the time: modes
that take 13 s on two idle cores then take 228 s, on one thread 16 s either way.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit BLAS and LAPACK to one thread, in a block or, as a decorator, in a function."""
    with threadpool_limits(1):
        yield
