"""The workers of a Dask cluster: tasks sent as they are needed, results taken as they come."""

from __future__ import annotations

import functools
import itertools
import pickle
import time
import uuid
from collections.abc import Callable, Iterable, Iterator
from queue import Empty, Queue
from typing import TYPE_CHECKING, Any

from propmap.errors import InputError
from propmap.tasks import Common, Result, Task, on_cores

if TYPE_CHECKING:
    from distributed import Client, Future

AHEAD = 3
"""Tasks under way per thread of the workers: one that runs and two that wait for it, so that no
worker waits for the client.  The client holds no more than these."""

RECOUNT = 2.0
"""After so long the workers are counted again [s]: some may have joined or left."""

ALONE = 60.0
"""Time that a run waits for a worker where none is left [s]."""

KEPT = 4
"""Things shared by tasks, such as rotors, that a worker keeps at a time."""

GONE = InputError("the scheduler went away", "start it, and run the command again to go on")


class DaskWorkers:
    """Does tasks on the workers of a Dask cluster; a ``propmap.tasks.Workers``.

    Each task takes one core of a worker.  A task whose worker dies is done by another.

    Parameters
    ----------
    client : distributed.Client
        Connected to the scheduler.

    Raises
    ------
    InputError
        Where there is no worker, and where versions differ between client, scheduler and workers.
    """

    def __init__(self, client: Client) -> None:
        from propmap.cluster.versions import check_versions

        self.client = client
        check_versions(client)

    @property
    def count(self) -> int:
        """Threads of all workers; 0 where the scheduler does not answer."""
        try:
            return sum(self.client.nthreads().values())
        except OSError:
            return 0

    def results(
        self,
        work: Callable[[Common, Task], Result],
        common: Common,
        tasks: Iterable[Task],
    ) -> Iterator[tuple[int, Result]]:
        """``work`` of ``common`` and each of the ``tasks``, as ``Workers.results``.

        Raises
        ------
        InputError
            Where a task has brought down worker after worker, and where the scheduler is lost.
        """
        import cloudpickle

        name = f"propmap-{work.__name__}-{uuid.uuid4().hex[:8]}"
        shared = (work, cloudpickle.dumps(common))
        waiting = enumerate(tasks)
        under_way: dict[Future, int] = {}
        done: Queue[Future] = Queue()

        def send(count: int) -> None:
            for place, task in itertools.islice(waiting, count):
                key = f"{name}-{place}"
                future = self.client.submit(_run, *shared, task, key=key, pure=False)
                under_way[future] = place
                future.add_done_callback(done.put)

        try:
            most, counted = AHEAD * self.count, time.monotonic()
            send(most)
            while under_way:
                future = self._next(done)
                place = under_way.pop(future)
                result = _result(future)
                future.release()
                if time.monotonic() - counted > RECOUNT:
                    most, counted = AHEAD * self.count, time.monotonic()
                # One at least: where no worker is left, one may come.
                send(max(most - len(under_way), int(not under_way)))
                yield place, result
        finally:
            if self.client.status == "running":
                self.client.cancel(list(under_way))

    def _next(self, done: Queue[Future]) -> Future:
        """The next task that is done; ``InputError`` where there is nobody to do any."""
        alone_since = None
        while True:
            try:
                return done.get(timeout=RECOUNT)
            except Empty:
                pass
            if self.client.status != "running":
                raise GONE
            now = time.monotonic()
            alone_since = None if self.count else (alone_since or now)
            if alone_since is not None and now - alone_since > ALONE:
                raise InputError(
                    f"all workers left, and none came for {ALONE:g} s",
                    "start some and run the command again to go on",
                    str(self.client.scheduler.address),
                )


def _run(work: Callable[[Any, Any], Any], common: bytes, task: Any) -> Any:
    """``work(common, task)`` at a worker, on one core; what tasks share is kept there."""
    with on_cores(1):
        return work(_shared(common), task)


@functools.lru_cache(KEPT)
def _shared(common: bytes) -> Any:
    return pickle.loads(common)


def _result(future: Future) -> Any:
    from distributed import KilledWorker
    from distributed.client import FutureCancelledError

    try:
        return future.result()
    except KilledWorker as error:
        raise InputError(
            f"task {future.key} ran on {error.allowed_failures + 1} workers that died, the last "
            f"was {error.last_worker.address}",
            "see the workers' logs, memory above all, and run the command again to go on",
        ) from None
    except (FutureCancelledError, OSError) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise  # of the task itself, such as a full disk
        raise GONE from None
