"""Workers of a Dask cluster, on this computer or at an address, all with the same versions."""

from __future__ import annotations

import functools
import itertools
import logging
import os
import pickle
import re
import signal
import tempfile
import time
import uuid
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from queue import Empty, Queue
from typing import TYPE_CHECKING, Any

from propmap.errors import InputError, quoted, require
from propmap.tasks import Common, Result, Task, on_cores

if TYPE_CHECKING:
    from distributed import Client, Future


ANSWER_WITHIN = 5.0  # timeout for the answer of a scheduler [s]
START_WITHIN = 60.0  # timeout for the start of a worker on this computer [s]

MOST_LOCAL = 1024

FAILURES = 10  # number of workers on this computer that one task may lose before it fails

REMEDY = "write local, local:4 for four workers on this computer, or tcp://host:8786"


@contextmanager
def connected(address: str) -> Iterator[DaskWorkers]:
    """Yield the workers at an address for the duration of a ``with`` block.

    Parameters
    ----------
    address : str
        "local" for one single-threaded worker per core of this computer, "local:4" for four; or
        the address of a scheduler, "tcp://host:port" or "tls://host:port".

    Raises
    ------
    InputError
        For an invalid address, a scheduler that does not answer or has no workers, and different
        versions of client, scheduler and workers.
    """
    local = re.fullmatch(r"local(?::(.*))?", address)
    remote = re.fullmatch(r"(?:tcp|tls)://[^\s/:]+:(\d+)", address)
    if remote is not None and 0 < int(remote[1]) < 65536:
        started = _remote(address)
    elif local is not None:
        started = _local(_number(address, local[1]))
    else:
        raise InputError(f"--cluster {quoted(address)} is not an address", REMEDY)
    require("cluster")
    with started as workers:
        yield workers


def _number(address: str, text: str | None) -> int:
    """Return the number of workers of ``local:text``."""
    if text is None:
        return os.cpu_count() or 1
    if not text.isdecimal() or not 1 <= int(text) <= MOST_LOCAL:
        found = f"--cluster {quoted(address)} asks for {quoted(text)} workers"
        raise InputError(found, f"give a number from 1 to {MOST_LOCAL}")
    return int(text)


@contextmanager
def _local(count: int) -> Iterator[DaskWorkers]:
    import dask
    from distributed import Client, LocalCluster

    settings: Any = {
        "distributed.scheduler.allowed-failures": FAILURES,
        # The scheduler logs finished tasks, by default up to a hundred thousand entries.
        "distributed.admin.low-level-log-length": 1000,
        "distributed.admin.log-length": 1000,
        # The cluster replaces a worker that died during its start after this time.
        "distributed.deploy.lost-worker-timeout": "5 s",
    }
    with (
        tempfile.TemporaryDirectory(prefix="propmap-workers-") as folder,
        dask.config.set(settings),
        LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            processes=True,
            dashboard_address="127.0.0.1:0",
            local_directory=folder,
            silence_logs=logging.CRITICAL,
            preload=["propmap.cluster"],
        ) as cluster,
        Client(cluster, timeout=START_WITHIN) as client,
    ):
        cluster.adapt(minimum=count, maximum=count)
        yield DaskWorkers(client)


@contextmanager
def _remote(address: str) -> Iterator[DaskWorkers]:
    from distributed import Client
    from distributed.versions import VersionMismatchWarning

    try:
        with warnings.catch_warnings():
            # ``DaskWorkers`` checks the versions that must agree.
            warnings.simplefilter("ignore", VersionMismatchWarning)
            client = Client(address, timeout=ANSWER_WITHIN)
    except (OSError, TimeoutError):
        found = f"no scheduler answers within {ANSWER_WITHIN:g} s"
        remedy = "start one (dask scheduler), or check that its port can be reached from here"
        raise InputError(found, remedy, address) from None
    with client:
        yield DaskWorkers(client)


# --- The workers of a Dask cluster: tasks are sent on demand, results arrive in any order --------

AHEAD = 3  # queued tasks per thread of the workers, so that no thread waits for the client
RECOUNT = 2.0  # interval at which the workers are counted, since workers join and leave [s]
ALONE = 60.0  # time that a run without workers waits for a new worker [s]
KEPT = 4  # number of shared arguments of tasks, such as rotors, that a worker caches

GONE = InputError(
    "the connection to the scheduler is lost", "start it and run the command again to resume"
)


class DaskWorkers:
    """A ``propmap.tasks.Workers`` that runs tasks on the workers of a Dask cluster.

    Each task takes one core of a worker.  If a worker dies, another worker repeats its task.

    Parameters
    ----------
    client : distributed.Client
        Connected to the scheduler.

    Raises
    ------
    InputError
        Without workers, and for different versions of client, scheduler and workers.
    """

    def __init__(self, client: Client) -> None:

        self.client = client
        check_versions(client)

    @property
    def count(self) -> int:
        """Number of threads of all workers; 0 if the scheduler does not answer."""
        try:
            return sum(self.client.nthreads().values())
        except OSError:
            return 0

    def results(
        self, work: Callable[[Common, Task], Result], common: Common, tasks: Iterable[Task]
    ) -> Iterator[tuple[int, Result]]:
        """Yield the results of ``work`` on ``common`` and the ``tasks``, as ``Workers.results``.

        Raises
        ------
        InputError
            For a task whose workers died repeatedly, and for a lost scheduler.
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
                # At least one task is sent: without workers, a new one may join.
                send(max(most - len(under_way), int(not under_way)))
                yield place, result
        finally:
            if self.client.status == "running":
                self.client.cancel(list(under_way))

    def _next(self, done: Queue[Future]) -> Future:
        """Wait for the next finished task; raise ``InputError`` if no workers are left."""
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
                found = f"all workers left, and none joined for {ALONE:g} s"
                remedy = "start workers, and run the command again to resume"
                raise InputError(found, remedy, str(self.client.scheduler.address))


def _run(work: Callable[[Any, Any], Any], common: bytes, task: Any) -> Any:
    """Run ``work(common, task)`` on one core of a worker, which caches ``common``."""
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
            "check the logs and the memory of the workers, and run the command again to resume",
        ) from None
    except (FutureCancelledError, OSError) as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise  # an error of the task itself, such as a full disk
        raise GONE from None


def dask_setup(worker: object) -> None:
    """Make a ``worker`` that preloads this module ignore Ctrl-C: the client ends its workers."""
    del worker
    signal.signal(signal.SIGINT, signal.SIG_IGN)


# --- Check that client, scheduler and workers have the same versions -----------------------------

SAME = ("propmap", "numpy", "python", "distributed")  # packages whose versions must agree


def check_versions(client: Client) -> None:
    """Raise ``InputError`` without workers and for versions that differ from the ``client``."""
    found: Any = client.get_versions(packages=list(SAME))
    if not found["workers"]:
        fault = "the scheduler has no workers"
        remedy = f"start workers: dask worker {client.scheduler.address}"
        raise InputError(fault, remedy, str(client.scheduler.address))
    for message in differences(found):
        raise InputError(*message)


def differences(found: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield each difference of versions in ``found`` from the client, and its remedy."""
    own = _versions(found["client"])
    others = {"the scheduler": found["scheduler"]}
    others |= {f"worker {address}": one for address, one in found["workers"].items()}
    for who, one in others.items():
        theirs = _versions(one)
        for package in SAME:
            if theirs.get(package) is None:
                remedy = f"install propmap {own['propmap']} with its extra cluster there"
                yield f"{who} does not have {package}", remedy
            elif theirs[package] != own[package]:
                yield (
                    f"{who} has {package} {theirs[package]}, the client has {own[package]}",
                    "install the same version on both",
                )


def _versions(found: Any) -> dict[str, str | None]:
    if not isinstance(found, Mapping):
        return {}  # the worker did not answer
    # "3.12.3.final.0": the format of pickled tasks depends on the first two numbers.
    python = ".".join(str(found["host"]["python"]).split(".")[:2])
    return {**found["packages"], "python": python}
