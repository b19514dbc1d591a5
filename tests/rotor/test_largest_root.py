"""The inflow at the nodes is the largest root of (11), against scans that share no code with it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

import propmap as pm
from propmap.operating_points import along_and_across
from tests.oracle.literal_rotor import LiteralRotor
from tests.oracle.literal_section import Array, LiteralTable, Section
from tests.oracle.literal_wake import LiteralWake
from tests.oracle.naca_0015 import FILE, naca_0015
from tests.oracle.paper_physics import MU, RHO, TABLE_I, Law
from tests.oracle.points import SECTIONS
from tests.oracle.sampled import sampled
from tests.other_laws import OtherRotor, other_flow, other_rotors

BLADE = pm.propeller("apc-8x6e")
COARSE = sampled(TABLE_I["soft"], 2.5, 10.0, np.geomspace(1e4, 4e5, 4))

LAWS: dict[str, tuple[str, Any, tuple[str, ...]]] = {
    "naca-0015": ("naca-0015", None, ()),
    "coarse table": ("table", COARSE, ()),
    "tip loss": ("apc", pm.airfoil("paper-apc"), ("tip-loss",)),
    "hub loss": ("soft", pm.airfoil("paper-soft"), ("hub-loss",)),
    "table and both losses": ("table", COARSE, ("tip-loss", "hub-loss")),
    "soft": ("soft", pm.airfoil("paper-soft"), ()),
    "apc": ("apc", pm.airfoil("paper-apc"), ()),
    "stiff": ("stiff", pm.airfoil("paper-stiff"), ()),
    "stall delay": ("soft", pm.airfoil("paper-soft"), ("stall-delay",)),
    "strong stall delay": ("soft", pm.airfoil("paper-soft"), ("stall-delay:strength=12",)),
    "slow sound": ("soft", pm.airfoil("paper-soft"), ("prandtl-glauert:sound_mps=150",)),
}
HELD = 2e-4
"""[m] from tip and hub, in which Prandtl's factor goes to nothing."""

STRENGTH = {"stall delay": 3.0, "strong stall delay": 12.0}
"""Factor of (c/y)^2."""


@dataclass(frozen=True)
class LiteralCorrected(LiteralRotor):
    """The literal rotor with Snel's stall delay and Prandtl and Glauert's rule, as printed."""

    strength: float = 0.0
    sound: float = np.inf

    def element(self, y: float, v_i: Array, psi: Array) -> tuple[Array, Array, Array]:
        """Inflow angle, lift and drag per radius as before, with the lift corrected."""
        phi, lift, drag = super().element(y, v_i, psi)
        c, theta = (float(f(y)) for f in self.shape)
        speed = np.hypot(self.omega * y + self.v_inplane * np.sin(psi), self.v_axial + v_i[:, None])
        pressure = 0.5 * self.rho * speed**2 * c
        alpha = np.arctan2(np.sin(theta - phi), np.cos(theta - phi))
        if self.strength > 0.0:
            past = np.clip((np.abs(alpha) - np.pi / 6.0) / (np.pi / 6.0), 0.0, 1.0)
            share = min(self.strength * (c / y) ** 2, 1.0) * 0.5 * (1.0 + np.cos(np.pi * past))
            assert isinstance(self.section, dict)
            lift = lift + share * (pressure * self.section["c_l1"] * alpha - lift)
        square = (speed / self.sound) ** 2
        # M^2 goes over smoothly from 0.36 to 0.49.
        held = np.clip(square, 0.0, 0.62)
        held = held - np.maximum(held - 0.36, 0.0) ** 2 / (2.0 * 0.26)
        return phi, lift / np.sqrt(1.0 - held), drag


def points(count: int, seed: int) -> tuple[np.ndarray, ...]:
    """Omega [rad/s], V cos(beta) and V sin(beta) [m/s], every third in descent."""
    random, k = np.random.default_rng(seed), np.arange(count)
    omega = random.uniform(150.0, 900.0, count)
    along, across = random.uniform(0.0, 15.0, count), random.uniform(0.0, 20.0, count)
    across[k % 4 == 0] = 0.0
    along[k % 4 == 1] = 0.0
    along[::8], across[::8] = 0.0, 0.0
    return omega, np.where(k % 3 == 2, -along, along), across


def literal(
    name: str, section: Section, losses: tuple[str, ...], motion: tuple[float, ...], windmill: bool
) -> LiteralRotor:
    """The rotor on the same branch of the wake."""
    wake = LiteralWake(
        RHO,
        *motion,
        BLADE.blades,
        BLADE.radius,
        tip_loss="tip-loss" in losses,
        hub_radius=BLADE.root if "hub-loss" in losses else None,
        windmill=windmill,
    )
    blade = (BLADE.station, BLADE.chord, BLADE.twist, BLADE.blades)
    air = (RHO, MU, *motion, 0.0, 24, 0.004)
    more = (STRENGTH.get(name, 0.0), 150.0 if name == "slow sound" else np.inf)
    return LiteralCorrected(*blade, section, wake, (0.0, 0.0), *air, *more)


def half_turn(azimuths: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes [rad] midway between the two sides, each sine once, and their weights."""
    if azimuths <= 2:
        return np.zeros(1), np.ones(1)
    psi = -0.5 * np.pi + 2.0 * np.pi * (np.arange(azimuths // 2) + 0.5) / azimuths
    return psi, np.full(psi.size, 1.0 / psi.size)


def largest_root(rotor: LiteralRotor, y: float, azimuth: tuple[np.ndarray, np.ndarray]) -> float:
    """By a scan in even steps of v_i and of the inflow angle."""
    turning = rotor.omega * y
    angles = turning * np.tan(np.linspace(-1.45, 1.45, 1500)) - rotor.v_axial
    speed = turning + abs(rotor.v_axial) + rotor.v_inplane
    grid = np.union1d(angles, np.linspace(-1.5 * speed, 2.0 * speed, 1500))
    values = rotor.residual(y, grid, azimuth)
    assert values[-1] < 0.0  # the momentum prevails at the top
    k = int(np.flatnonzero((values[:-1] > 0.0) & (values[1:] <= 0.0))[-1])

    def function(v: float) -> float:
        return float(rotor.residual(y, np.array([v]), azimuth)[0])

    return float(brentq(function, grid[k], grid[k + 1], xtol=1e-13, rtol=1e-14))


@pytest.mark.parametrize("name", LAWS)
def test_inflow_is_the_largest_of_all_roots(name: str) -> None:
    kind, law, texts = LAWS[name]
    section: Section
    if kind == "naca-0015":
        if not FILE.exists():
            pytest.skip(f"{FILE.name} is not beside this checkout")
        section = naca_0015()
        law = pm.SectionTable(section.angle, section.reynolds, section.lift, section.drag)
    elif kind == "table":
        section = LiteralTable(law.angle, law.reynolds, law.lift, law.drag)
    else:
        section = SECTIONS[kind]
    corrections = tuple(pm.correction(text) for text in texts)
    core = pm.Rotor(pm.Model(BLADE, law, corrections=corrections))._core
    random, states = np.random.default_rng(3), set()
    for count, motion in enumerate(zip(*(one.tolist() for one in points(18, 8)), strict=True)):
        found = core.solution(along_and_across(*motion).rows)
        states.add((motion[1] < 0.0, found["windmill"]))
        rotor = literal(name, section, texts, motion, found["windmill"])
        azimuth = half_turn(found["azimuths"])
        radius, inflow = found["radius"], found["inflow"]
        free = np.flatnonzero((radius > BLADE.root + HELD) & (radius < BLADE.radius - HELD))
        assert (np.diff(found["edge"]) > 0.0).all()
        assert found["edge"][[0, -1]] == pytest.approx([BLADE.root, BLADE.radius], rel=1e-14)
        for k in (*random.choice(free, 2), free[0], free[-1])[: 3 + count % 2]:
            y = float(radius[k])
            want = largest_root(rotor, y, azimuth)
            speed = motion[0] * y + abs(motion[1])
            assert inflow[k] == pytest.approx(want, abs=1e-8 * speed), (motion, y)
    assert states == {(False, False), (True, False), (True, True)}


def test_inflow_beside_the_hub_is_the_largest_of_all_roots() -> None:
    model = pm.Model(BLADE, pm.airfoil("paper-soft"), corrections=(pm.correction("hub-loss"),))
    motion = (262.6545839714763, 0.0, 6.218851813681983)
    found = pm.Rotor(model)._core.solution(along_and_across(*motion).rows)
    rotor = literal("", SECTIONS["soft"], ("hub-loss",), motion, windmill=False)
    want = largest_root(rotor, float(found["radius"][0]), half_turn(found["azimuths"]))
    assert found["inflow"][0] == pytest.approx(want, rel=1e-8)


HOVER = 6000.0 * 2.0 * np.pi / 60.0
BANDS = {"soft": (0.0328, 0.0353), "apc": (0.0350, 0.0362)}
"""[m] Where (11) has three roots in hover at 6000 rpm."""


def all_roots(law: Law, y: float) -> list[float]:
    """Every v_i in hover at which the literal residual changes its sign, by a fine scan."""
    section, motion = SECTIONS["soft" if law is TABLE_I["soft"] else "apc"], (HOVER, 0.0, 0.0)
    rotor = literal("", section, (), motion, windmill=False)
    grid = np.linspace(-HOVER * y, HOVER * y, 8001)
    values = rotor.residual(y, grid, half_turn(1))
    changes = np.flatnonzero(values[:-1] * values[1:] < 0.0)
    return [float(grid[k]) for k in changes]


@pytest.mark.parametrize("name", BANDS)
def test_an_edge_of_panels_lies_where_the_band_of_three_roots_ends(name: str) -> None:
    """The attached branch begins at the band's inner end, and there the inflow jumps."""
    law, (low, high) = TABLE_I[name], BANDS[name]
    assert [len(all_roots(law, y)) for y in (low - 0.001, 0.5 * (low + high), high + 0.001)] == [
        1,
        3,
        1,
    ]
    rotor = pm.Rotor(pm.Model(BLADE, pm.airfoil(f"paper-{name}")))
    found = rotor._core.solution(along_and_across(HOVER, 0.0, 0.0).rows)
    edge = found["edge"][found["fold"].index("fold")]
    assert edge == pytest.approx(low, abs=1e-4)
    assert int(rotor.loads(HOVER, 0.0, 0.0).roots) == 3
    inside, outside = rotor.inflow(HOVER, 0.0, 0.0, radius=[edge - 1e-6, edge + 1e-6]).inflow
    assert outside - inside > 0.1


def test_the_simplified_law_and_camber_have_their_root_too() -> None:
    chord, twist = (PchipInterpolator(BLADE.station, v) for v in (BLADE.chord, BLADE.twist))
    for law, more in (
        (pm.airfoil("paper-apc").with_parameters(lift_law="simplified"), {"attached": 0.0}),
        (
            pm.airfoil("paper-apc").with_parameters(zero_lift_angle=-0.07),
            {"zero_lift_angle": -0.07},
        ),
    ):
        own = Law(law.c_l1, law.c_l2, law.c_d, law.alpha_0, **more)
        core = pm.Rotor(pm.Model(BLADE, law))._core
        for motion in zip(*(one.tolist() for one in points(24, 5)), strict=True):
            if motion[1] < 0.0:
                continue
            found = core.solution(along_and_across(*motion).rows)
            y, v = found["radius"][7:8], found["inflow"][7:8]
            psi, weight = half_turn(found["azimuths"])
            grid = np.concatenate([v, np.linspace(v[0] + 1e-3, 3.0 * (v[0] + HOVER * y[0]), 3000)])
            excess = residual(own, (y, chord(y), twist(y)), motion, grid, psi, weight)
            assert abs(excess[0]) < 1e-9 * motion[0] ** 2 * BLADE.radius**3
            assert (excess[1:] < 0.0).all()


def residual(
    law: Law, element: Any, flow: tuple[float, ...], v: Array, psi: Array, weight: Array
) -> Array:
    """(5) minus (10) per density of an annulus."""
    from tests.oracle.paper_physics import forces

    _, v_axial, v_inplane = flow
    blade = BLADE.blades * forces(law, element, flow, v[:, None], np.sin(psi))[0] @ weight
    momentum = 4.0 * np.pi * element[0] * v * np.hypot(v_inplane, v_axial + v)
    return np.asarray(blade - momentum)


@pytest.mark.parametrize("one", other_rotors(8, seed=1000), ids=lambda one: one.blade)
def test_random_laws_have_the_largest_root_too(one: OtherRotor) -> None:
    check_nodes(one.propeller(), one.airfoil, zip(*other_flow(4, 1000), strict=True), 3)


def test_a_sharp_stall_without_lift_past_it_keeps_the_attached_root() -> None:
    """From 0.047 m on the largest root is that of attached flow."""
    law = pm.Airfoil(
        *(5.093, 0.0, 1.709, 0.4317), zero_lift_angle=-0.0706, c_d0=0.058, sharpness=127.8
    )
    motion = (725.2998769486707, 3.1494169078806236, 19.10897435601218)
    check_nodes(pm.propeller("apc-11x7e", blades=3), law, [motion], 40)


def check_nodes(blade: pm.Propeller, law: pm.Airfoil, flows: Iterable[Any], some: int) -> None:
    """Random nodes of each flow have the largest root that a dense scan finds.

    Two folds so close together that no load shows it may be taken for one; the inflow between
    them is a smaller root.
    """
    core, random = pm.Rotor(pm.Model(blade, law))._core, np.random.default_rng(1)
    names = ("c_l1", "c_l2", "c_d", "alpha_0", "c_d0", "c_p")
    section = {n: getattr(law, n) for n in names} | {"M": law.sharpness}
    shape = (blade.station, blade.chord, blade.twist, blade.blades)
    for given in flows:
        motion = tuple(float(v) for v in given)
        found = core.solution(along_and_across(*motion).rows)
        wake = LiteralWake(RHO, *motion, blade.blades, blade.radius, windmill=found["windmill"])
        air = (RHO, MU, *motion, law.zero_lift_angle, 24, 0.004)
        rotor = LiteralRotor(*shape, section, wake, (0.0, 0.0), *air)
        for k in random.integers(0, found["radius"].size, some):
            y, v_i = float(found["radius"][k]), float(found["inflow"][k])
            azimuth = half_turn(found["azimuths"])
            want, folds = (
                largest_root(rotor, y, azimuth),
                found["edge"][np.array(found["fold"]) == "fold"],
            )
            if v_i < want and np.abs(folds - y).min(initial=np.inf) < 5e-4 * blade.radius:
                below, above = rotor.residual(
                    y, v_i + np.array([-1e-7, 1e-7]) * motion[0] * y, azimuth
                )
                assert below * above < 0.0, (motion, y)
            else:
                assert v_i == pytest.approx(want, abs=1e-7 * motion[0] * y), (motion, y)
