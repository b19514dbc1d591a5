"""Derivatives of the loads against central differences, and finite where they could fail."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.typing import NDArray

import propmap as pm
from propmap.physics.element import Medium
from propmap.physics.geometry import make_blade
from propmap.physics.sections.blended import BlendedLaw
from propmap.physics.velocities import azimuth_nodes
from propmap.solve.problem import Case, RotorArrays
from propmap.solve.resolution import Resolution
from propmap.solve.rotor_loads import disk_loads, rotor_loads

BLADE = pm.propeller("apc-8x6e")
APC = pm.airfoil("paper-apc")
FLOW = ("omega", "v_axial", "v_inplane")
LAW = ("c_l1", "c_l2", "c_d", "alpha_0", "zero_lift_angle", "c_d0", "c_p", "sharpness")
SIZES = dict(
    zip((*FLOW, *LAW), (600.0, 5.0, 5.0, 5.3, 1.7, 1.8, 0.36, 0.1, 0.01, 1.3, 50.0), strict=True)
)
RESOLUTION = Resolution(azimuths=24, stations=48)

Parameters = dict[str, Any]


def _parameters(omega: float, v_axial: float, v_inplane: float) -> Parameters:
    law = {name: np.float64(getattr(APC, name)) for name in LAW}
    flow = {"omega": omega, "v_axial": v_axial, "v_inplane": v_inplane}
    return {**flow, **law, "chord": np.array(BLADE.chord), "twist": np.array(BLADE.twist)}


def _arguments(p: Parameters) -> tuple[Any, ...]:
    number = jnp.asarray
    root, blades = number(BLADE.root), number(float(BLADE.blades))
    blade = make_blade(number(BLADE.station), p["chord"], p["twist"], blades, root)
    law = BlendedLaw(**{name: number(p[name]) for name in LAW}, attached=number(1.0))
    flow = (jnp.reshape(p[name], (1,)) for name in FLOW)
    return RotorArrays(blade, law, Medium(number(1.225), number(1.983e-5))), *flow


def _climbing(p: Parameters) -> jax.Array:
    """Thrust, drag, torque and rolling moment where v_axial >= 0; shape (4,)."""
    nodes = azimuth_nodes(RESOLUTION.azimuths)
    found = disk_loads(Case(*_arguments(p), jnp.zeros(1)), RESOLUTION.panels, nodes)
    return jnp.concatenate(found.loads)


def _anywhere(p: Parameters) -> jax.Array:
    return jnp.concatenate(rotor_loads(*_arguments(p), Resolution(azimuths=8, stations=24)).loads)


@pytest.fixture(scope="module")
def climbing() -> Callable[..., tuple[jax.Array, jax.Array]]:
    return jax.jit(lambda p, dp: jax.jvp(_climbing, (p,), (dp,)))


@pytest.fixture(scope="module")
def anywhere() -> Callable[..., tuple[jax.Array, jax.Array]]:
    return jax.jit(lambda p, dp: jax.jvp(_anywhere, (p,), (dp,)))


def _along(p: Parameters, name: str, station: int | None = None) -> Parameters:
    """A tangent of one for one parameter, or for one station of the chord or the twist."""
    tangent = {key: np.zeros_like(np.asarray(value)) for key, value in p.items()}
    if station is None:
        tangent[name] = np.ones_like(tangent[name])
    else:
        tangent[name][station] = 1.0
    return tangent


def _difference(
    loads: Callable[..., tuple[jax.Array, jax.Array]], p: Parameters, way: Parameters, step: float
) -> NDArray[np.float64]:
    """Central difference of fourth order; the program's tangent output is not used."""

    def at(size: float) -> NDArray[np.float64]:
        moved = {key: value + size * way[key] for key, value in p.items()}
        return np.asarray(loads(moved, way)[0])

    near, far = at(step) - at(-step), at(2.0 * step) - at(-2.0 * step)
    return (8.0 * near - far) / (12.0 * step)


POINTS = {
    "oblique": (600.0, 6.0, 10.0),
    "edgewise": (700.0, 0.0, 5.0),
    "axial climb": (600.0, 8.0, 0.0),
    "fast": (500.0, 12.0, 12.0),
}


@pytest.mark.slow
@pytest.mark.parametrize("where", POINTS)
def test_gradients_match_central_differences(
    where: str, climbing: Callable[..., tuple[jax.Array, jax.Array]]
) -> None:
    """1e-6 of the largest load's change over the parameter's own size."""
    with jax.enable_x64(True):
        p = _parameters(*POINTS[where])
        ways = [(name, None, SIZES[name]) for name in (*FLOW, *LAW)]
        ways += [("chord", 20, 0.02), ("twist", 20, 0.4), ("twist", 5, 0.4)]
        for name, station, size in ways:
            if name == "v_inplane" and POINTS[where][2] == 0.0:
                continue  # an edge of its domain: see the test of finite gradients
            if name == "v_axial" and POINTS[where][1] == 0.0:
                continue
            way = _along(p, name, station)
            exact = np.asarray(climbing(p, way)[1])
            numeric = _difference(climbing, p, way, 2e-4 * size)
            assert exact == pytest.approx(numeric, abs=1e-6 * np.abs(exact).max()), (name, station)


@pytest.mark.parametrize("name", ["omega", "c_l1", "c_l2", "alpha_0", "zero_lift_angle"])
def test_gradients_include_the_moving_jump_in_hover(
    name: str, climbing: Callable[..., tuple[jax.Array, jax.Array]]
) -> None:
    """Hover, where the inflow jumps at 0.035 m: the jump's own motion is in the gradient."""
    with jax.enable_x64(True):
        p = _parameters(600.0, 0.0, 0.0)
        way = _along(p, name)
        exact = np.asarray(climbing(p, way)[1])
        numeric = _difference(climbing, p, way, 1e-4 * SIZES[name])
        assert exact == pytest.approx(numeric, abs=2e-4 * np.abs(exact).max())


@pytest.mark.slow
def test_reverse_mode_equals_forward_mode(
    climbing: Callable[..., tuple[jax.Array, jax.Array]],
) -> None:
    with jax.enable_x64(True):
        p = _parameters(600.0, 6.0, 10.0)
        thrust = jax.jit(jax.value_and_grad(lambda q: _climbing(q)[0]))
        _, back = thrust(p)
        for name in ("omega", "alpha_0"):
            ahead = climbing(p, _along(p, name))[1][0]
            assert float(back[name]) == pytest.approx(float(ahead), rel=1e-10)
        twist = climbing(p, _along(p, "twist", 20))[1][0]
        assert float(back["twist"][20]) == pytest.approx(float(twist), rel=1e-9)


EDGES = {
    "everything at rest": (0.0, 0.0, 0.0),
    "hover": (600.0, 0.0, 0.0),
    "axial climb": (600.0, 10.0, 0.0),
    "stopped in climb": (0.0, 10.0, 0.0),
    "stopped edgewise": (0.0, 0.0, 10.0),
    "windmilling in climb": (200.0, 20.0, 0.0),
    "vortex ring": (600.0, -4.0, 0.0),
    "mid vortex ring": (600.0, -5.4, 1.0),
    "windmill descent": (600.0, -15.0, 0.0),
    "oblique descent": (600.0, -8.0, 12.0),
}


@pytest.mark.slow
@pytest.mark.parametrize("where", EDGES)
def test_gradients_are_finite_everywhere(
    where: str, anywhere: Callable[..., tuple[jax.Array, jax.Array]]
) -> None:
    with jax.enable_x64(True):
        p = _parameters(*EDGES[where])
        for name in (*FLOW, "c_l1", "c_d", "alpha_0", "chord", "twist"):
            value, slope = anywhere(p, _along(p, name))
            assert np.isfinite(value).all(), name
            assert np.isfinite(slope).all(), name


def test_drag_rises_in_proportion_to_a_small_in_plane_velocity(
    anywhere: Callable[..., tuple[jax.Array, jax.Array]],
) -> None:
    """At V = 0 the drag's slope is not zero: a gradient through |V| would lose it."""
    with jax.enable_x64(True):
        p = _parameters(600.0, 0.0, 0.0)
        slope = np.asarray(anywhere(p, _along(p, "v_inplane"))[1])
        p["v_inplane"] = 1e-3
        drag = np.asarray(anywhere(p, _along(p, "v_inplane"))[0])[1]
        assert slope[1] == pytest.approx(drag / 1e-3, rel=1e-4)
        assert slope[1] > 0.0
        assert slope[0] == pytest.approx(0.0, abs=1e-9)
