"""The C header: compiled without a warning, and the same as the Python query."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from propmap.export import export_table
from propmap.export.files import static_loads
from propmap.table import LoadTable

from .compiled import FIELDS, FLAGS, compiled_of
from .conftest import invented_content, points
from .needed import program

POINTS = 10_000

SLOPES = 4 * len(FIELDS)


@pytest.fixture(params=["model", "gap", "partial"])
def any_table(request: pytest.FixtureRequest, table: LoadTable) -> LoadTable:
    """Tables of the model; with NaN and flags; and one that ends on no plane of symmetry."""
    if request.param == "model":
        return table
    if request.param == "gap":
        return LoadTable(invented_content(gap=True))
    return LoadTable(invented_content(beta=(0.3, 2.5)))


@pytest.mark.parametrize("single", [False, True])
def test_loads_are_those_of_python(any_table: LoadTable, single: bool) -> None:
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


def test_not_a_number_and_infinity_are_outside(table: LoadTable) -> None:
    compiled = compiled_of(table)
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


def test_gradients_in_single_precision(table: LoadTable) -> None:
    compiled = compiled_of(table, single=True)
    rng = np.random.default_rng(2)
    omega, axial = rng.uniform(450.0, 750.0, 1000), rng.uniform(0.1, 3.0, 1000)
    across = rng.uniform(0.5, 3.0, 1000)
    found, _ = compiled("gradient", SLOPES, omega, across, 0.0 * across, axial)
    velocity = np.stack([across, 0.0 * across, axial], axis=-1)
    slopes = np.stack(table.gradient_at_velocity(omega, velocity), axis=1).reshape(-1, SLOPES)
    size = np.maximum(abs(slopes).max(axis=0), 1e-9)
    assert abs((found - slopes) / size).max() < 1e-3


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


def test_the_inverse_tells_of_several() -> None:
    windmill = LoadTable(invented_content())
    compiled = compiled_of(windmill)
    # In climb, 0.016 Omega^2 - 0.08 Omega V/R turns at Omega = 2.5 V/R = 225 rad/s.
    speed, beta = np.full(3, 9.0), np.zeros(3)
    value = np.asarray(windmill.loads([205.0, 300.0, 224.0], speed, beta).thrust)
    found, solutions = compiled("omega_for", 2, np.zeros(3), value, speed, beta)
    expected = windmill.omega_for("thrust", value, speed, beta)
    assert solutions.tolist() == [2, 1, 2]
    np.testing.assert_array_equal(solutions, expected.solutions)
    np.testing.assert_allclose(found[:, 0], expected.omega, rtol=1e-9)
    np.testing.assert_allclose(found[:, 1], expected.least, rtol=1e-9)
    assert found[0] == pytest.approx([245.0, 205.0], rel=1e-6)


def test_two_propellers_go_into_one_program(table: LoadTable, tmp_path: Path) -> None:
    odd = LoadTable(invented_content(name='9" */ #define x\n@data@ "ü"'))
    names = [export_table(t, "c", tmp_path / "c", replace=True)[0].name for t in (table, odd)]
    text = "".join(f'#include "{name}"\n' * 2 for name in names) + "int main(void) { return 0; }\n"
    (tmp_path / "c" / "main.c").write_text(text)
    subprocess.run([program("gcc"), *FLAGS, "main.c", "-o", "main"], cwd=tmp_path / "c", check=True)


@pytest.mark.parametrize("define", ["", "#define APC_8X6E_FLOAT\n"])
def test_the_header_is_cpp_too(table: LoadTable, tmp_path: Path, define: str) -> None:
    header, _ = export_table(table, "c", tmp_path)
    text = f'{define}#include "{header.name}"\nint main() {{ return 0; }}\n'
    (tmp_path / "main.cpp").write_text(text)
    command = [program("g++"), "-Wall", "-Wextra", "-Werror", "main.cpp", "-o", "main"]
    subprocess.run(command, cwd=tmp_path, check=True)
