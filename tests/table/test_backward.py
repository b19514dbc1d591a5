"""Tables of propellers that turn backward: the loads of the rotor, and mirrored queries."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.export import export_table
from propmap.loads import LOADS, error_scales
from propmap.table import JaxTable, LoadTable, build_table
from propmap.table.interpolation import TableContent

from .conftest import flagged_content, random_points

FIELDS = (*LOADS, "power")


def backward_of(content: TableContent) -> TableContent:
    """The table with the same coefficients for the opposite omegas."""
    spread = 0.1 * np.nan_to_num(np.abs(content.coefficients))
    omega, coefficients = -content.omega[::-1], content.coefficients[::-1]
    return replace(content, omega=omega, coefficients=coefficients, deviations=spread[::-1])


FLAGGED = flagged_content()
AHEAD = LoadTable(
    replace(FLAGGED, deviations=0.1 * np.nan_to_num(np.abs(FLAGGED.coefficients))),
)
BACK = LoadTable(backward_of(FLAGGED))
POINTS = random_points(AHEAD, 300, seed=21)


def test_the_same_coefficients_give_the_same_loads_at_the_opposite_omega() -> None:
    omega, speed, beta = POINTS
    ahead, back = AHEAD.loads(*POINTS), BACK.loads(-omega, speed, beta)
    rise, fall = AHEAD.gradient(*POINTS), BACK.gradient(-omega, speed, beta)
    for name in FIELDS:
        sign = -1.0 if name == "power" else 1.0
        np.testing.assert_allclose(getattr(back, name), sign * getattr(ahead, name), 1e-11, 1e-14)
        expected = sign * getattr(rise, name) * [-1.0, 1.0, 1.0]
        np.testing.assert_allclose(getattr(fall, name), expected, 1e-8, 1e-12)
        std = getattr(AHEAD.std(*POINTS), name)
        np.testing.assert_allclose(getattr(BACK.std(-omega, speed, beta), name), std, 1e-11)
    assert (np.where(ahead.status == "ok", "reversed", ahead.status) == back.status).all()
    assert (BACK.loads(*POINTS).status == "outside").all()
    wanted = float(BACK.loads(-600.0, 4.0, 2.9).thrust)
    assert BACK.omega_for("thrust", wanted, 4.0, 2.9).omega == pytest.approx(-600.0, rel=1e-9)


def test_jax_has_the_same_loads_and_derivatives() -> None:
    omega, speed, beta = POINTS
    omega = -omega

    def query(table: JaxTable, *points: jax.Array) -> tuple[Any, ...]:
        loads = table.loads(*points)
        by_omega = jax.grad(lambda w: table.loads(w, *points[1:]).power.sum())(points[0])
        return loads, table.code(*points, loads.thrust), by_omega

    with jax.enable_x64(True):
        answer = jax.jit(query, compiler_options={"xla_backend_optimization_level": 0})
        found, code, slope = answer(JaxTable.from_table(BACK), omega, speed, beta)
    expected = BACK.loads(omega, speed, beta)
    np.testing.assert_array_equal(code, expected.code)
    for name in FIELDS:
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), 1e-9, 1e-12)
    np.testing.assert_allclose(slope, BACK.gradient(omega, speed, beta).power[:, 0], 1e-8, 1e-10)


def test_a_certified_table_has_the_loads_of_the_rotor_that_turns_backward(
    rotor: propmap.Rotor, tmp_path: Path
) -> None:
    ends = {"omega": (-800.0, -400.0), "speed": (0.0, 6.0), "beta": (0.0, np.pi)}
    built = build_table(rotor, **ends, tolerance=0.05, certificate_points=512)
    built.save(tmp_path / "back.npz")
    table = LoadTable.load(tmp_path / "back.npz")
    omega, speed, beta = random_points(table, 400, seed=3)
    found, expected = table.loads(omega, speed, beta), rotor.loads(omega, speed, beta)
    still = rotor.loads(omega, 0.0, 0.0)
    size = error_scales({name: np.abs(getattr(still, name)) for name in LOADS}, 0.1016)
    sound = found.status != "unresolved"
    assert sound.mean() > 0.9 and (found.status == "reversed").mean() > 0.5
    for name in LOADS:
        error = (getattr(found, name) - getattr(expected, name)) / size[name]
        assert np.abs(error[sound]).max() < 0.05, name
    assert (found.thrust[speed < 3.0] < 0.0).all() and (found.power[speed < 3.0] > 0.0).all()
    export_table(table, "csv", tmp_path)
    with pytest.raises(InputError, match=r"turns backward, .*; choose one of npz, nc, csv"):
        export_table(table, "gazebo", tmp_path)
    with pytest.raises(InputError, match=r"-400 to 800 .*one table for each direction"):
        build_table(rotor, **ends | {"omega": (-400.0, 800.0)})
