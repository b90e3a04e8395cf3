"""Prints what the first solve of a process takes beyond the second: our kernels are loaded, or compiled."""

from __future__ import annotations

from peers import one_thread  # noqa: F401  before all that starts threads

# isort: split

from peers import risorius_block
from peers.block import Block
from peers.side_by_side import timed

if __name__ == "__main__":
    block = Block.of_hexahedra((2, 2, 2))
    first, second = (timed(block, lambda block: risorius_block.prepare(block, "superlu")).total_s for _ in range(2))
    print(first - second)
