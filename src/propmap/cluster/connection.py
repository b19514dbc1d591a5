"""From ``--cluster local:4`` or ``tcp://host:8786`` to workers."""

from __future__ import annotations

import logging
import os
import re
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from propmap.errors import InputError, quoted

if TYPE_CHECKING:
    from propmap.cluster.dask_workers import DaskWorkers

ANSWER_WITHIN = 5.0
"""Time that a scheduler has to answer [s]."""

START_WITHIN = 60.0
"""Time that a worker of this machine has to start [s]."""

MOST_LOCAL = 1024

FAILURES = 10
"""Workers of this machine that one task may lose before it is given up."""

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
    _need("distributed")
    with started as workers:
        yield workers


def _number(address: str, text: str | None) -> int:
    """How many workers ``local:text`` asks for."""
    if text is None:
        return os.cpu_count() or 1
    if not text.isdecimal() or not 1 <= int(text) <= MOST_LOCAL:
        raise InputError(
            f"--cluster {quoted(address)} asks for {quoted(text)} workers",
            f"give a number from 1 to {MOST_LOCAL}",
        )
    return int(text)


def _need(package: str) -> None:
    from importlib.util import find_spec

    if find_spec(package) is None:
        raise InputError(f"this needs {package}", "pip install '.[cluster]' in propmap's checkout")


@contextmanager
def _local(count: int) -> Iterator[DaskWorkers]:
    import dask
    from distributed import Client, LocalCluster

    from propmap.cluster.dask_workers import DaskWorkers

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
            preload=["propmap.cluster.uninterrupted"],
        ) as cluster,
        Client(cluster, timeout=START_WITHIN) as client,
    ):
        cluster.adapt(minimum=count, maximum=count)
        yield DaskWorkers(client)


@contextmanager
def _remote(address: str) -> Iterator[DaskWorkers]:
    from distributed import Client
    from distributed.versions import VersionMismatchWarning

    from propmap.cluster.dask_workers import DaskWorkers

    try:
        with warnings.catch_warnings():
            # What has to be the same, ``DaskWorkers`` checks.
            warnings.simplefilter("ignore", VersionMismatchWarning)
            client = Client(address, timeout=ANSWER_WITHIN)
    except (OSError, TimeoutError):
        raise InputError(
            f"no scheduler answers within {ANSWER_WITHIN:g} s",
            "start one (dask scheduler), or see that its port can be reached from here",
            address,
        ) from None
    with client:
        yield DaskWorkers(client)
