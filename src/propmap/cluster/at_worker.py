"""What runs on a worker: a task, with what tasks share kept between them."""

from __future__ import annotations

import functools
import os
import pickle
from collections.abc import Callable
from threading import Lock
from typing import Any

from propmap.errors import InputError

KEPT = 4
"""Things shared by tasks, such as rotors with their programs, that a worker keeps at a time."""

_lock = Lock()
_flags: str | None = None


def run_task(work: Callable[[Any, Any], Any], common: bytes, flags: str, task: Any) -> Any:
    """``work(common, task)``, on one core.

    Parameters
    ----------
    work : callable
        A function of a module.
    common : bytes
        Pickled: what tasks share.  It is kept, so that programs are compiled once per worker.
    flags : str
        XLA's options at the client: with others loads would differ in their last digits.
    task : object
        What differs.

    Raises
    ------
    InputError
        Where the worker has computed with other options already.
    """
    from propmap.tasks import on_cores

    with _lock:
        _set_up(flags)
        shared = _shared(common)
    with on_cores(1):
        return work(shared, task)


def _set_up(flags: str) -> None:
    """XLA's options and the place of compiled programs, before JAX first computes something."""
    global _flags
    if _flags is None:
        os.environ["XLA_FLAGS"] = flags
        _flags = flags
    if _flags != flags:
        raise InputError(
            f"a worker has computed with XLA_FLAGS={_flags!r}, the client has {flags!r}, and loads "
            "would differ in their last digits",
            "restart the workers",
        )


@functools.lru_cache(KEPT)
def _shared(common: bytes) -> Any:
    return pickle.loads(common)
