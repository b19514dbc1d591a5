"""Loads with corrections of the blade and of its sections."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import propmap as pm
from propmap.arrays.namespace import by_numpy
from propmap.loads import LOADS
from propmap.physics.velocities import azimuth_nodes
from propmap.solve.disk import DiskSolution
from propmap.solve.load_slopes import directions_of, load_slopes, moving
from propmap.solve.problem import Case
from propmap.solve.rotor_loads import RotorLoads, search_loads
from tests.oracle.literal_rotor import literal_loads
from tests.oracle.points import MU, RHO, SECTIONS

BLADE, LAW = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")
BOTH = ("blade-to-hub", "radial-friction")


def rotor(*texts: str, compiled: bool = False, accuracy: str = "standard") -> pm.Rotor:
    corrections = tuple(pm.correction(text) for text in texts)
    model = pm.Model(BLADE, LAW, corrections=corrections)
    return pm.Rotor(model, compiled=compiled, accuracy=accuracy)


def literal(omega: float, along: float, across: float, hub: float) -> dict[str, float]:
    """The literal rotor on a blade that was continued beforehand, by hand."""
    first = float(BLADE.station[0])
    chord_at = PchipInterpolator(BLADE.station, BLADE.chord)
    taper = (float(chord_at(first + 0.01016)) - BLADE.chord[0]) / 0.01016
    inside = np.linspace(hub, first, 40)[:-1]
    pitch = 2.0 * np.pi * first * np.tan(BLADE.twist[0])
    chord = np.clip(BLADE.chord[0] - taper * (first - inside), 0.5 * BLADE.chord[0], BLADE.chord[0])
    return literal_loads(
        np.concatenate([inside, BLADE.station]),
        np.concatenate([chord, BLADE.chord]),
        np.concatenate([np.arctan(pitch / (2.0 * np.pi * inside)), BLADE.twist]),
        BLADE.blades,
        SECTIONS["apc"],
        *(RHO, MU, omega, along, across),
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("omega", "along", "across"),
    [
        (600.0, 0.0, 0.0),
        (600.0, 6.0, 8.0),
        (500.0, 0.0, 15.0),
        (700.0, 3.0, 1.0),
        (600.0, 12.0, 0.0),
    ],
)
def test_a_longer_blade_has_the_loads_of_the_literal_rotor(
    omega: float, along: float, across: float
) -> None:
    """To 0.1 % of static loads, like every load."""
    one = rotor("blade-to-hub:radius_m=0.008")
    got, still = one.loads_at_velocity(omega, [across, 0.0, along]), one.loads(omega, 0.0, 0.0)
    want = literal(omega, along, across, 0.008)
    for name in ("thrust", "drag", "torque", "roll_moment"):
        load = LOADS[name]
        scale = float(getattr(still, load.scale))
        scale *= 1.0 if load.unit == LOADS[load.scale].unit else BLADE.radius
        assert float(getattr(got, name)) == pytest.approx(want[name], abs=1e-3 * scale), name


def test_a_blade_that_is_hardly_longer_has_hardly_other_loads() -> None:
    points = (600.0, np.array([0.0, 3.0, 10.0, 9.0]), np.array([0.0, 0.3, 1.4, 1.7]))
    plain = rotor(accuracy="fine").loads(*points)
    hub = float(BLADE.station[0]) - 1e-6
    longer = rotor(f"blade-to-hub:radius_m={hub!r}", accuracy="fine").loads(*points)
    for name in LOADS:
        off = np.abs(getattr(longer, name) - getattr(plain, name))
        assert off.max() < 2e-4 * float(plain.thrust.max()), name


def test_what_is_inside_is_dragged_along_and_lifts_little() -> None:
    points = (600.0, np.array([5.0, 10.0, 15.0]), np.pi / 2)
    plain, longer = rotor().loads(*points), rotor("blade-to-hub").loads(*points)
    assert (longer.drag > 1.05 * plain.drag).all()
    assert (longer.drag < 1.25 * plain.drag).all()
    np.testing.assert_allclose(longer.thrust, plain.thrust, rtol=0.02)
    smaller = rotor("blade-to-hub:radius_m=0.005").loads(*points)
    assert (smaller.drag > longer.drag).all()


def test_reverse_flow_and_inflow_reach_to_the_hub() -> None:
    one, plain = rotor("blade-to-hub"), rotor()
    assert one.inflow(600.0, 10.0, 1.5).radius[0] == pytest.approx(0.08 * BLADE.radius)
    longer, shorter = (float(r.loads(600.0, 20.0, 1.5).reverse_flow) for r in (one, plain))
    assert longer > shorter
    assert one.model.reynolds(600.0, 10.0, 1.5)[0] < plain.model.reynolds(600.0, 10.0, 1.5)[0]


def test_a_mirrored_rotor_has_a_mirrored_wrench() -> None:
    """About the plane of symmetry y = 0: force (x, -y, z), moment (-x, y, -z)."""
    one = rotor("pitt-peters", *BOTH)
    ccw = one.wrench(600.0, [7.0, 3.0, 2.0], "ccw")
    cw = one.wrench(600.0, [7.0, -3.0, 2.0], "cw")
    np.testing.assert_allclose(cw.force, ccw.force * [1.0, -1.0, 1.0], rtol=1e-12)
    np.testing.assert_allclose(cw.moment, ccw.moment * [-1.0, 1.0, -1.0], rtol=1e-12)


@pytest.mark.slow
def test_compiled_batches_agree_with_numpy_anywhere() -> None:
    """Points of the whole envelope, each with loads or a status that says why not."""
    random = np.random.default_rng(5)
    points = (
        random.uniform(200.0, 900.0, 60),
        random.uniform(0.0, 20.0, 60),
        random.uniform(0.0, np.pi, 60),
    )
    want = rotor("pitt-peters", *BOTH).loads(*points)
    got = rotor("pitt-peters", *BOTH, compiled=True).loads(*points)
    assert (got.status == want.status).all()
    lost = got.status == "not_converged"
    for name in LOADS:
        a, b = getattr(got, name), getattr(want, name)
        np.testing.assert_allclose(a, b, atol=1e-7 * np.nanmax(np.abs(want.thrust)))
        assert (np.isfinite(a) == ~lost).all()


@pytest.mark.parametrize(
    "texts",
    [
        ("radial-friction",),
        pytest.param(("blade-to-hub",), marks=pytest.mark.slow),
        pytest.param(("stall-delay", "prandtl-glauert"), marks=pytest.mark.slow),
        pytest.param(("pitt-peters", *BOTH), marks=pytest.mark.slow),
    ],
)
def test_derivatives_agree_with_differences(
    texts: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """To 1e-6 of the largest derivative, at nodes that stay where they are."""
    from propmap.solve import harmonics

    # What the search for harmonics leaves off would be divided by the differences' step.
    monkeypatch.setattr(harmonics, "CLOSE", 1e-9)
    names = ("omega", "v_axial", "v_inplane", "c_l1", "c_d", "c_d0", "c_p", "alpha_0")
    arrays = rotor(*texts).arrays
    flow = {
        "omega": np.array([500.0, 620.0, 800.0, 600.0]),
        "v_axial": np.array([3.0, 1.0, 6.0, -0.5]),
        "v_inplane": np.array([6.0, 12.0, 9.0, 11.0]),
    }
    panels, nodes = (40,), azimuth_nodes(32)

    def solved(change: dict[str, float]) -> tuple[Case, RotorLoads, DiskSolution]:
        law = {name: by for name, by in change.items() if name not in flow}
        moved = (flow[name] + change.get(name, 0.0) for name in flow)
        case = Case(arrays._replace(law=arrays.law.plus(**law)), *moved, None)  # type: ignore[arg-type]
        return case, *search_loads(case, panels, nodes)

    with by_numpy():
        ends = {
            name: [np.stack(solved({name: by})[1].loads) for by in (1e-5, -1e-5)] for name in names
        }
        case, _, solution = solved({})
    ways = directions_of(moving(arrays), names, len(names))
    with jax.enable_x64(True):
        on_device = (jax.tree.map(jnp.asarray, one) for one in (case, solution))
        found = load_slopes(*on_device, panels, nodes, ways, None)
    for name, got in zip(names, np.asarray(found), strict=True):
        want = (ends[name][0] - ends[name][1]) / 2e-5
        scale = np.abs(want).max(axis=1, keepdims=True)
        assert (np.abs(got - want) <= 1e-6 * scale + 1e-12).all(), name
    drag = list(LOADS).index("drag")
    assert (np.abs(np.asarray(found)[:, drag]) > 0.0).all()
