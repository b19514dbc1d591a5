"""Workers of a Dask cluster, from ``--cluster local:4`` or an address, all of the same versions."""

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


ANSWER_WITHIN = 5.0  # time that a scheduler has to answer [s]
START_WITHIN = 60.0  # time that a worker of this machine has to start [s]

MOST_LOCAL = 1024

FAILURES = 10  # workers of this machine that one task may lose before it is given up

REMEDY = "write local, local:4 for four workers on this machine, or tcp://host:8786"


@contextmanager
def connected(address: str) -> Iterator[DaskWorkers]:
    """The workers at an address, for the time of a ``with`` block.

    Parameters
    ----------
    address : str
        "local" for a worker per core of this machine, "local:4" for four, each with one thread; or
        that of a scheduler, "tcp://host:port" or "tls://host:port".

    Raises
    ------
    InputError
        For another text, where no scheduler answers or it has no workers, and where versions
        differ.
    """
    local = re.fullmatch(r"local(?::(.*))?", address)
    remote = re.fullmatch(r"(?:tcp|tls)://[^\s/:]+:(\d+)", address)
    if remote is not None and 0 < int(remote[1]) < 65536:
        started = _remote(address)
    elif local is not None:
        started = _local(_number(address, local[1]))
    else:
        raise InputError(f"--cluster {quoted(address)} is no address", REMEDY)
    require("cluster")
    with started as workers:
        yield workers


def _number(address: str, text: str | None) -> int:
    """Number of workers that ``local:text`` asks for."""
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
        # What the scheduler remembers of tasks that are done, else a hundred thousand entries.
        "distributed.admin.low-level-log-length": 1000,
        "distributed.admin.log-length": 1000,
        # A worker that died while it was starting is replaced after this.
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
            # What has to be the same, ``DaskWorkers`` checks.
            warnings.simplefilter("ignore", VersionMismatchWarning)
            client = Client(address, timeout=ANSWER_WITHIN)
    except (OSError, TimeoutError):
        found = f"no scheduler answers within {ANSWER_WITHIN:g} s"
        remedy = "start one (dask scheduler), or see that its port can be reached from here"
        raise InputError(found, remedy, address) from None
    with client:
        yield DaskWorkers(client)


# -------------------------------------------------------------------------------------------------
# The workers of a Dask cluster: tasks sent as they are needed, results taken as they come.

AHEAD = 3  # tasks under way per thread of the workers, so that none waits for the client
RECOUNT = 2.0  # after so long the workers are counted again [s]: some may have joined or left
ALONE = 60.0  # time that a run waits for a worker where none is left [s]
KEPT = 4  # things shared by tasks, such as rotors, that a worker keeps at a time

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
        self, work: Callable[[Common, Task], Result], common: Common, tasks: Iterable[Task]
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
        """Wait for the next task that is done; ``InputError`` where there is nobody to do any."""
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
                found = f"all workers left, and none came for {ALONE:g} s"
                remedy = "start some and run the command again to go on"
                raise InputError(found, remedy, str(self.client.scheduler.address))


def _run(work: Callable[[Any, Any], Any], common: bytes, task: Any) -> Any:
    """Do ``work(common, task)`` at a worker, on one core; what tasks share is kept there."""
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


def dask_setup(worker: object) -> None:
    """Let a ``worker``, which preloads this, ignore Ctrl-C: the client hears it and ends them."""
    del worker
    signal.signal(signal.SIGINT, signal.SIG_IGN)


# -------------------------------------------------------------------------------------------------
# Whether client, scheduler and workers have the same versions.

SAME = ("propmap", "numpy", "python", "distributed")  # of one version everywhere


def check_versions(client: Client) -> None:
    """Raise ``InputError`` for no workers and for versions unlike the ``client``'s."""
    found: Any = client.get_versions(packages=list(SAME))
    if not found["workers"]:
        fault = "the scheduler has no workers"
        remedy = f"start some: dask worker {client.scheduler.address}"
        raise InputError(fault, remedy, str(client.scheduler.address))
    for message in differences(found):
        raise InputError(*message)


def differences(found: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield what in ``found`` differs from the client's versions, and its remedy."""
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
                    f"{who} has {package} {theirs[package]}, the client {own[package]}",
                    "install the same version on both",
                )


def _versions(found: Any) -> dict[str, str | None]:
    if not isinstance(found, Mapping):
        return {}  # of a worker that did not answer
    # "3.12.3.final.0": what is sent depends on the first two numbers.
    python = ".".join(str(found["host"]["python"]).split(".")[:2])
    return {**found["packages"], "python": python}
