"""Preloaded by the workers of this machine: Ctrl-C is for the client, which ends them."""

from __future__ import annotations

import signal


def dask_setup(worker: object) -> None:
    """Let a ``worker`` ignore the interruption that a terminal sends to all processes."""
    del worker
    signal.signal(signal.SIGINT, signal.SIG_IGN)
