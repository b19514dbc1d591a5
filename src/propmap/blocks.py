"""Operating points in blocks of equal size, on all cores."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.schedule import Job
from propmap.theory.velocities import AzimuthNodes, azimuth_nodes

BLOCK = 32
"""Operating points per call of a compiled program: enough to fill the vector units, few
enough to stay in the processor's cache."""

LARGE_NODES = 6144
"""Radial nodes per call in large batches, to spread what a step costs at any size."""

LARGE_BATCH = 2048
"""Operating points from which on a batch is cut into large blocks.  A batch has one size, though
its last points would fill a small block better: every size is another program to compile."""


class Block(NamedTuple):
    """Points of a job, as indices into the batch, and the size that they are filled up to."""

    job: Job
    points: NDArray[np.intp]
    size: int

    @property
    def padded(self) -> NDArray[np.intp]:
        """The points, repeated up to ``size``."""
        return np.resize(self.points, self.size)


def cut(jobs: Sequence[Job], size: int | None = None, *, large: bool = False) -> list[Block]:
    """Jobs cut into blocks of ``size`` points; by default of one if there is but one point, else
    ``BLOCK``, or ``large_block`` in a large batch; or always so if ``large``."""
    points = sum(job.points.size for job in jobs)
    blocks = []
    for job in jobs:
        wide = large_block(job) if large or points >= LARGE_BATCH else BLOCK
        width = size or (1 if points == 1 and not large else wide)
        starts = range(0, job.points.size, width)
        blocks += [Block(job, job.points[start : start + width], width) for start in starts]
    return blocks


def large_block(job: Job) -> int:
    """Operating points per block of the job in a large batch."""
    return max(LARGE_NODES // sum(job.panels) // BLOCK, 1) * BLOCK


def run(blocks: list[Block], one: Callable[[Block], None], *, in_turn: bool = False) -> None:
    """Call ``one`` for every block, on all cores, the longest first so that all end together; or
    ``in_turn``, as suits NumPy, whose threads wait for each other."""
    longest_first = sorted(blocks, key=lambda b: -b.size * sum(b.job.panels) * b.job.azimuths)
    if in_turn or len(blocks) <= 1:
        for block in longest_first:
            one(block)
        return
    with ThreadPoolExecutor(min(len(blocks), os.cpu_count() or 1)) as pool:
        list(pool.map(one, longest_first))


def padded_azimuths(count: int, most: int) -> AzimuthNodes:
    """Nodes padded to one length, so that one program serves every count."""
    nodes = azimuth_nodes(count)
    sines = np.zeros(most // 2)
    sines[: nodes.sines.size] = nodes.sines
    used: Any = np.array(nodes.sines.size)
    return AzimuthNodes(sines, used)
