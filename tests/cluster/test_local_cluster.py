"""A cluster of this machine: the same loads to the last digit, whoever is killed on the way."""

from __future__ import annotations

import operator
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from propmap.cluster import AHEAD, DaskWorkers, connected
from propmap.errors import InputError
from propmap.sweep.run import Store
from propmap.tasks import in_order
from tests.sweep.conftest import whole  # noqa: F401
from tests.sweep.small_sweep import contents, finished, sweep, swept

pytestmark = pytest.mark.slow

TIMES = 3


@pytest.fixture(scope="module")
def workers() -> Iterator[DaskWorkers]:
    with connected("local:2") as found:
        yield found


def _process(_: None, task: int) -> int:
    del task
    return os.getpid()


def _slow(_: None, task: int) -> int:
    time.sleep(0.05)
    return task


def _refused(_: None, task: int) -> int:
    raise InputError(f"task {task}", "another")


def _exits(_: None, task: int) -> int:
    os._exit(task)


def test_results_are_those_of_this_process(
    workers: DaskWorkers,
    tmp_path: Path,
    whole: dict[str, bytes],  # noqa: F811
) -> None:
    told: list[tuple[int, int]] = []
    found = swept(tmp_path / "map.zarr", workers=workers, progress=lambda *one: told.append(one))
    assert found == whole
    assert told == [(k, 20) for k in range(21)]


def test_a_store_that_workers_do_not_see_is_written_by_the_client(
    workers: DaskWorkers,
    tmp_path: Path,
    whole: dict[str, bytes],  # noqa: F811
) -> None:
    layout = sweep().layout()
    store = Store.create(tmp_path / "map.zarr", layout)

    class Elsewhere(Store):
        @property
        def here(self) -> bool:
            return os.getpid() == client

    client = os.getpid()
    sweep().run(Elsewhere(store.path, store.run), layout, workers)
    assert contents(store.path) == whole


def test_all_workers_work_and_few_tasks_are_under_way(workers: DaskWorkers) -> None:
    assert workers.count == 2
    assert len({pid for _, pid in workers.results(_process, None, range(40))}) == 2
    taken = 0

    def tasks() -> Iterator[int]:
        nonlocal taken
        for k in range(60):
            taken += 1
            yield k

    for count, _ in enumerate(workers.results(_slow, None, tasks())):
        assert taken <= count + AHEAD * 2 + 1
    assert in_order(workers.results(operator.sub, 1, range(9))) == list(range(1, -8, -1))


def test_what_a_task_refuses_is_told_as_here(workers: DaskWorkers) -> None:
    with pytest.raises(InputError, match=r"^task 3; another$"):
        list(workers.results(_refused, None, [3]))


def test_killed_workers_lose_nothing(tmp_path: Path, whole: dict[str, bytes]) -> None:  # noqa: F811
    rng, killed = np.random.default_rng(2), 0
    with connected("local:2") as workers:
        stop, progressed = threading.Event(), threading.Event()

        def kill() -> None:
            nonlocal killed
            while not stop.wait(float(rng.uniform(0.0, 0.3))):
                progressed.wait()
                progressed.clear()
                nannies = list(workers.client.cluster.workers.values())
                alive = [nanny.pid for nanny in nannies if nanny.pid is not None]
                if alive:  # or all are just being replaced
                    os.kill(alive[rng.integers(len(alive))], signal.SIGKILL)
                    killed += 1

        killer = threading.Thread(target=kill)
        killer.start()
        try:
            for run in range(20):
                path = tmp_path / f"{run}.zarr"
                found = swept(path, workers=workers, progress=lambda *_: progressed.set()).items()
                # Killed while it writes, one leaves a temporary file, which no reader sees.
                assert {k: v for k, v in found if not k.endswith(".partial")} == whole
                if killed >= TIMES:
                    break
        finally:
            stop.set()
            progressed.set()
            killer.join()
    assert killed >= TIMES


@pytest.mark.parametrize("cluster", [[], ["local:2"]])
def test_a_killed_client_goes_on(
    tmp_path: Path,
    whole: dict[str, bytes],  # noqa: F811
    cluster: list[str],
) -> None:
    path, rng = tmp_path / "map.zarr", np.random.default_rng(3)
    store, layout = Store.create(path, sweep().layout()), sweep().layout()
    command = [sys.executable, "-m", "tests.sweep.small_sweep", str(path), *cluster]
    done: dict[str, int] = {}
    for _ in range(TIMES):
        before = store.done(layout).sum()
        process = subprocess.Popen(command, start_new_session=True)
        while process.poll() is None and store.done(layout).sum() <= before:
            time.sleep(0.01)
        time.sleep(float(rng.uniform(0.0, 0.15)))
        process.kill()
        process.wait()
        done = finished(path) | done
    assert 0 < len(done) - 1 < 20  # killed on the way, not before and not at the end
    assert swept(path) == whole
    assert done.items() <= finished(path).items()


def test_a_task_that_kills_workers_is_given_up_in_one_line() -> None:
    with (
        connected("local:1") as workers,
        pytest.raises(InputError, match="workers that died") as told,
    ):
        list(workers.results(_exits, None, [1]))
    assert "run the command again" in str(told.value)


def test_an_interruption_is_one_line(tmp_path: Path) -> None:
    grid = ["--rpm", "3000:8000:20", "--speed", "0:20:100", "--beta", "0:180:200"]
    asked = ["apc-8x6e", "--airfoil", "paper-apc", *grid, "-o", str(tmp_path / "map.zarr")]
    process = subprocess.Popen(
        [sys.executable, "-m", "propmap", "sweep", *asked, "--cluster", "local:2"],
        start_new_session=True,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    assert "dashboard at http" in process.stderr.readline()
    # It says so when the workers are there and the work, of many seconds, begins.
    assert "400000 operating points in" in process.stderr.readline()
    time.sleep(0.5)
    # As a terminal does: to the client and its workers.
    os.killpg(process.pid, signal.SIGINT)
    _, told = process.communicate(timeout=60.0)
    assert (process.returncode, told.splitlines()) == (130, ["propmap: interrupted"])
