"""Streamed sweeps: the loads of the rotor, tasks of one size, stores that go on or refuse to."""

from __future__ import annotations

import errno
import gc
import operator
import signal
import subprocess
import sys
import time
import tracemalloc
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import propmap
from propmap.cli.sweep import check_store
from propmap.errors import InputError
from propmap.rotor import Rotor
from propmap.sweep.points import PointList, chunk_shape, parts_along
from propmap.sweep.run import Layout, Store, Sweep, stream, sweep_to_store
from propmap.tasks import InProcesses, InThreads, InTurn, in_order

from .small_sweep import GRID, contents, finished, rotor, sweep, swept


def test_the_store_holds_the_rotors_loads(tmp_path: Path) -> None:
    path = tmp_path / "map.zarr"
    swept(path)
    w, v, b = np.meshgrid(GRID.rpm, GRID.speed_mps, GRID.beta_deg, indexing="ij")
    loads = rotor().loads(w * np.pi / 30.0, v, np.radians(b))
    with xarray.open_zarr(path) as found:
        assert dict(found.sizes) == {"rpm": 4, "speed": 5, "beta": 6}
        np.testing.assert_array_equal(found["beta_deg"], GRID.beta_deg)
        assert found["thrust"].attrs["units"] == "N"
        for name in ("thrust", "drag", "torque", "power", "mean_inflow", "roots"):
            expected = getattr(loads, name)  # rounded otherwise in another batch
            np.testing.assert_allclose(found[name].values, expected, rtol=1e-12, atol=1e-12)
        words = np.array(found["status"].attrs["flag_meanings"].split())
        assert (words[found["status"].values] == loads.status).all()
        assert found.attrs["model_sha256"] == rotor().model.fingerprint()


def test_deviations_are_filed_with_their_units(tmp_path: Path) -> None:
    known = Rotor(propmap.catalogue_model("apc 10x5e"))
    points = PointList(np.array([5000.0, 6000.0]), np.array([5.0, 0.0]), np.array([60.0, 0.0]))
    path = tmp_path / "map.zarr"
    sweep_to_store(known, points, path, by_source=True)
    expected = known.loads(points.rpm * np.pi / 30.0, points.speed_mps, np.radians(points.beta_deg))
    with xarray.open_zarr(path) as found:
        assert dict(found.sizes) == {"point": 2}
        np.testing.assert_array_equal(found["thrust_std"].values, expected.std.thrust)
        tunnel = expected.std_by_source["tunnel"].power
        np.testing.assert_array_equal(found["power_std_tunnel"].values, tunnel)
        assert found["power_std_tunnel"].attrs["units"] == "W"


@pytest.mark.parametrize(
    ("shape", "most"), [((4, 5, 6), 6), ((3, 7, 16385), 16384), ((2, 3, 4), 1000)]
)
def test_parts_cover_all_points_once_and_are_alike(shape: tuple[int, ...], most: int) -> None:
    chunk = chunk_shape(shape, most)
    assert np.prod(chunk) <= most
    count = np.zeros(shape, int)
    for place in np.ndindex(*parts_along(shape, chunk)):
        count[tuple(slice(k * n, (k + 1) * n) for k, n in zip(place, chunk, strict=True))] += 1
    assert (count == 1).all()
    assert np.prod(parts_along(shape, chunk)) <= 3 * np.prod(shape) / most + 1


def test_another_run_does_not_go_on(tmp_path: Path) -> None:
    path, first, layout = tmp_path / "map.zarr", sweep(), sweep().layout()
    Store.create(path, layout)
    before = contents(path)
    model, moved = first.rotor.model, replace(GRID, rpm=GRID.rpm + 1.0)
    others = {
        "another model": replace(first, rotor=Rotor(replace(model, air=propmap.Air(1.0)))),
        "another accuracy": replace(first, rotor=Rotor(model, accuracy="fine")),
        "set of operating": replace(first, points=moved),
        "size of tasks": replace(first, points_per_task=12),
    }
    for told, other in others.items():
        with pytest.raises(InputError) as refused:
            Store.resume(path, other.layout())
        assert told in str(refused.value) and "\n" not in str(refused.value)
        assert contents(path) == before
    old = replace(layout, depends_on={**layout.depends_on, "propmap": "0.0.1"})
    Store.create(tmp_path / "old.zarr", old)
    with pytest.raises(InputError, match=r"version of propmap \(0\.0\.1\)"):
        Store.resume(tmp_path / "old.zarr", layout)
    # Deviations of another fit are another model.
    known = propmap.catalogue_model("apc 10x5e")
    law: Any = known.airfoil
    wider = replace(law, uncertainty=replace(law.uncertainty, thrust_coefficient=0.1))
    one, other = (Rotor(replace(known, airfoil=airfoil)) for airfoil in (law, wider))
    told = [Sweep(rotor, GRID).layout().depends_on["model"] for rotor in (one, other)]
    assert told[0] != told[1]


def test_a_full_disk_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whole: dict[str, bytes]
) -> None:
    import zarr.storage._local as local

    rng = np.random.default_rng(1)
    path, write = tmp_path / "map.zarr", Path.open
    Store.create(path, sweep().layout())
    for _ in range(3):
        room = int(rng.integers(1, 40))

        def full(self: Path, *mode: Any, **more: Any) -> Any:
            nonlocal room
            file = write(self, *mode, **more)
            if self.suffix == ".partial":
                room -= 1
                if room < 0:
                    file.write(b"half")
                    file.close()
                    raise OSError(errno.ENOSPC, "No space left on device", str(self))
            return file

        with monkeypatch.context() as patch:
            patch.setattr(local.Path, "open", full)
            with pytest.raises(OSError, match=r"No space left.*map\.zarr'$"):
                swept(path)
    before = finished(path)
    assert swept(path) == whole
    assert before.items() <= finished(path).items()


def test_a_second_run_on_a_store_is_refused(tmp_path: Path, whole: dict[str, bytes]) -> None:
    pytest.importorskip("fcntl")
    path = tmp_path / "map.zarr"
    with Store.create(path, sweep().layout()).alone():
        writing = path / "thrust" / "c.partial"
        writing.touch()
        for second in (lambda: swept(path), lambda: check_store(path, force=True)):
            with pytest.raises(InputError, match="another run is writing to this store"):
                second()
        assert writing.exists()
    assert swept(path) == whole and not writing.exists()


@pytest.mark.slow
def test_ten_kills_at_random_moments_lose_nothing(tmp_path: Path, whole: dict[str, bytes]) -> None:
    rng, path, killed = np.random.default_rng(3), tmp_path / "map.zarr", []
    command = [sys.executable, "-m", "tests.sweep.small_sweep", str(path)]
    for _ in range(10):
        process = subprocess.Popen(command)
        before, more = len(finished(path)), rng.integers(3)
        while process.poll() is None and len(finished(path)) < before + more:
            time.sleep(1e-3)
        time.sleep(rng.uniform(0.0, 0.02 if path.exists() else 2.0))
        process.kill()
        killed.append(process.wait() == -signal.SIGKILL)
    assert sum(killed) >= 5 and len(finished(path)) > 0
    assert swept(path) == whole


class Ones:
    def part(self, place: tuple[int, ...], _: tuple[int, ...]) -> int:
        return place[0]

    def values(self, part: int) -> dict[str, Any]:
        return {"value": np.full(20_000, part + 1.0), "status": np.zeros(20_000, np.uint8)}


def test_memory_does_not_grow_with_the_sweep(tmp_path: Path) -> None:
    import zarr  # noqa: F401 - not to be counted

    kinds: Any = {"value": (np.dtype(float), {}), "status": (np.dtype(np.uint8), {})}
    peaks = []
    for tasks in (5, 30):
        layout = Layout({"point": 20_000 * tasks}, (20_000,), {}, kinds)
        store = Store.create(tmp_path / f"{tasks}.zarr", layout)
        ones: Any = Ones()
        gc.collect()
        gc.freeze()  # what other tests have left is no matter of the sweep, and slow to go through
        tracemalloc.start()
        for _ in stream(InTurn(), ones, store, layout):
            gc.collect()  # when it runs by itself is no matter of the sweep
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        gc.unfreeze()
    assert peaks[1] < 1.2 * peaks[0]  # of results alone there are six times as many


def test_workers_give_each_result_once_with_its_place() -> None:
    with InProcesses(2) as processes:
        for workers in (InTurn(), InThreads(3), processes):
            # A function that the processes import without this module.
            assert in_order(workers.results(operator.sub, 1, range(9))) == list(range(1, -8, -1))
