"""No jumps: along fine lines through the multi-root band, and through the descent states.

With losses at tip and hub, with tabulated sections and as the in-plane velocity vanishes, too.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import propmap as pm
from propmap.rotor import Rotor
from propmap.typing import Floats
from tests.rotor.test_largest_root import CASES, COARSE

STEPS = 1201
BLADE = pm.propeller("apc-8x6e")


@pytest.fixture(scope="module", params=["paper-soft", "paper-apc", "paper-stiff"])
def rotor(request: pytest.FixtureRequest) -> Rotor:
    return pm.Rotor(pm.Model(BLADE, pm.airfoil(request.param)))


def _largest_jump(values: Floats) -> float:
    """The largest step that its neighbors do not announce; a smooth line has almost none."""
    step = np.diff(values)
    expected = np.maximum(np.abs(step[:-2]), np.abs(step[2:]))
    return float(np.max(np.abs(step[1:-1]) - expected))


def _steepest(values: Callable[[Floats], Floats], x: Floats, count: int, points: int) -> Floats:
    """Steps that are left of the largest ones, and of those that stand out, when zoomed in on."""
    step = np.abs(np.diff(values(x)))
    stands_out = step[1:-1] - np.maximum(step[:-2], step[2:])
    k = np.union1d(1 + np.argsort(stands_out)[-count:], np.argsort(step)[-count:])
    low, high, each = x[k], x[k + 1], np.arange(k.size)
    for _ in range(3):
        fine = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, points)
        step = np.abs(np.diff(values(fine), axis=1))
        k = np.nanargmax(step, axis=1)
        low, high = fine[each, k], fine[each, k + 1]
    return step


LINES = {
    "speed, 45 deg": lambda s: (600.0 + 0 * s, 3.0 * s, np.pi / 4 + 0 * s),
    "speed, edgewise": lambda s: (600.0 + 0 * s, 3.0 * s, np.pi / 2 + 0 * s),
    "omega, 1 m/s": lambda s: (200.0 + 800.0 * s, 1.0 + 0 * s, 1.0 + 0 * s),
    "beta, 3 m/s": lambda s: (600.0 + 0 * s, 3.0 + 0 * s, np.pi / 2 * s),
}


@pytest.mark.parametrize("line", LINES)
def test_loads_do_not_jump_with_the_operating_point(rotor: Rotor, line: str) -> None:
    omega, speed, beta = LINES[line](np.linspace(0.0, 1.0, STEPS))
    loads = rotor.loads(omega, speed, beta)
    static = rotor.loads(omega, 0.0, 0.0).thrust
    assert np.all(loads.status != "not_converged")
    if rotor.model.airfoil.name != "paper-stiff":
        assert "multiple_roots" in loads.status
    assert _largest_jump(loads.thrust / static) < 1e-4
    assert _largest_jump(loads.drag / static) < 1e-4
    assert _largest_jump(loads.torque / (static * BLADE.radius)) < 1e-4


PARAMETERS = {"c_l1": 0.2, "c_l2": 0.2, "c_d": 0.3, "alpha_0": 0.03, "zero_lift_angle": 0.02}


@pytest.mark.parametrize("name", PARAMETERS)
def test_loads_do_not_jump_with_the_section_parameters(name: str) -> None:
    law = pm.airfoil("paper-apc")
    values = getattr(law, name) + PARAMETERS[name] * np.linspace(-1.0, 1.0, 121)
    laws = (law.with_parameters(**{name: value}) for value in values)
    rotors = (pm.Rotor(pm.Model(BLADE, one)) for one in laws)
    thrust = np.array([float(one.loads(600.0, 2.0, 1.0).thrust) for one in rotors])
    assert _largest_jump(thrust / thrust[60]) < 1e-4


DESCENTS = [180.0, 178.0, 165.0, 145.0, 130.0, 95.0]
SOONER = {"paper-soft": (130.0,), "paper-apc": (165.0,), "paper-stiff": ()}


@pytest.mark.parametrize(
    ("rotor", "beta_deg"),
    [
        pytest.param(name, beta, marks=() if beta in sooner else (pytest.mark.slow,))
        for name, sooner in SOONER.items()
        for beta in DESCENTS
    ],
    indirect=["rotor"],
)
def test_thrust_is_continuous_from_hover_through_vortex_ring_into_windmill(
    rotor: Rotor, beta_deg: float
) -> None:
    """Past 2 v_h of descent the slope of the thrust has no bound, but thrust does not step."""
    beta = np.deg2rad(beta_deg)
    speed = np.linspace(0.0, 24.0, 4801)
    loads = rotor.loads(600.0, speed, beta)
    thrust = loads.thrust
    static = float(rotor.loads(600.0, 0.0, 0.0).thrust)
    assert np.isfinite(thrust).all()
    assert (thrust > 0.0).all()
    step = _steepest(lambda v: rotor.loads(600.0, v, beta).thrust / static, speed, 8, 97)
    # The very speed at which a stretch vanishes has a double root: not converged, perhaps.
    assert np.isnan(step).sum() <= 4
    assert np.nanmax(step) < 1e-3
    slow = speed[:-1] < 1.9 * float(rotor.hover_inflow(600.0))
    assert np.max(np.abs(np.diff(thrust))[slow]) < 0.004 * static
    if beta_deg >= 165.0:
        assert "vortex_ring" in loads.status
        assert "windmill" in loads.status


OTHER_LINES = {
    **{line: LINES[line] for line in ("speed, 45 deg", "omega, 1 m/s", "beta, 3 m/s")},
    "descent, 165 deg": lambda s: (600.0 + 0 * s, 11.0 * s, np.radians(165.0) + 0 * s),
    "descent, 105 deg": lambda s: (600.0 + 0 * s, 11.0 * s, np.radians(105.0) + 0 * s),
}
LIMITS = {"tip loss": 1e-4, "hub loss": 1e-3, "coarse table": 1e-3}
"""A share of static thrust, in climb.  With the paper's law and with tip loss there are two folds,
whose radii are followed, so that loads do not step.  With hub loss there are three, and a table
stalls at another angle for each Reynolds number: there, as with any law in descent, nodes flip at
some points, and loads step by the error of "standard" at most."""

OTHERS_SOONER = {
    ("tip loss", "beta, 3 m/s"),
    ("hub loss", "descent, 165 deg"),
    ("coarse table", "beta, 3 m/s"),
}


@pytest.mark.parametrize(
    ("name", "line"),
    [
        pytest.param(name, line, marks=() if (name, line) in OTHERS_SOONER else (pytest.mark.slow,))
        for name in LIMITS
        for line in OTHER_LINES
    ],
)
def test_loads_of_other_laws_do_not_jump(name: str, line: str) -> None:
    """The steps that stand out, and the largest ones, become small when zoomed in on."""
    _, law, losses = CASES.get(name, (None, COARSE, ()))
    corrections = tuple(pm.correction(text) for text in losses)
    rotor = pm.Rotor(pm.Model(BLADE, law, corrections=corrections))
    static = float(rotor.loads(600.0, 0.0, 0.0).thrust)

    def thrust(s: np.ndarray) -> np.ndarray:
        omega, speed, beta = OTHER_LINES[line](s)
        found = rotor.loads(omega, speed, beta)
        assert np.all(found.status != "not_converged")
        return found.thrust / (static * (omega / 600.0) ** 2)

    step = _steepest(thrust, np.linspace(0.0, 1.0, 121), 3, 17)
    assert step.max() < max(LIMITS[name], 1e-3 * line.startswith("descent"))


INPLANE = np.concatenate([[0.0], np.logspace(-300.0, 0.0, 61), np.logspace(-12.0, -2.0, 31)])
CLIMB = (-8.0, -3.0, -0.3, 0.0, 0.3, 2.0)
MODELS = {
    "paper": lambda: pm.Model(BLADE, pm.airfoil("paper-apc")),
    "recommended": lambda: pm.catalogue_model("APC 8x6E"),
    "finite blades": lambda: pm.Model(
        BLADE,
        pm.airfoil("paper-apc"),
        corrections=(pm.correction("tip-loss"), pm.correction("hub-loss")),
    ),
}


@pytest.mark.parametrize("name", MODELS)
def test_no_in_plane_velocity_is_too_small(name: str) -> None:
    rotor = pm.Rotor(MODELS[name]())
    still = rotor.loads(600.0, 0.0, 0.0)
    for climb in CLIMB:
        loads = rotor.loads(600.0, np.hypot(climb, INPLANE), np.arctan2(INPLANE, climb))
        assert (loads.status != "not_converged").all()
        close = INPLANE < 1e-9
        for load, scale in ((loads.thrust, still.thrust), (loads.torque, still.torque)):
            assert np.isfinite(load).all()
            np.testing.assert_allclose(load[close], load[0], atol=1e-9 * float(scale))
        np.testing.assert_allclose(loads.drag[close], 0.0, atol=1e-9 * float(still.thrust))
