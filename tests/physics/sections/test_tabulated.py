"""The tabulated law: what it interpolates, its slopes, and its bounds."""

from __future__ import annotations

import numpy as np
import pytest

import propmap as pm
from propmap.arrays.namespace import by_numpy
from propmap.engine.rotor_arrays import section_law
from propmap.loads import LOADS, error_scales
from propmap.physics.sections.law import Coefficients, coefficients_at
from tests.oracle.literal_section import LiteralTable
from tests.oracle.naca_0015 import FILE, naca_0015
from tests.physics.paper_physics import TABLE_I
from tests.physics.sections.sampled import sampled

RANDOM = np.random.default_rng(15)


def uneven(count: int, cambered: bool = False) -> LiteralTable:
    """A rough table: uneven steps, lift and drag that differ with Re."""
    inner = np.linspace(-3.0, 3.0, 42) + RANDOM.uniform(-0.07, 0.07, 42)
    angle = np.concatenate([[-np.pi], inner, [np.pi]])
    reynolds = np.geomspace(1e4, 1e6, count) if count > 1 else np.array([1e5])
    size = (count, angle.size)
    c_l = np.sin(2.0 * (angle + 0.1 * cambered)) + RANDOM.uniform(-0.05, 0.05, size)
    c_d = 0.05 + np.sin(angle) ** 2 + RANDOM.uniform(0.0, 0.05, size)
    c_l[:, -1], c_d[:, -1] = c_l[:, 0], c_d[:, 0]
    return LiteralTable(angle, reynolds, c_l, c_d)


def section(table: LiteralTable) -> pm.SectionTable:
    return pm.SectionTable(table.angle, table.reynolds, table.lift, table.drag)


def at(table: pm.SectionTable, alpha: np.ndarray, reynolds: np.ndarray) -> Coefficients:
    with by_numpy():
        return coefficients_at(section_law(table), alpha, reynolds)


@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("cambered", [False, True])
def test_values_are_those_of_scipy_and_hermite(count: int, cambered: bool) -> None:
    table = uneven(count, cambered)
    # The package turns the table to begin half a turn from zero lift, and has a knot more there,
    # which bends the curves of the intervals beside it.
    alpha, reynolds = RANDOM.uniform(-1.7, 1.7, 3000), 10.0 ** RANDOM.uniform(3.0, 7.0, 3000)
    lift, drag = table.coefficients(alpha, reynolds)
    got = at(section(table), alpha, reynolds)
    np.testing.assert_allclose(got.lift, lift, atol=1e-12)
    np.testing.assert_allclose(got.drag, drag, atol=1e-12)


@pytest.mark.skipif(not FILE.exists(), reason="no shared data beside this checkout")
def test_the_naca_0015_is_interpolated_as_stated() -> None:
    table = naca_0015()
    alpha, reynolds = RANDOM.uniform(-3.14, 3.14, 5000), 10.0 ** RANDOM.uniform(3.0, 7.5, 5000)
    lift, drag = table.coefficients(alpha, reynolds)
    got = at(section(table), alpha, reynolds)
    np.testing.assert_allclose(got.lift, lift, atol=1e-12)
    np.testing.assert_allclose(got.drag, drag, atol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_slopes_are_the_derivatives(count: int) -> None:
    table, h = section(uneven(count)), 1e-6
    alpha, log_re = RANDOM.uniform(-3.0, 3.0, 2000), RANDOM.uniform(8.0, 15.0, 2000)

    def value(da: float, dx: float) -> tuple[np.ndarray, np.ndarray]:
        return at(table, alpha + da, np.exp(log_re + dx))[:2]

    got = at(table, alpha, np.exp(log_re))
    for k, (by_angle, by_re) in enumerate(
        [(got.lift_slope, got.lift_by_log_re), (got.drag_slope, got.drag_by_log_re)]
    ):
        along = (value(h, 0.0)[k] - value(-h, 0.0)[k]) / (2.0 * h)
        across = (value(0.0, h)[k] - value(0.0, -h)[k]) / (2.0 * h)
        # C1: across a knot the central difference is off by h times the jump of the bend, < 1e4.
        np.testing.assert_allclose(by_angle, along, atol=2e-2 * np.abs(along).max())
        assert np.median(np.abs(by_angle - along)) < 1e-7
        np.testing.assert_allclose(np.broadcast_to(by_re, across.shape), across, atol=1e-4)


def test_both_ends_of_the_table_are_one_angle() -> None:
    table = section(uneven(3, cambered=True))
    below, above = at(table, np.array([-np.pi, np.pi]), np.full(2, 1e5)).lift
    assert below == pytest.approx(above, abs=1e-9)


@pytest.mark.parametrize("name", ["soft", "stiff", "apc"])
def test_a_table_of_the_paper_s_law_gives_its_loads(name: str) -> None:
    """Within 0.02 % of static loads, descent included.

    It is the law that is compared: where the nodes of "standard" differ, those of "fine" tell.
    """
    blade, law = pm.propeller("apc-8x6e"), TABLE_I[name]
    table = sampled(law, 0.05, 1.0, np.geomspace(1e2, 1e6, 33))
    n, random = 25, np.random.default_rng(4)
    omega, speed = random.uniform(200.0, 1000.0, n), random.uniform(0.0, 18.0, n)
    beta = random.uniform(0.0, np.pi, n)
    speed[:3], beta[3:6], beta[6:9] = 0.0, 0.0, np.pi
    laws = (pm.airfoil(f"paper-{name}"), table)

    def errors(accuracy: str, some: slice | np.ndarray) -> np.ndarray:
        point = omega[some], speed[some], beta[some]
        want, got, static = (
            pm.Rotor(pm.Model(blade, section), accuracy=accuracy, compiled=False).loads(*flow)
            for section, flow in (
                *((section, point) for section in laws),
                (laws[0], (point[0], 0.0, 0.0)),
            )
        )
        at_rest = {name: getattr(static, name) for name in ("thrust", "torque")}
        scales = error_scales(at_rest, blade.radius).values()
        return np.array(
            [
                np.abs(getattr(got, load) - getattr(want, load)) / scale
                for load, scale in zip(LOADS, scales, strict=True)
            ]
        )

    differ = np.flatnonzero(errors("standard", slice(None)).max(axis=0) >= 2e-4)
    assert differ.size <= 2
    assert errors("fine", differ).max(initial=0.0) < 2e-4


@pytest.mark.parametrize("name", ["uneven", "coarse", "naca-0015"])
def test_bounds_hold_at_any_reynolds_number(name: str) -> None:
    """Second differences by the angle and ln Re, between the knots and across them."""
    if name == "naca-0015":
        if not FILE.exists():
            pytest.skip(f"{FILE.name} is not beside this checkout")
        table = section(naca_0015())
    else:
        coarse = sampled(TABLE_I["apc"], 2.5, 10.0, np.geomspace(1e4, 4e5, 4))
        table = coarse if name == "coarse" else section(uneven(5))
    law, h = section_law(table), 1e-4
    limit = law.bounds()
    zero, log_re = float(law.zero_lift_angle), RANDOM.uniform(9.0, 13.0, 40)[:, None]
    alpha = np.linspace(-1.5, 1.5, 4001)

    def values(da: float, dx: float) -> np.ndarray:
        return np.asarray(at(table, alpha + zero + da, np.exp(log_re + dx))[:2])

    middle = values(0.0, 0.0)
    by_angle = (values(h, 0.0) - 2.0 * middle + values(-h, 0.0)) / h**2
    by_re = np.abs(values(0.0, h) - values(0.0, -h)) / (2.0 * h)
    assert np.abs(middle[0]).max() <= limit.lift
    most = (np.abs(by_angle[0]) + by_re[0]).max()
    # Differences of 1e-4 have rounding of 1e-16 / 1e-8.
    assert 0.05 * limit.lift_bend < most <= limit.lift_bend * (1.0 + 1e-6) + 1e-6
    drag = np.abs(middle[1] + by_angle[1]) * 2.0 / 3.0**1.5  # the largest of k^2 s
    assert drag.max() <= limit.drag_bend
    inside = (alpha > limit.attached_from) & (alpha < limit.attached_to)
    assert by_angle[0][:, inside].max() <= limit.attached_bend * (1.0 + 1e-6) + 1e-6
