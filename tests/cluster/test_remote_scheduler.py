"""Workers of a scheduler that runs by itself, as on other machines."""

from __future__ import annotations

import contextlib
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from propmap.cluster import connected
from propmap.errors import InputError
from tests.sweep.conftest import whole  # noqa: F401
from tests.sweep.small_sweep import swept

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]


@contextlib.contextmanager
def dask(*arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    """A process of Dask's own command, stopped in the end."""
    process = subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


@contextlib.contextmanager
def scheduler() -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """A scheduler that listens, and its address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    quiet = ("--no-dashboard", "--no-show")
    with dask("scheduler", "--host", "127.0.0.1", "--port", str(port), *quiet) as running:
        for _ in range(600):
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 0.2):
                break
            time.sleep(0.1)
        yield running, f"tcp://127.0.0.1:{port}"


def test_a_scheduler_of_its_own(tmp_path: Path, whole: dict[str, bytes]) -> None:  # noqa: F811
    with scheduler() as (running, address):
        with pytest.raises(InputError, match="no workers; start workers"), connected(address):
            pass
        with dask("worker", address, "--nworkers", "1", "--nthreads", "2", "--no-dashboard"):
            workers = contextlib.ExitStack()
            for _ in range(60):
                with contextlib.suppress(InputError):
                    found = workers.enter_context(connected(address))
                    break
                time.sleep(0.5)
            with workers:
                assert found.count == 2
                assert swept(tmp_path / "map.zarr", workers=found) == whole
                # The scheduler is killed on the way.
                path = tmp_path / "other.zarr"
                with pytest.raises(InputError, match="run the command again to resume"):
                    swept(
                        path,
                        workers=found,
                        progress=lambda done, _: running.kill() if done == 3 else None,
                    )
    assert swept(path) == whole
