"""Eq. (11): the largest root against a brute-force scan, and its derivative."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

import propmap
from propmap.physics.element import Annulus, Station
from propmap.physics.sections.blended import BlendedLaw
from propmap.physics.velocities import azimuth_nodes
from propmap.physics.wake import Wake
from propmap.solve.problem import AnnulusProblem
from propmap.solve.root import MAX_STEPS, inflow_root
from tests.physics.paper_physics import MU, RHO, TABLE_I, Law, forces, turn

AZIMUTHS = 24
HOVER = 6000.0 * 2.0 * np.pi / 60.0
BANDS = {"soft": (0.0328, 0.0353), "apc": (0.0350, 0.0362)}
"""[m] Where (11) has three roots in hover at 6000 rpm."""

WINDMILL_BELOW = -5.0
"""[m/s] of V_axial from which the windmill branch is asked for here."""

Cases = tuple[tuple[Any, Any, Any], tuple[Any, Any, Any]]


def cases(band: tuple[float, float]) -> Cases:
    """60 elements (radius, chord, twist) and flows (omega, V_axial >= 0, V_inplane >= 0).

    The first ten hover inside the band; of the rest, about a third each is axial, edgewise
    and oblique, from stall at a standstill to a blade that is driven by the air.
    """
    random = np.random.default_rng(20170827)
    prop = propmap.propeller("apc-8x6e")
    low, high = band[0] + 1e-4, band[1] - 1e-4  # its edges are rounded to 0.1 mm
    n = 50
    kind = np.arange(n) % 3
    radius = np.concatenate([np.linspace(low, high, 10), random.uniform(0.0245, 0.1014, n)])
    omega = np.concatenate([np.full(10, HOVER), random.uniform(150.0, 900.0, n)])
    axial = np.where(kind == 1, 0.0, random.uniform(0.0, 20.0, n))
    inplane = np.where(kind == 0, 0.0, random.uniform(0.0, 20.0, n))
    still = np.zeros(10)
    element = (
        radius,
        PchipInterpolator(prop.station, prop.chord)(radius),
        PchipInterpolator(prop.station, prop.twist)(radius),
    )
    return element, (omega, np.concatenate([still, axial]), np.concatenate([still, inplane]))


def literal_residual(law: Law, element: Any, flow: Any, v_i: Any, windmill: bool = False) -> Any:
    """(5) minus (10), per density and radius, of one element at v_i (any shape)."""
    _, v_axial, v_inplane = flow
    v = np.asarray(v_i)[..., None]
    blade = 2.0 * np.mean(forces(law, element, flow, v, turn(AZIMUTHS))[0], axis=-1)
    return blade - literal_wake(element[0], v_axial, v_inplane, np.asarray(v_i), windmill)


def literal_wake(y: float, v_axial: float, v_inplane: float, v_i: Any, windmill: bool) -> Any:
    """(10); on the windmill branch with its falling stretch mirrored."""

    def glauert(v: Any) -> Any:
        return 4.0 * np.pi * y * v * np.hypot(v_inplane, v_axial + v)

    if not windmill or v_axial**2 <= 8.0 * v_inplane**2:
        return glauert(v_i)
    # (10) is stationary where (V_inplane^2 + (V_axial + v)^2) + v (V_axial + v) = 0.
    one, two = np.sort(np.roots([2.0, 3.0 * v_axial, v_axial**2 + v_inplane**2]).real)
    beyond = glauert(v_i) + 2.0 * (glauert(one) - glauert(two))
    mirrored = 2.0 * glauert(one) - glauert(v_i)
    return np.where(v_i <= one, glauert(v_i), np.where(v_i <= two, mirrored, beyond))


def all_roots(law: Law, element: Any, flow: Any, windmill: bool = False) -> list[float]:
    """Every v_i at which the literal residual changes its sign, by a fine scan."""
    omega, v_axial, v_inplane = flow
    speed = omega * element[0] + abs(v_axial) + v_inplane
    grid = np.linspace(-speed - abs(v_axial), speed, 4001)
    function = functools.partial(literal_residual, law, element, flow, windmill=windmill)
    values = function(grid)
    assert values[-1] < 0.0  # momentum prevails at the top, so no root lies above
    changes = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    return [brentq(function, grid[k], grid[k + 1], xtol=1e-13, rtol=1e-14) for k in changes]


def posed(law: BlendedLaw, element: Any, flow: Any) -> AnnulusProblem:
    radius, chord, twist = (a[None] for a in element)
    angle, per_speed = twist - law.zero_lift_angle, RHO / MU * chord
    station = Station(
        radius, chord, jnp.sin(angle), jnp.cos(angle), per_speed, 1.0 / jnp.sqrt(per_speed)
    )
    ends = (jnp.asarray(2.0), jnp.asarray(0.0), jnp.asarray(0.11))
    windmill = jnp.where(flow[1] < WINDMILL_BELOW, 1.0, 0.0)
    return AnnulusProblem(Annulus(station, *flow, *ends, law), Wake(windmill))


@jax.jit
def solve(law: BlendedLaw, element: Any, flow: Any, max_steps: Any) -> Any:
    return inflow_root(posed(law, element, flow), max_steps, azimuth_nodes(AZIMUTHS))[0]


def solved(law: Law, element: Any, flow: Any, max_steps: int = MAX_STEPS) -> np.ndarray:
    arrays = jax.tree.map(jnp.asarray, (element, flow))
    return np.asarray(solve(law.section(), *arrays, jnp.asarray(max_steps)))


def one(pair: Cases, k: int) -> Cases:
    element, flow = pair
    return tuple(float(a[k]) for a in element), tuple(float(a[k]) for a in flow)  # type: ignore[return-value]


@pytest.mark.parametrize("name", BANDS)
def test_inflow_is_the_largest_of_all_roots(name: str) -> None:
    law, pair = TABLE_I[name], cases(BANDS[name])
    got = solved(law, *pair)
    counts = []
    for k, v_i in enumerate(got):
        roots = all_roots(law, *one(pair, k))
        counts.append(len(roots))
        # A Newton step of 1e-9 of the speeds ends the search, and the next would be its
        # square; beside a fold both searches see a residual of 1e-13 as a root.
        speed = pair[1][0][k] * pair[0][0][k]
        assert v_i == pytest.approx(max(roots), abs=1e-9 * speed), f"case {k}: {roots}"
    assert min(counts[:10]) == 3  # the band is one of three roots: the test can fail


@pytest.mark.parametrize("name", BANDS)
def test_outside_the_band_there_is_one_root_on_either_side(name: str) -> None:
    prop, law = propmap.propeller("apc-8x6e"), TABLE_I[name]
    low, high = BANDS[name]
    roots = []
    for radius in (low - 0.001, high + 0.001):
        chord = float(PchipInterpolator(prop.station, prop.chord)(radius))
        twist = float(PchipInterpolator(prop.station, prop.twist)(radius))
        roots.append(all_roots(law, (radius, chord, twist), (HOVER, 0.0, 0.0)))
    assert [len(r) for r in roots] == [1, 1]
    assert roots[1][0] > roots[0][0]  # the attached branch has the larger inflow


def test_the_simplified_law_and_camber_have_their_root_too() -> None:
    pair = cases(BANDS["apc"])
    for law in (
        replace(TABLE_I["apc"], attached=0.0),
        replace(TABLE_I["apc"], zero_lift_angle=-0.07),
    ):
        got = solved(law, *pair)
        for k in range(0, 60, 4):
            speed = pair[1][0][k] * pair[0][0][k]
            roots = all_roots(law, *one(pair, k))
            assert got[k] == pytest.approx(max(roots), abs=1e-9 * speed)


@pytest.mark.parametrize("name", BANDS)
def test_descent_has_the_largest_root_on_either_branch(name: str) -> None:
    # Even cases descend on the helicopter branch, odd ones on the windmill branch; a third
    # of them without in-plane flow, where (10) has a kink at V_axial + v_i = 0.
    law, (element, (omega, _, inplane)) = TABLE_I[name], cases(BANDS[name])
    rate = np.random.default_rng(5).uniform(0.0, 1.0, 60)
    axial = np.where(np.arange(60) % 2 == 0, WINDMILL_BELOW * rate, -6.0 - 15.0 * rate)
    pair = element, (omega, axial, inplane)
    got = solved(law, *pair)
    for k, v_i in enumerate(got):
        roots = all_roots(law, *one(pair, k), windmill=axial[k] < WINDMILL_BELOW)
        speed = omega[k] * element[0][k]
        assert v_i == pytest.approx(max(roots), abs=1e-9 * speed), f"case {k}: {roots}"


def test_an_unfinished_search_is_nan() -> None:
    assert np.all(np.isnan(solved(TABLE_I["soft"], *cases(BANDS["soft"]), max_steps=1)))


@functools.cache
def derivatives() -> np.ndarray:
    """By c_l1, alpha_0 and the factors of omega and chord; shape (4, 60)."""
    (radius, chord, twist), (omega, axial, inplane) = jax.tree.map(jnp.asarray, cases(BANDS["apc"]))
    section = TABLE_I["apc"].section()

    def root(x: Any) -> Any:
        changed = section._replace(c_l1=x[0], alpha_0=x[1])
        element, flow = (radius, x[3] * chord, twist), (x[2] * omega, axial, inplane)
        return solve(changed, element, flow, jnp.asarray(MAX_STEPS))

    at = jnp.stack([section.c_l1, section.alpha_0, jnp.asarray(1.0), jnp.asarray(1.0)])
    return np.asarray(jax.jit(jax.jacfwd(root))(at)).T


@pytest.mark.parametrize("by", ["c_l1", "alpha_0", "omega", "chord"])
def test_derivative_is_a_central_difference(by: str) -> None:
    law, (element, flow) = TABLE_I["apc"], cases(BANDS["apc"])
    (radius, chord, twist), (omega, axial, inplane) = element, flow

    def shifted(h: float) -> np.ndarray:
        if by in ("c_l1", "alpha_0"):
            return solved(replace(law, **{by: getattr(law, by) + h}), element, flow)
        if by == "omega":
            return solved(law, element, ((1.0 + h) * omega, axial, inplane))
        return solved(law, (radius, (1.0 + h) * chord, twist), flow)

    h = 1e-5
    difference = (shifted(h) - shifted(-h)) / (2.0 * h)
    got = derivatives()[("c_l1", "alpha_0", "omega", "chord").index(by)]
    # Beside a fold v_i is a square root of the distance to it; away from the band's edges
    # (the first ten) the third derivative times h^2 / 6 is small: (M h)^2 is 2.5e-7.
    np.testing.assert_allclose(got[10:], difference[10:], rtol=2e-5, atol=1e-6)
    np.testing.assert_allclose(got[1:9], difference[1:9], rtol=1e-3)
    assert np.max(np.abs(got)) > 0.1  # the root responds to it
