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
from propmap.sweep.run import sweep_to_store
from tests.sweep.conftest import whole  # noqa: F401
from tests.sweep.small_sweep import GRID, POINTS_PER_TASK, contents, rotor

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


@pytest.fixture
def address() -> str:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return f"tcp://127.0.0.1:{free.getsockname()[1]}"


def scheduler(address: str) -> contextlib.AbstractContextManager[subprocess.Popen[bytes]]:
    host, port = address.removeprefix("tcp://").split(":")
    return dask("scheduler", "--host", host, "--port", port, "--no-dashboard", "--no-show")


def wait_for(address: str) -> None:
    host, port = address.removeprefix("tcp://").split(":")
    for _ in range(600):
        with contextlib.suppress(OSError), socket.create_connection((host, int(port)), 0.2):
            return
        time.sleep(0.1)


def worker(address: str) -> contextlib.AbstractContextManager[subprocess.Popen[bytes]]:
    return dask("worker", address, "--nworkers", "1", "--nthreads", "2", "--no-dashboard")


def test_a_scheduler_of_its_own(
    address: str,
    tmp_path: Path,
    whole: dict[str, bytes],  # noqa: F811
) -> None:
    with scheduler(address) as running:
        wait_for(address)
        with pytest.raises(InputError, match="no workers; start workers"), connected(address):
            pass
        with worker(address):
            workers = contextlib.ExitStack()
            for _ in range(60):
                with contextlib.suppress(InputError):
                    found = workers.enter_context(connected(address))
                    break
                time.sleep(0.5)
            with workers:
                assert found.count == 2
                path = tmp_path / "map.zarr"
                sweep_to_store(rotor(), GRID, path, workers=found, points_per_task=POINTS_PER_TASK)
                assert contents(path) == whole
                # The scheduler is killed on the way.
                path = tmp_path / "other.zarr"
                with pytest.raises(InputError) as told:
                    sweep_to_store(
                        rotor(),
                        GRID,
                        path,
                        workers=found,
                        points_per_task=POINTS_PER_TASK,
                        progress=lambda done, _: running.kill() if done == 3 else None,
                    )
                assert "run the command again to resume" in str(told.value)
    sweep_to_store(rotor(), GRID, path, points_per_task=POINTS_PER_TASK)
    assert contents(path) == whole
