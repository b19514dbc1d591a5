"""Operating points in blocks of equal size, on all cores."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.engine.lanes import LANES, use_lanes
from propmap.engine.plan import Job
from propmap.physics.velocities import AzimuthNodes, azimuth_nodes
from propmap.tasks import cores

BLOCK = 32
"""Operating points per call of a program."""

LARGE_NODES = 24576
"""Radial nodes per call in a large batch, at most; each call also has a fixed cost."""

KERNEL_NODES = 3072
"""The same for programs made of many kernels, see ``engine.lanes``: with more nodes the arrays that
one kernel hands to the next do not fit in the processor's cache."""

KERNEL_NODES_AXIAL = 12288
"""The same for a single azimuth, where arrays are smaller."""

ACCELERATOR_POINTS = (1024, 32768)
"""Operating points per call on an accelerator, at least and at most: it takes some hundred thousand
nodes to keep one busy, and memory grows with them."""

FOLLOWED = 2
"""Time of a node where stall is followed, relative to one where it is not: `make bench-phases`."""

LARGE_BATCH = 512
"""Operating points from which on a batch is cut into large blocks.  Smaller ones are not worth it:
each size of block is another program to compile."""


class Block(NamedTuple):
    """A part of a ``Job``, evaluated in one call: indices of its points, their azimuth nodes, the
    largest number of these in such jobs, radial nodes per panel, and the size it is padded to."""

    points: NDArray[np.intp]
    azimuths: NDArray[np.int64]
    most_azimuths: int
    panels: tuple[int, ...]
    size: int

    @property
    def padded(self) -> NDArray[np.intp]:
        """The points, repeated up to ``size``."""
        return filled_up(self.points, self.size)

    @property
    def work(self) -> int:
        """Estimated time of the call, in that of a node where stall is not followed."""
        nodes = sum(self.panels) * int(self.azimuths.sum())
        return nodes if len(self.panels) == 1 else FOLLOWED * nodes


def cut(
    jobs: Sequence[Job],
    size: int | None = None,
    *,
    large: bool = False,
    accelerator: bool = False,
    compiled: bool = True,
) -> list[Block]:
    """Cut jobs into blocks.

    Parameters
    ----------
    jobs : sequence of Job
        From ``plan``.
    size : int, optional
        Points per block; by default 1 for a single point, else ``BLOCK``, or ``large_block`` in a
        large batch.
    large : bool
        Whether blocks are always those of a large batch.
    accelerator : bool
        Whether programs run on a GPU or the like: then large blocks are a power of two.
    compiled : bool
        Whether programs are compiled, each for one size; else blocks are small and not padded.
    """
    points = sum(job.points.size for job in jobs)
    blocks = []
    for job in jobs:
        large_size = accelerator_block(job) if accelerator else large_block(job)
        wide = large_size if large or points >= LARGE_BATCH else BLOCK
        width = wide = size or (1 if points == 1 and not large else wide)
        if wide == large_size and use_lanes(job.panels) and not accelerator:
            # One block for each core: each call costs as much as ten points or more.
            share = -(-job.points.size // cores())
            width = min(wide, -(-share // LANES) * LANES)
        if not compiled:
            width, wide = size or BLOCK, 0
        for start in range(0, job.points.size, width):
            part = slice(start, start + width)
            mine = (job.points[part], job.azimuths[part], job.most_azimuths)
            blocks.append(Block(*mine, job.panels, max(wide, mine[0].size)))
    return blocks


def large_block(job: Job) -> int:
    """Operating points per block of the job in a large batch, at most."""
    nodes = LARGE_NODES
    if not use_lanes(job.panels):
        nodes = KERNEL_NODES_AXIAL if int(job.azimuths.max()) == 1 else KERNEL_NODES
    return max(nodes // sum(job.panels) // BLOCK, 1) * BLOCK


def accelerator_block(job: Job) -> int:
    """The same on an accelerator."""
    least, most = ACCELERATOR_POINTS
    return int(np.clip(1 << (job.points.size - 1).bit_length(), least, most))


def run(blocks: list[Block], one: Callable[[Block], None], *, in_turn: bool = False) -> None:
    """Call ``one`` for every block, on all cores, the longest first so that all cores end together;
    or one after the other if ``in_turn``, as for NumPy, whose threads wait for each other."""
    longest_first = sorted(blocks, key=lambda block: -block.work)
    if in_turn or len(blocks) <= 1:
        for block in longest_first:
            one(block)
        return
    # One block of each program comes first, so that programs are compiled beside each other.
    firsts = {block.panels: at for at, block in reversed(list(enumerate(longest_first)))}
    order = [*firsts.values(), *(k for k in range(len(blocks)) if k not in firsts.values())]
    with ThreadPoolExecutor(min(len(blocks), cores())) as pool:
        list(pool.map(one, (longest_first[k] for k in order)))


def filled_up(values: NDArray[Any], size: int) -> NDArray[Any]:
    """The values (n,), repeated from the first one up to ``size``."""
    # Ten times as fast as ``np.resize``, and called twice per block.
    return values.take(np.arange(size), mode="wrap")


def nodes_of_each(azimuths: NDArray[np.int64], most: int) -> AzimuthNodes:
    """Nodes of points, ``azimuths`` (B,) over a full turn each, padded to ``most``, so that one
    program serves any mixture of these numbers."""
    half = azimuths // 2
    count: Any = np.maximum(half, 1)
    # ``take`` gives an array in row order; indexing would not, and XLA would have to transpose it.
    return AzimuthNodes(_sines_of_all(most).take(half, axis=1), count)


@functools.cache
def _sines_of_all(most: int) -> NDArray[np.float64]:
    """sin(psi) for every even number of nodes up to ``most``: column h is for 2 h nodes, column 0,
    which is zero, for axial flow."""
    sines = np.zeros((most // 2, most // 2 + 1))
    for half in range(1, most // 2 + 1):
        sines[:half, half] = azimuth_nodes(2 * half).sines
    return sines
