"""Long arrays worked on a block at a time, so that what lies between stays in the cache."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from tactgen.geometry.arrays import Complex, Numbers

#: Points in a block: the intermediate arrays then stay in a core's second-level cache.
BLOCK = 4096


def blocks(
    inputs: Sequence[Any], outputs: Sequence[Numbers], size: int = BLOCK
) -> Iterator[tuple[list[Complex], list[Numbers]]]:
    """Yield matching flat pieces of all arrays: inputs to read, outputs to fill.

    Parameters
    ----------
    inputs : sequence of array-like
        Broadcast against each other, and converted to complex.
    outputs : sequence of arrays
        All of the common shape of the inputs.
    size : int
        Points in a block.
    """
    _keep_freed_memory()
    uses: Any = [["readonly"]] * len(inputs) + [["writeonly"]] * len(outputs)
    types: Any = [complex] * len(inputs) + [out.dtype for out in outputs]
    pieces = np.nditer(
        [*(np.asarray(v) for v in inputs), *outputs],
        flags=["external_loop", "buffered", "zerosize_ok"],
        op_flags=uses,
        op_dtypes=types,
        order="C",
        buffersize=size,
    )
    with pieces:
        for piece in pieces:
            yield list(piece[: len(inputs)]), list(piece[len(inputs) :])


def _keep_freed_memory() -> None:
    """Let the GNU allocator keep what blocks free instead of returning it page by page.

    Freeing one large array raises its thresholds (mallopt(3), M_MMAP_THRESHOLD); without
    it every temporary is given back and faulted in anew, which halves the speed.
    """
    np.empty(1 << 20)
