"""Streaming: parts are computed by workers and filed, by them where they see the store."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from propmap.sweep.points import Place
from propmap.sweep.store import Layout
from propmap.tasks import Workers

Values = dict[str, Any]
"""Arrays by quantity."""


class Filed(Protocol):
    """Where parts go: a ``Store``, or what takes its place."""

    @property
    def here(self) -> bool:
        """Whether this process can write to it."""
        ...

    def write(self, place: Place, values: Mapping[str, NDArray[Any]]) -> None:
        """File the ``values`` of the part at a ``place``, by quantity."""
        ...

    def done(self, layout: Layout) -> NDArray[np.bool_]:
        """Which parts of the ``layout`` are filed, by place."""
        ...


@dataclass(frozen=True)
class Filing:
    """What all tasks of a run share.

    Attributes
    ----------
    work : callable
        Gives the values of a part, called as ``work(common, part)``.
    common : object
        What it needs for all parts.
    store : Filed
        Where they go.
    """

    work: Callable[[Any, Any], Values]
    common: Any
    store: Filed


def file_part(filing: Filing, task: tuple[Place, Any]) -> Values | None:
    """Compute and file a part; its values, to be filed by the caller, where the store is not seen.

    Parameters
    ----------
    filing : Filing
        How, and where to.
    task : tuple
        The place of the part and the part.
    """
    place, part = task
    values = filing.work(filing.common, part)
    if not filing.store.here:
        return values
    filing.store.write(place, values)
    return None


def stream(
    workers: Workers,
    filing: Filing,
    layout: Layout,
    part: Callable[[Place, tuple[int, ...]], Any],
) -> Iterator[int]:
    """Compute and file all parts that are missing; yields how many parts are done.

    Parameters
    ----------
    workers : Workers
        Who computes.
    filing : Filing
        How, and where to.
    layout : Layout
        Of the store.
    part : callable
        The part at a place, called with the place and the shape of parts.
    """
    done = filing.store.done(layout)
    count = int(done.sum())
    yield count
    missing = np.flatnonzero(~done)

    def place(which: int) -> Place:
        return tuple(int(k) for k in np.unravel_index(missing[which], done.shape))

    # Made one by one, as workers become free.
    at = map(place, range(missing.size))
    tasks = ((where, part(where, layout.chunk)) for where in at)
    for which, values in workers.results(file_part, filing, tasks):
        if values is not None:
            filing.store.write(place(which), values)
        count += 1
        yield count


def seconds(workers: Workers, work: Callable[[Any, Any], Values], common: Any, part: Any) -> float:
    """Time that a worker takes for a part [s].

    Parameters
    ----------
    workers : Workers
        Of whom one is asked.
    work, common : callable, object
        As in ``Filing``.
    part : object
        The part.
    """
    ((_, found),) = workers.results(_timed, (work, common), [part])
    return found


def _timed(asked: tuple[Callable[[Any, Any], Values], Any], part: Any) -> float:
    """Of the second time: at the first one modules are loaded."""
    work, common = asked
    work(common, part)
    start = time.perf_counter()
    work(common, part)
    return time.perf_counter() - start
