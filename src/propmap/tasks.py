"""Work that is cut into independent tasks, and who does it: this process, others, or a cluster."""

from __future__ import annotations

import os
import signal
import sys
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
    """Whoever does tasks."""

    @property
    def count(self) -> int:
        """How many tasks they do at a time."""
        ...

    def results(
        self, work: Callable[[Common, Task], Result], common: Common, tasks: Iterable[Task]
    ) -> Iterator[tuple[int, Result]]:
        """The place of each task in ``tasks`` and its result, in the order in which they are done.

        Tasks are taken from ``tasks`` as they are begun, and results are not kept: any number of
        them fits in memory.

        Parameters
        ----------
        work : callable
            A function of a module, called as ``work(common, task)``.
        common : object
            What all tasks share.
        tasks : iterable
            What differs.
        """
        ...


class InTurn:
    """One task after the other in this process, each on all cores."""

    count = 1

    def results(
        self, work: Callable[[Common, Task], Result], common: Common, tasks: Iterable[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Do tasks as ``Workers.results``."""
        for place, task in enumerate(tasks):
            yield place, work(common, task)


class InThreads:
    """Does ``count`` tasks at a time in threads, for work that does not use all cores by itself."""

    def __init__(self, count: int) -> None:
        self.count = count

    def results(
        self, work: Callable[[Common, Task], Result], common: Common, tasks: Iterable[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Do tasks as ``Workers.results``, but of a short list: all are taken at once."""
        # Imported here, as every rotor imports this module and few use threads of Python.
        from concurrent.futures import ThreadPoolExecutor

        with ThreadPoolExecutor(self.count) as pool:
            yield from _as_completed(pool.submit(work, common, task) for task in tasks)


class InProcesses:
    """Does ``count`` tasks at a time in processes of one core, which end with its ``with``, for
    work of which Python does much."""

    def __init__(self, count: int) -> None:
        from concurrent.futures import ProcessPoolExecutor
        from multiprocessing import get_context

        self.count = count
        # A fork would take along locks that threads hold; Ctrl-C is for this process to hear.
        quiet = (signal.SIGINT, signal.SIG_IGN)
        self._pool = ProcessPoolExecutor(count, get_context("spawn"), signal.signal, quiet)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    def results(
        self, work: Callable[[Common, Task], Result], common: Common, tasks: Iterable[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Do tasks as ``InThreads.results``."""
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
    """Sort ``results``, as of ``Workers.results``, into the order of their tasks."""
    return [result for _, result in sorted(results, key=lambda one: one[0])]


_OWN_CORES = os.cpu_count() or 1
_most_cores: ContextVar[int | None] = ContextVar("most_cores", default=None)


@contextmanager
def on_cores(most: int) -> Iterator[None]:
    """Use ``most`` cores at most in this thread; loads do not depend on it."""
    token = _most_cores.set(most)
    try:
        yield
    finally:
        _most_cores.reset(token)


def cores() -> int:
    """Number of processor cores that evaluations may use."""
    return min(_OWN_CORES, _most_cores.get() or sys.maxsize)
