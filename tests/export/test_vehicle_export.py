"""Whole vehicles in C and in RotorPy: the same as ``VehicleForces`` on the same table."""

from __future__ import annotations

import re
import runpy
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import propmap
from propmap import InputError, VehicleForces
from propmap.export import export_vehicle
from propmap.export.files import identifier, vehicle_name
from propmap.model.corrections import Installed
from propmap.table import LoadTable
from propmap.table.interpolation import STATUSES
from propmap.vehicle.vehicle import SLIPSTREAMS, Body, Mount, Vehicle, Wakes, Wing

from .compiled import addresses, shared_library
from .conftest import RADIUS, invented_content
from .counted import counts
from .needed import package

UP = (
    Mount((0.16, 0.17, 0.02), spin="cw"),
    Mount((-0.16, 0.15, 0.02), spin="ccw"),
    Mount((-0.16, -0.17, 0.02), spin="cw"),
    Mount((0.16, -0.15, 0.02), spin="ccw"),
)
ASKEW = (*UP[:3], Mount((0.16, -0.15, 0.03), (0.0, -0.28, 0.96), "ccw"))
STATIONS = np.linspace(0.1, 1.0, 8) * RADIUS
PLAIN = Vehicle(
    "Test quad",
    1.2,
    propmap.Propeller("invented", 3, STATIONS, 0.1 * STATIONS, 0.2 + 0.0 * STATIONS),
    UP,
    air=propmap.Air(1.2, 1.8e-5),
    body=Body((0.015, 0.02, 0.03)),
)
WAKES = Wakes(1.5, 0.7, 1.2, 0.8)
VEHICLES = {
    "plain": PLAIN,
    "askew, with a wing and lift": replace(
        PLAIN,
        mounts=ASKEW,
        body=Body((0.015, 0.02, 0.03), 0.01, (0.004, 0.006), 0.02),
        wing=Wing(0.05, 0.1, 4.5, 1.0, 0.25),
    ),
    "coaxial": replace(
        PLAIN,
        mounts=(UP[0], replace(UP[0], position=(0.16, 0.17, -0.06), spin="ccw"), *UP[2:]),
        wakes=WAKES,
    ),
    "askew in wakes, on a wing with a span": replace(
        PLAIN, mounts=ASKEW, wakes=WAKES, wing=Wing(0.05, 0.1, 4.5, 1.0, 0.25, 0.6)
    ),
}
VEHICLES["slipstreams"] = replace(VEHICLES["coaxial"], wakes=SLIPSTREAMS)

CALLER = """
#include "{v}.h"
void wrench(int n, const {p}_real *a, {p}_real *to)
{{
    int i, k;
    for (i = 0; i < n; ++i, a += 13, to += 20) {{
        const {v}_wrench_t w = {v}_wrench(a, a + 4, a + 7, a + 10);
        for (k = 0; k < 3; ++k) {{
            to[k] = w.force[k];
            to[3 + k] = w.moment[k];
        }}
        for (k = 0; k < 4; ++k) {{
            to[6 + k] = w.thrust[k];
            to[10 + k] = w.torque[k];
            to[14 + k] = w.added_flow[k];
        }}
        to[18] = w.power;
        to[19] = w.status;
    }}
}}
"""


def table_of(vehicle: Vehicle, *, scale: float = 1.0, **changes: Any) -> LoadTable:
    """The invented table as one of the vehicle's propeller, with loads times ``scale``."""
    content = invented_content(of=vehicle, **changes)
    return LoadTable(replace(content, coefficients=scale * content.coefficients))


@pytest.fixture(scope="module")
def table_of_plain() -> LoadTable:
    return table_of(PLAIN)


def states(count: int, seed: int = 0) -> np.ndarray:
    """Rotor speeds, velocity, turning, wind (n, 13); some beyond the table, some at rest."""
    rng = np.random.default_rng(seed)
    found = np.column_stack(
        [
            rng.uniform(250.0, 1010.0, (count, 4)),
            rng.normal(0.0, 4.0, (count, 3)),
            rng.normal(0.0, 2.0, (count, 3)),
            rng.normal(0.0, 2.0, (count, 3)),
        ]
    )
    found[::20, 4:] = 0.0
    found[1::20, 4:6] = found[1::20, 7:] = 0.0
    return found


def in_python(vehicle: Vehicle, table: LoadTable, asked: np.ndarray) -> tuple[np.ndarray, Any]:
    """What C gives (n, 19), and the statuses."""
    parts = (asked[:, :4], asked[:, 4:7], asked[:, 7:10], asked[:, 10:])
    found = VehicleForces(vehicle, table).wrench(*parts)
    vectors = (found.force, found.moment, found.thrust, found.torque, found.added_flow)
    return np.column_stack([*vectors, found.power]), found.status


@pytest.mark.parametrize("case", list(VEHICLES)[1:])
def test_c_is_the_same_as_python(tmp_path: Path, case: str) -> None:
    """In double and single precision; with one table that has gaps, and so every status."""
    vehicle, table = VEHICLES[case], table_of(PLAIN, gap=case == "coaxial")
    asked = states(1000).astype(np.float32).astype(np.float64)
    want, status = in_python(vehicle, table, asked)
    lost = np.isnan(want)
    assert 0.1 < lost[:, 0].mean() < 0.6
    assert len(set(status.tolist())) >= (5 if case == "coaxial" else 2)
    size = np.abs(np.where(lost, 0.0, want)).max(axis=0) + 1e-30
    export_vehicle(vehicle, table, "c", tmp_path)
    name, rotor = vehicle_name(vehicle, table), identifier(table)
    for kind, define in ((np.float64, "DOUBLE"), (np.float32, "FLOAT")):
        text, single = CALLER.format(v=name, p=rotor), define == "FLOAT"
        library = shared_library(tmp_path, text, define, f"-D{rotor.upper()}_{define}")
        given, found = np.ascontiguousarray(asked, kind), np.empty((len(asked), 20), kind)
        library.wrench(len(asked), *addresses(given, found))
        # The wakes' splines are in single precision in both.
        tolerance = 2e-5 if single else 1e-6 if vehicle.wakes else 1e-10
        clear = np.isnan(found[:, :19]) == lost
        assert clear.all(axis=1).mean() > 0.999 if single else clear.all()
        error = np.abs(found[:, :19].astype(np.float64) - want) / size
        assert error[clear & ~lost].max() < tolerance
        named = np.array(STATUSES)[found[:, 19].astype(int)]
        assert (named == status).mean() >= (0.999 if single else 1.0)


@pytest.mark.parametrize(("wakes", "stated"), [(None, 3000), (WAKES, 7300)])
def test_a_call_for_a_quadrotor_takes_the_stated_number_of_operations(
    table_of_plain: LoadTable, tmp_path: Path, wakes: Wakes | None, stated: int
) -> None:
    """``docs/how-to/export.md`` states the numbers; the code runs with numbers that count."""
    # Level flight, climb and slow descent, inside the table.
    rng, count = np.random.default_rng(2), 100
    velocity = rng.normal(0.0, 3.0, (count, 3)) * [1.0, 1.0, 0.4] + [0.0, 0.0, 1.0]
    turning, wind = rng.normal(0.0, 0.5, (2, count, 3))
    rows = np.column_stack([rng.uniform(500.0, 900.0, (count, 4)), velocity, turning, wind])
    found = counts(replace(PLAIN, wakes=wakes), table_of_plain, tmp_path, rows).sum(axis=1)
    assert len(found) == count
    assert float(np.median(found)) == pytest.approx(stated, rel=0.1)


@pytest.mark.parametrize("case", ["plain", "askew, with a wing and lift", "slipstreams"])
def test_rotorpy_flies_the_same(
    table_of_plain: LoadTable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, case: str
) -> None:
    package("rotorpy")
    vehicle = replace(VEHICLES[case], inertia=(0.004, 0.005, 0.008))
    paths = export_vehicle(vehicle, table_of_plain, "rotorpy", tmp_path)
    assert sorted(path.name for path in paths) == [
        "README-rotorpy.txt", "invented.npz", "test_quad_rotorpy.py"
    ]  # fmt: skip
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "test_quad_rotorpy", raising=False)
    module = package("test_quad_rotorpy")
    monkeypatch.delitem(sys.modules, "test_quad_rotorpy")
    parameters = {"tau_m": 0.02, **module.vehicle_params}
    flown, simple = module.Vehicle(parameters), module.Vehicle(parameters, aero=False)
    asked = states(60, seed=3)
    want, _ = in_python(vehicle, table_of_plain, asked)
    lost = np.isnan(want[:, 0])
    assert 3 < lost.sum() < 50
    for row, expected, gone in zip(asked, want, lost, strict=True):
        given = (row[7:10], row[:4], row[4:7] - row[10:])
        if gone:
            with pytest.raises(ValueError, match="the table has no loads"):
                flown.compute_body_wrench(*given)
            continue
        force, moment = flown.compute_body_wrench(*given)
        np.testing.assert_allclose(force, expected[:3], rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(moment, expected[3:6], rtol=1e-12, atol=1e-12)
    if case == "plain":
        # A faster rotor turns the hovering vehicle as RotorPy's own simple model has it.
        for k in range(4):
            given = (np.zeros(3), np.full(4, 600.0) + 40.0 * np.eye(4)[k], np.zeros(3))
            wrenches = flown.compute_body_wrench(*given), simple.compute_body_wrench(*given)
            for one, other in zip(*wrenches, strict=True):
                np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-9)


@pytest.mark.slow
def test_rotorpy_s_simulation_tracks_a_circle_in_wind(
    table_of_plain: LoadTable, tmp_path: Path
) -> None:
    """RotorPy's controller flies the exported vehicle, and the flight obeys Newton's law."""
    package("rotorpy")
    from rotorpy.controllers.quadrotor_control import SE3Control
    from rotorpy.environments import Environment
    from rotorpy.trajectories.circular_traj import ThreeDCircularTraj
    from rotorpy.vehicles.hummingbird_params import quad_params
    from rotorpy.wind.default_winds import SinusoidWind

    vehicle = replace(PLAIN, inertia=(0.004, 0.005, 0.008))
    export_vehicle(vehicle, table_of_plain, "rotorpy", tmp_path)
    module = runpy.run_path(str(tmp_path / "test_quad_rotorpy.py"))
    parameters = {"tau_m": 0.02, **module["vehicle_params"]}
    flown = module["Vehicle"](parameters)
    hover = np.sqrt(vehicle.mass * 9.81 / 4.0 / parameters["k_eta"])
    flown.initial_state = {name: np.zeros(3) for name in ("v", "w", "wind")} | {
        **{"x": np.array([1.5, 0.0, 0.0]), "q": np.array([0.0, 0.0, 0.0, 1.0])},
        "rotor_speeds": np.full(4, hover),
    }
    control, circle = (
        SE3Control(quad_params | parameters),
        ThreeDCircularTraj(radius=[1.5, 1.5, 0.5]),
    )
    found = Environment(flown, control, circle, SinusoidWind()).run(t_final=5.0, plot=False)
    time, state = found["time"], found["state"]
    assert found["exit"].name == "TIMEOUT" and time[-1] >= 5.0
    off = np.linalg.norm(state["x"] - found["flat"]["x"], axis=1)
    assert off[300:].max() < 0.06 and np.ptp(state["wind"], axis=0).max() > 1.5
    turn = Rotation.from_quat(state["q"])
    velocity, wind = (turn.inv().apply(state[name]) for name in ("v", "wind"))
    given = state["rotor_speeds"], velocity, state["w"], wind
    force = VehicleForces(vehicle, table_of_plain).wrench(*given).force
    acceleration = turn.apply(force) / vehicle.mass - [0.0, 0.0, 9.81]
    # The trapezoidal rule over two steps of 10 ms.
    want = np.cumsum(0.5 * np.diff(time)[:, None] * (acceleration[1:] + acceleration[:-1]), axis=0)
    np.testing.assert_allclose(state["v"][1:] - state["v"][0], want, atol=0.01)


WRONG: dict[str, tuple[Vehicle, str, str]] = {
    "another propeller": (
        replace(PLAIN, propeller=propmap.propeller("apc-8x6e")), "c", "the table is for"
    ),
    "another air": (replace(PLAIN, air=propmap.Air()), "c", "valid for 1.2 kg/m^3"),
    "a mount": (
        replace(PLAIN, mounts=(replace(UP[0], drag=Installed(1e-3)), *UP[1:])), "c", "[mount]"
    ),
    "six rotors": (
        replace(PLAIN, mounts=(*UP, Mount((0.3, 0.0, 0.0)), Mount((-0.3, 0.0, 0.0)))),
        "rotorpy", "has 6 rotors, but RotorPy needs 4",
    ),
    "one spin": (
        replace(PLAIN, mounts=tuple(replace(mount, spin="cw") for mount in UP)),
        "rotorpy", "cannot set the thrust and all three moments",
    ),
    "another target": (PLAIN, "jsbsim", "is not made from a vehicle, but from a table"),
    "no target": (PLAIN, "x-plane", "there is no target"),
    "one place": (
        replace(PLAIN, wakes=WAKES, mounts=(*UP[:3], replace(UP[0], spin="ccw"))),
        "c", "are 0 m apart"
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_exported(table_of_plain: LoadTable, tmp_path: Path, case: str) -> None:
    vehicle, target, message = WRONG[case]
    with pytest.raises(InputError, match=re.escape(message)) as caught:
        export_vehicle(vehicle, table_of_plain, target, tmp_path / "out")
    assert "\n" not in str(caught.value) and not (tmp_path / "out").exists()


TEXT = """schema = 1
name = "2 inch: test!"
frame = "flu"
mass = 1.2
propeller = "blade.csv"
[air]
density = 1.2
[wakes]
""" + "".join(
    f'[[rotors]]\nposition = {list(mount.position)}\nspin = "{mount.spin}"\n' for mount in UP
)
