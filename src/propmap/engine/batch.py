"""Operating points in blocks of equal size, on all cores."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.engine.lanes import LANES, serve
from propmap.engine.plan import Job
from propmap.physics.velocities import AzimuthNodes, azimuth_nodes

BLOCK = 32
"""Operating points per call of a program."""

LARGE_NODES = 24576
"""Radial nodes per call in large batches, at most: a call has its price at any size."""

KERNEL_NODES = 3072
"""Radial nodes per call of a large batch whose program is made of kernels: more, and what one hands
on to the next leaves the processor's cache."""

KERNEL_NODES_AXIAL = 12288
"""The same where there is a single azimuth, and a kernel has less to do."""

ACCELERATOR_POINTS = (1024, 32768)
"""Operating points per call on an accelerator, at least and at most: it takes some hundred thousand
nodes to fill one, and memory in proportion."""

FOLLOWED = 2
"""How much longer a node takes where stall is followed, `make bench-phases`."""

LARGE_BATCH = 512
"""Operating points from which on a batch is cut into large blocks: every size is another program
to compile."""


class Block(NamedTuple):
    """Points of a job, as indices into the batch, the azimuths of each, the largest number of them
    in such jobs, the radial nodes per panel, and the size that they are filled up to."""

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
        """About how long it takes, in nodes at which no stall is followed."""
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
    """Jobs cut into blocks.

    Parameters
    ----------
    jobs : sequence of Job
        What is to be computed.
    size : int, optional
        Points of a block; by default one if there is but one point, else ``BLOCK``, or
        ``large_block`` in a large batch.
    large : bool
        Whether blocks are always those of a large batch.
    accelerator : bool
        Whether the programs run on one: then blocks of a large batch are a power of two.
    compiled : bool
        Whether programs are, each for one size; else blocks are small and not filled up.
    """
    points = sum(job.points.size for job in jobs)
    blocks = []
    for job in jobs:
        large_size = accelerator_block(job) if accelerator else large_block(job)
        wide = large_size if large or points >= LARGE_BATCH else BLOCK
        width = wide = size or (1 if points == 1 and not large else wide)
        if wide == large_size and serve(job.panels) and not accelerator:
            # A part for each core: each call costs as much as ten points or more.
            share = -(-job.points.size // cores())
            width = min(wide, -(-share // LANES) * LANES)
        if not compiled:
            width, wide = size or BLOCK, 0
        for start in range(0, job.points.size, width):
            part = slice(start, start + width)
            mine = (job.points[part], job.azimuths[part], job.most_azimuths)
            blocks.append(Block(*mine, job.panels, max(wide, mine[0].size)))
    return blocks


def cores() -> int:
    """Of this machine."""
    return os.cpu_count() or 1


def large_block(job: Job) -> int:
    """Operating points per block of the job in a large batch, at most."""
    nodes = LARGE_NODES
    if not serve(job.panels):
        nodes = KERNEL_NODES_AXIAL if int(job.azimuths.max()) == 1 else KERNEL_NODES
    return max(nodes // sum(job.panels) // BLOCK, 1) * BLOCK


def accelerator_block(job: Job) -> int:
    """The same on an accelerator."""
    least, most = ACCELERATOR_POINTS
    return int(np.clip(1 << (job.points.size - 1).bit_length(), least, most))


def run(blocks: list[Block], one: Callable[[Block], None], *, in_turn: bool = False) -> None:
    """Call ``one`` for every block, on all cores, the longest first so that all end together; or
    ``in_turn``, as suits NumPy, whose threads wait for each other."""
    longest_first = sorted(blocks, key=lambda block: -block.work)
    if in_turn or len(blocks) <= 1:
        for block in longest_first:
            one(block)
        return
    with ThreadPoolExecutor(min(len(blocks), cores())) as pool:
        list(pool.map(one, longest_first))


def filled_up(values: NDArray[Any], size: int) -> NDArray[Any]:
    """The values (n,), from the first on again, up to ``size``."""
    # In a tenth of the time of ``np.resize``, twice per block.
    return values.take(np.arange(size), mode="wrap")


def nodes_of_each(azimuths: NDArray[np.int64], most: int) -> AzimuthNodes:
    """The nodes of points with ``azimuths`` (B,) over a full turn each, padded to ``most``, so that
    one program serves any mixture."""
    half = azimuths // 2
    count: Any = np.maximum(half, 1)
    # By rows in memory, unlike what indexing gives: XLA would have to turn it round.
    return AzimuthNodes(_sines_of_all(most).take(half, axis=1), count)


@functools.cache
def _sines_of_all(most: int) -> NDArray[np.float64]:
    """sin(psi) of every number of nodes up to ``most``, a column for each half of it; the first,
    of zeros, for axial flow."""
    sines = np.zeros((most // 2, most // 2 + 1))
    for half in range(1, most // 2 + 1):
        sines[:half, half] = azimuth_nodes(2 * half).sines
    return sines
