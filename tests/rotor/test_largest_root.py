"""The inflow at the nodes is the largest root of (11), against scans that share no code with it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import propmap as pm
from propmap.model.corrections import name_of
from propmap.operating_points import along_and_across
from tests.oracle.literal_rotor import LiteralRotor
from tests.oracle.literal_section import Array, LiteralTable, Section
from tests.oracle.literal_wake import LiteralWake
from tests.oracle.points import MU, RHO, SECTIONS
from tests.oracle.sampled import airfoil_of, sampled
from tests.other_laws import OtherRotor, other_flow, other_rotors

BLADE = pm.propeller("apc-8x6e")
COARSE = sampled(SECTIONS["soft"], 2.5, 10.0, np.geomspace(1e4, 4e5, 4))
SOFT, APC = pm.airfoil("paper-soft"), pm.airfoil("paper-apc")
FOOTNOTE_1 = SECTIONS["apc"] | {"attached": 0.0}

CASES: dict[str, tuple[Section, Any, tuple[str, ...]]] = {
    "table and both losses": (
        LiteralTable(COARSE.angle, COARSE.reynolds, COARSE.lift, COARSE.drag),
        COARSE,
        ("tip-loss", "hub-loss"),
    ),
    "tip loss": (SECTIONS["apc"], APC, ("tip-loss",)),
    "hub loss": (SECTIONS["soft"], SOFT, ("hub-loss",)),
    "apc": (SECTIONS["apc"], APC, ()),
    "simplified": (FOOTNOTE_1, airfoil_of(FOOTNOTE_1), ()),
}
HELD = 2e-4
"""[m] from tip and hub, in which Prandtl's factor approaches zero."""


def points(count: int, seed: int) -> list[tuple[float, float, float]]:
    """Omega [rad/s], V cos(beta) and V sin(beta) [m/s], every third in descent."""
    random, k = np.random.default_rng(seed), np.arange(count)
    omega = random.uniform(150.0, 900.0, count)
    along, across = random.uniform(0.0, 15.0, count), random.uniform(0.0, 20.0, count)
    across[k % 4 == 0] = 0.0
    along[k % 4 == 1] = 0.0
    along[::8], across[::8] = 0.0, 0.0
    along = np.where(k % 3 == 2, -along, along)
    return list(zip(omega.tolist(), along.tolist(), across.tolist(), strict=True))


def solved(
    model: pm.Model, section: Section, motion: tuple[float, ...]
) -> tuple[dict[str, Any], LiteralRotor]:
    """The nodes of the core, and the literal rotor on the same branch of the wake."""
    found = pm.Rotor(model)._core.solution(along_and_across(*motion).rows)
    blade, law, names = model.propeller, model.airfoil, [name_of(c) for c in model.corrections]
    wake = LiteralWake(
        *(RHO, *motion, blade.blades, blade.radius),
        tip_loss="tip-loss" in names,
        hub_radius=blade.root if "hub-loss" in names else None,
        windmill=found["windmill"],
    )
    shape = (blade.station, blade.chord, blade.twist, blade.blades, section, wake, (0.0, 0.0))
    angle = law.zero_lift_angle if isinstance(law, pm.Airfoil) else 0.0
    return found, LiteralRotor(*shape, RHO, MU, *motion, angle, 24, 0.004)


def half_turn(azimuths: int) -> tuple[Array, Array]:
    """Nodes [rad] midway between the two sides, each sine once, and their weights."""
    if azimuths <= 2:
        return np.zeros(1), np.ones(1)
    psi = -0.5 * np.pi + 2.0 * np.pi * (np.arange(azimuths // 2) + 0.5) / azimuths
    return psi, np.full(psi.size, 1.0 / psi.size)


def is_root(
    rotor: LiteralRotor, y: float, v_i: float, azimuth: tuple[Array, Array], within: float
) -> bool:
    """Whether the residual changes its sign at ``v_i``, give or take ``within`` [m/s]."""
    below, above = rotor.residual(y, v_i + np.array([-within, within]), azimuth)
    return bool(below * above < 0.0)


def is_largest(
    rotor: LiteralRotor, y: float, v_i: float, azimuth: tuple[Array, Array], within: float
) -> bool:
    """Whether momentum prevails above ``v_i``, by a scan in even steps of v_i and of its angle."""
    turning = rotor.omega * y
    low, speed = v_i + within, turning + abs(rotor.v_axial) + rotor.v_inplane
    angles = np.arange(np.arctan2(rotor.v_axial + low, turning), 1.45, 0.0019)
    grid = np.union1d(
        turning * np.tan(angles) - rotor.v_axial, np.arange(low, 2.0 * speed, speed / 430.0)
    )
    return bool((rotor.residual(y, grid, azimuth) < 0.0).all())


@pytest.mark.parametrize(
    ("name", "low", "high"), [("soft", 0.0328, 0.0353), ("apc", 0.0350, 0.0362)]
)
def test_an_edge_of_panels_lies_where_the_band_of_three_roots_ends(
    name: str, low: float, high: float
) -> None:
    """The attached branch begins at the band's inner end [m], and there the inflow jumps."""
    omega = 6000.0 * np.pi / 30.0
    model = pm.Model(BLADE, airfoil_of(SECTIONS[name]))
    found, plain = solved(model, SECTIONS[name], (omega, 0.0, 0.0))
    roots = []
    for y in (low - 0.001, 0.5 * (low + high), high + 0.001):
        values = plain.residual(y, np.linspace(-omega * y, omega * y, 8001), half_turn(1))
        roots.append(int((values[:-1] * values[1:] < 0.0).sum()))
    assert roots == [1, 3, 1]
    rotor = pm.Rotor(model)
    edge = found["edges"][0][found["folds"].index("fold")]
    assert edge == pytest.approx(low, abs=1e-4)
    assert int(rotor.loads(omega, 0.0, 0.0).roots) == 3
    inside, outside = rotor.inflow(omega, 0.0, 0.0, radius=[edge - 1e-6, edge + 1e-6]).inflow
    assert outside - inside > 0.1


def nodes(found: dict[str, Any], chosen: Any) -> Iterator[tuple[float, float, Any]]:
    """Radius, inflow and azimuths of the chosen nodes."""
    for k in chosen:
        yield float(found["nodes"][0][k]), float(found["nodes"][1][k]), half_turn(found["azimuths"])


@pytest.mark.parametrize("name", CASES)
def test_inflow_is_the_largest_of_all_roots(name: str) -> None:
    section, law, texts = CASES[name]
    model = pm.Model(BLADE, law, corrections=tuple(map(pm.correction, texts)))
    random, states = np.random.default_rng(3), set()
    for count, motion in enumerate(points(13, 8)):
        found, rotor = solved(model, section, motion)
        states.add((motion[1] < 0.0, found["windmill"]))
        radius = found["nodes"][0]
        free = np.flatnonzero((radius > BLADE.root + HELD) & (radius < BLADE.radius - HELD))
        assert (np.diff(found["edges"][0]) > 0.0).all()
        assert found["edges"][0, [0, -1]] == pytest.approx([BLADE.root, BLADE.radius], rel=1e-14)
        for at in nodes(found, (*random.choice(free, 2), free[0], free[-1])[: 3 + count % 2]):
            within = 1e-8 * (motion[0] * at[0] + abs(motion[1]))
            assert is_root(rotor, *at, within) and is_largest(rotor, *at, within), (motion, at[0])
    assert states == {(False, False), (True, False), (True, True)}


def test_inflow_beside_the_hub_is_the_largest_of_all_roots() -> None:
    model = pm.Model(BLADE, SOFT, corrections=(pm.correction("hub-loss"),))
    found, rotor = solved(model, SECTIONS["soft"], (262.6545839714763, 0.0, 6.218851813681983))
    (at,) = nodes(found, [0])
    within = 1e-8 * abs(at[1])
    assert is_root(rotor, *at, within) and is_largest(rotor, *at, within)


SHARP = pm.Airfoil(
    *(5.093, 0.0, 1.709, 0.4317), zero_lift_angle=-0.0706, c_d0=0.058, sharpness=127.8
)
SHARP_FLOW = (725.2998769486707, 3.1494169078806236, 19.10897435601218)
"""From 0.047 m on the largest root is that of attached flow."""


@pytest.mark.parametrize(
    ("one", "flows", "some"),
    [
        *((one, list(zip(*other_flow(4, 1000), strict=True)), 3) for one in other_rotors(4, 1000)),
        (OtherRotor("apc-11x7e", 3, SHARP), [SHARP_FLOW], 40),
    ],
)
def test_other_laws_have_the_largest_root_too(one: OtherRotor, flows: Any, some: int) -> None:
    """At random nodes.

    The core may take two folds for one if they are so close together that no load shows it; the
    inflow between them is a smaller root.
    """
    blade, law, random = one.propeller(), one.airfoil, np.random.default_rng(1)
    names = ("c_l1", "c_l2", "c_d", "alpha_0", "c_d0", "c_p")
    section = {n: getattr(law, n) for n in names} | {"M": law.sharpness}
    for motion in flows:
        found, rotor = solved(pm.Model(blade, law), section, tuple(map(float, motion)))
        folds = found["edges"][0][np.array(found["folds"]) == "fold"]
        for at in nodes(found, random.integers(0, found["nodes"][0].size, some)):
            within = 1e-7 * motion[0] * at[0]
            assert is_root(rotor, *at, within), (motion, at[0])
            if np.abs(folds - at[0]).min(initial=np.inf) > 5e-4 * blade.radius:
                assert is_largest(rotor, *at, within), (motion, at[0])
