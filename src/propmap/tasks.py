"""Independent tasks, and the workers that run them: this process, threads or other processes."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, Protocol, Self, TypeVar

if TYPE_CHECKING:
    from concurrent.futures import Future

Common = TypeVar("Common")
Task = TypeVar("Task")
Result = TypeVar("Result")


class Workers(Protocol):
    """Interface of all objects that run independent tasks."""

    @property
    def count(self) -> int:
        """Number of tasks that run at the same time."""
        ...

    def results(
        self, work: Callable[[Common, Task], Result], common: Common, tasks: Iterable[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Yield the index of each task in ``tasks`` and its result, in the order of completion.

        Tasks are taken from ``tasks`` when they start, and results are not kept, so that any number
        of tasks fits in memory.

        Parameters
        ----------
        work : callable
            Function at module level (to be pickled), called as ``work(common, task)``.
        common : object
            Argument shared by all tasks.
        tasks : iterable
            Second argument of each task.
        """
        ...


class InTurn:
    """Workers that run one task after the other in this process, each on all cores."""

    count = 1

    def results(
        self, work: Callable[[Common, Task], Result], common: Common, tasks: Iterable[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Yield results as in ``Workers.results``."""
        for place, task in enumerate(tasks):
            yield place, work(common, task)


class InThreads:
    """Workers that run ``count`` tasks at a time in threads, for work that leaves cores idle."""

    def __init__(self, count: int) -> None:
        self.count = count

    def results(
        self, work: Callable[[Common, Task], Result], common: Common, tasks: Iterable[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Yield results as in ``Workers.results``; takes all tasks at once, so keep them few."""
        # Imported here because every rotor imports this module, but few use Python threads.
        from concurrent.futures import ThreadPoolExecutor

        with ThreadPoolExecutor(self.count) as pool:
            yield from _as_completed(pool.submit(work, common, task) for task in tasks)


class InProcesses:
    """Workers that run ``count`` tasks at a time in single-core processes, for work with much
    Python code; the processes end with the ``with`` block."""

    def __init__(self, count: int) -> None:
        from concurrent.futures import ProcessPoolExecutor
        from multiprocessing import get_context

        self.count = count
        # A fork would copy locks that threads hold; only this process handles Ctrl-C.
        quiet = (signal.SIGINT, signal.SIG_IGN)
        self._pool = ProcessPoolExecutor(count, get_context("spawn"), signal.signal, quiet)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    def results(
        self, work: Callable[[Common, Task], Result], common: Common, tasks: Iterable[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Yield results as in ``InThreads.results``."""
        submit = self._pool.submit
        yield from _as_completed(submit(_on_one_core, work, common, task) for task in tasks)


def _as_completed(futures: Iterable[Future[Result]]) -> Iterator[tuple[int, Result]]:
    from concurrent.futures import as_completed

    places = {future: place for place, future in enumerate(futures)}
    for done in as_completed(places):
        yield places[done], done.result()


def _on_one_core(work: Callable[[Common, Task], Result], common: Common, task: Task) -> Result:
    with on_cores(1):
        return work(common, task)


def in_order(results: Iterable[tuple[int, Result]]) -> list[Result]:
    """Return the ``results`` of ``Workers.results`` in the order of their tasks."""
    return [result for _, result in sorted(results, key=lambda one: one[0])]


_OWN_CORES = os.cpu_count() or 1
_most_cores: ContextVar[int | None] = ContextVar("most_cores", default=None)


@contextmanager
def on_cores(most: int) -> Iterator[None]:
    """Use at most ``most`` cores in this thread; the loads do not depend on this number."""
    token = _most_cores.set(most)
    try:
        yield
    finally:
        _most_cores.reset(token)


def cores() -> int:
    """Return the number of processor cores that evaluations may use."""
    most = _most_cores.get()
    return min(_OWN_CORES, most) if most else _OWN_CORES
