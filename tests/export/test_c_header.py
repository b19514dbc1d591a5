"""The C header: compiled without a warning, and the same as the Python query."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.export import export_table
from propmap.export.files import static_loads
from propmap.table import LoadTable

from .compiled import FIELDS, addresses, compiled_of, printed, shared_library
from .conftest import (
    OMEGA,
    SPINS,
    VELOCITIES,
    Both,
    hub_wrench,
    invented_content,
    points,
    share,
)
from .needed import program

EXAMPLE = Path(__file__).parents[2] / "examples" / "c" / "inflow.c"

POINTS = 10_000

SLOPES = 4 * len(FIELDS)

InC = Callable[[np.ndarray], np.ndarray]


@pytest.fixture(scope="module")
def ragged() -> LoadTable:
    """A table with NaN and flags that ends on no plane of symmetry."""
    return LoadTable(invented_content(beta=(0.3, 2.5), gap=True))


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("name", ["table", "ragged"])
def test_loads_are_those_of_python(request: pytest.FixtureRequest, name: str, single: bool) -> None:
    any_table: LoadTable = request.getfixturevalue(name)
    compiled = compiled_of(any_table, single=single)
    omega, speed, beta = points(any_table, POINTS)
    expected = any_table.loads(omega, speed, beta)
    found, status = compiled("loads", len(FIELDS), omega, speed, beta)
    loads = np.stack(expected[: len(FIELDS)], axis=-1)
    lost = np.isnan(loads).any(axis=1)
    assert lost.any() and not lost.all()
    low, high = any_table.envelope["omega"]
    static = static_loads(any_table, np.clip(omega, low, high))
    static = np.column_stack([*static.values(), static["torque"] * omega])[~lost]
    # The same sums in another order; 6e-8 and a few amplifying steps in single precision.
    tolerance = 1e-5 if single else 1e-12
    np.testing.assert_array_equal(np.isnan(found).any(axis=1), lost)
    assert abs((found[~lost] - loads[~lost]) / static).max() < tolerance
    # Beside a border between cells, single precision may be on its other side.
    assert (status != expected.code).sum() <= (POINTS // 1000 if single else 0)
    assert set(np.unique(expected.code)) == set(np.unique(status))
    bad = np.array([np.nan, np.inf, -np.inf])
    for k in range(3):
        point = [np.full(3, 500.0), np.full(3, 2.0), np.full(3, 1.0)]
        point[k] = bad
        found, status = compiled("loads", len(FIELDS), *point)
        assert np.isnan(found).all() and (status == 5).all()


def test_velocities_and_gradients_are_those_of_python(table: LoadTable) -> None:
    compiled = compiled_of(table)
    omega, speed, beta = points(table, POINTS)
    turn = 3.0 * omega
    velocity = np.stack(
        [
            speed * np.sin(beta) * np.cos(turn),
            speed * np.sin(beta) * np.sin(turn),
            speed * np.cos(beta),
        ],
        axis=-1,
    )
    velocity[::10] = 0.0
    velocity[1::10, :2] = 0.0
    loads, status = compiled("loads_at_velocity", len(FIELDS), omega, *velocity.T)
    expected = table.loads_at_velocity(omega, velocity)
    np.testing.assert_allclose(
        loads, np.stack(expected[: len(FIELDS)], axis=-1), rtol=1e-9, atol=1e-12
    )
    np.testing.assert_array_equal(status, expected.code)
    found, status = compiled("gradient", SLOPES, omega, *velocity.T)
    slopes = np.stack(table.gradient_at_velocity(omega, velocity), axis=1).reshape(-1, SLOPES)
    size = np.maximum(np.nanmax(abs(slopes), axis=0), 1e-12)  # some loads are always zero
    # Near rest the derivative with beta is divided by the advance ratio, down to 1e-7.
    np.testing.assert_allclose(found / size, slopes / size, rtol=0.0, atol=1e-8)
    np.testing.assert_array_equal(status, expected.code)


@pytest.mark.parametrize("quantity", ["thrust", "torque", "power"])
def test_the_inverse_is_that_of_python(table: LoadTable, quantity: str) -> None:
    compiled = compiled_of(table)
    rng = np.random.default_rng(1)
    count = 60
    # Away from the envelope's ends, where a root is found or not by the last bit.
    omega = rng.uniform(410.0, 790.0, count)
    speed, beta = rng.uniform(0.5, 6.0, count), rng.uniform(0.1, 1.5, count)
    value = getattr(table.loads(omega, speed, beta), quantity)
    value[::5] *= 4.0
    number = ("thrust", "torque", "power").index(quantity)
    found, solutions = compiled("omega_for", 2, np.full(count, number), value, speed, beta)
    expected = table.omega_for(quantity, value, speed, beta)
    np.testing.assert_array_equal(solutions, expected.solutions)
    assert {0, 1} <= set(solutions.tolist())
    np.testing.assert_allclose(found[:, 0], expected.omega, rtol=1e-9)
    np.testing.assert_allclose(found[:, 1], expected.least, rtol=1e-9)


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("end", [0, 1])
def test_the_inverse_answers_the_ends_of_the_envelope(
    table: LoadTable, end: int, single: bool
) -> None:
    compiled = compiled_of(table, single=single)
    rng = np.random.default_rng(3)
    count, omega = 100, table.envelope["omega"][end]
    speed, beta = rng.uniform(0.0, 6.0, count), rng.uniform(0.0, 1.5, count)
    expected = table.loads(omega, speed, beta)
    beyond = 1.0 + (1e-4 if single else 1e-9) * (1.0 if end else -1.0)
    for number, name in enumerate(("thrust", "torque", "power")):
        value = getattr(expected, name)
        found, solutions = compiled("omega_for", 2, np.full(count, number), value, speed, beta)
        assert (solutions >= 1).all()
        edge = found[:, 0 if end else 1]
        np.testing.assert_allclose(edge, omega, rtol=2e-5 if single else 1e-11)
    still = table.loads(omega, 0.0, 0.0).thrust * beyond
    _, solutions = compiled("omega_for", 2, *np.array([[0.0], [still], [0.0], [0.0]]))
    assert solutions.tolist() == [0]


def test_the_inverse_tells_of_several(ragged: LoadTable) -> None:
    compiled = compiled_of(ragged)
    # 0.016 Omega^2 - 0.08 Omega V_z/R turns at Omega = 2.5 V_z/R = 225 rad/s.
    beta = np.full(3, 0.3)
    speed = 9.0 / np.cos(beta)
    value = np.asarray(ragged.loads([205.0, 300.0, 224.0], speed, beta).thrust)
    found, solutions = compiled("omega_for", 2, np.zeros(3), value, speed, beta)
    expected = ragged.omega_for("thrust", value, speed, beta)
    assert solutions.tolist() == [2, 1, 2]
    np.testing.assert_array_equal(solutions, expected.solutions)
    np.testing.assert_allclose(found[:, 0], expected.omega, rtol=1e-9)
    np.testing.assert_allclose(found[:, 1], expected.least, rtol=1e-9)
    assert found[0] == pytest.approx([245.0, 205.0], rel=1e-6)


def test_two_propellers_go_into_one_program_in_c_and_in_cpp(
    table: LoadTable, tmp_path: Path
) -> None:
    odd = LoadTable(invented_content(name='9" */ #define x\n@data@ "ü"'))
    names = [export_table(t, "c", tmp_path, replace=True)[0].name for t in (table, odd)]
    text = "".join(f'#include "{name}"\n' * 2 for name in names) + "int main(void) { return 0; }\n"
    printed(tmp_path, text)
    (tmp_path / "main.cpp").write_text("#define APC_8X6E_FLOAT\n" + text)
    command = [program("g++"), "-Wall", "-Wextra", "-Werror", "main.cpp", "-o", "main"]
    subprocess.run(command, cwd=tmp_path, check=True)


# --- The wrench on the hub, and its inflow -------------------------------------------------------

WRENCHES = """
#include "{name}.h"
void wrench(int n, const double *a, double *to)
{{
    int i, k;
    for (i = 0; i < n; ++i, a += 6, to += 15) {{
        const {name}_wrench_t w = {name}_wrench(a[0], a[1], a[2], a[3], (int)a[4]);
        const {name}_wrench_t v = {name}_wrench_in_inflow(a[5], a[0], a[1], a[2], a[3], (int)a[4]);
        const {name}_inflow_t steady = {name}_inflow(a[0], a[1], a[2], a[3]);
        for (k = 0; k < 3; ++k) {{
            to[k] = w.force[k];
            to[3 + k] = w.moment[k];
            to[6 + k] = v.force[k];
            to[9 + k] = v.moment[k];
        }}
        to[12] = steady.steady;
        to[13] = steady.time_constant;
        to[14] = {name}_inflow_step(a[5], 1e-3, a[0], a[1], a[2], a[3]);
    }}
}}
"""


@pytest.fixture(scope="module")
def in_c(oblique: Both, tmp_path_factory: pytest.TempPathFactory) -> InC:
    """What the header gives at omega, velocity, spin and inflow (n, 6): (n, 15)."""
    folder = tmp_path_factory.mktemp("c")
    (header, _) = export_table(oblique[1], "c", folder)
    library = shared_library(folder, WRENCHES.format(name=header.stem))

    def call(asked: np.ndarray) -> np.ndarray:
        given, found = np.ascontiguousarray(asked), np.empty((len(asked), 15))
        library.wrench(len(asked), *addresses(given, found))
        return found

    return call


@pytest.mark.parametrize("spin", SPINS)
def test_the_wrench_of_the_hub(oblique: Both, in_c: InC, spin: str) -> None:
    rotor, _ = oblique
    rows = [[OMEGA, *velocity, SPINS[spin], 0.0] for velocity in VELOCITIES]
    found = in_c(np.array(rows))[:, :6]
    assert share(found, hub_wrench(rotor, spin)).max() < 0.003  # the table's tolerance


def test_the_inflow_in_c_follows_that_of_the_model(oblique: Both, in_c: InC) -> None:
    """In a table each annulus has settled, with its stall, so that thrust seems to depend less on
    the inflow: the change of thrust is up to 40 % too small."""
    rotor, _ = oblique
    dynamic = propmap.DynamicInflow(rotor)
    velocity = np.vstack([VELOCITIES, [[0.0, 0.0, 0.0], [0.0, 0.0, 5.0]]])
    steady = dynamic.steady(OMEGA, velocity)
    mean = dynamic.loads(steady, OMEGA, velocity).mean_inflow
    rows = np.column_stack([0.0 * mean + OMEGA, velocity, 1.0 + 0.0 * mean])
    first = in_c(np.column_stack([rows, mean]))
    np.testing.assert_allclose(first[:, 12], mean, rtol=0.06)
    # The steady inflow changes nothing.
    own = in_c(np.column_stack([rows, first[:, 12]]))
    np.testing.assert_allclose(own[:, 6:12], own[:, :6], rtol=1e-9, atol=1e-12)
    for missing in (1.0, -1.5):
        found = in_c(np.column_stack([rows, first[:, 12] - missing]))
        there = steady.copy()
        there[:, 3:] -= missing
        later = dynamic.loads(dynamic.step(there, 1e-3, OMEGA, velocity), OMEGA, velocity)
        want = later.mean_inflow - mean
        np.testing.assert_allclose(found[:, 14] - first[:, 12], want, atol=0.04 * abs(missing))
        thrust = dynamic.loads(there, OMEGA, velocity).thrust
        change = thrust - rotor.loads_at_velocity(OMEGA, velocity).thrust
        assert (np.sign(change) == np.sign(missing)).all()
        ratio = (found[:, 8] - found[:, 2]) / change
        assert (ratio > 0.6).all() and (ratio < 1.05).all()


def test_the_inflow_in_c_decays_for_any_step(in_c: InC) -> None:
    """By its closed form: the deviation falls, from any state, and never changes its sign."""
    random = np.random.default_rng(3)
    velocity = np.abs(random.uniform(-3.0, 3.0, (200, 3)))
    rows = np.column_stack([random.uniform(450.0, 750.0, 200), velocity, np.ones(200)])
    state = random.uniform(-10.0, 20.0, 200)
    found = in_c(np.column_stack([rows, state]))
    before, after = state - found[:, 12], found[:, 14] - found[:, 12]
    assert (before * after > 0.0).all() and (abs(after) < abs(before)).all()
    # Near the steady state, the exponential of the time constant.
    near = in_c(np.column_stack([rows, found[:, 12] + 1e-4]))
    want = 1e-4 * np.exp(-1e-3 / found[:, 13])
    np.testing.assert_allclose(near[:, 14] - near[:, 12], want, rtol=1e-3)


def test_the_example_of_the_inflow_in_c(oblique: Both, tmp_path: Path) -> None:
    _, table = oblique
    export_table(table, "c", tmp_path)
    text = printed(tmp_path, EXAMPLE.read_text())
    time_constant = float(re.findall(r"time constant (\S+) ms", text)[0])
    inflow, thrust = np.array(re.findall(r"inflow (\S+) m/s, thrust (\S+) N", text), float).T
    # The last line is the steady one, which the others near from one side.
    assert (np.diff(inflow[:-1]) > 0.0).all() and (np.diff(thrust[:-1]) < 0.0).all()
    assert thrust[0] > 1.05 * thrust[-1]
    left = (inflow[-1] - inflow[:-1]) / (inflow[-1] - inflow[0])
    assert left[10] == pytest.approx(np.exp(-10.0 / time_constant), abs=0.02)
