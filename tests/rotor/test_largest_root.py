"""The inflow at the nodes is the largest root of (11), against scans that share no code with it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import propmap as pm
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
    "strong stall delay": (SECTIONS["soft"], SOFT, ("stall-delay:strength=12",)),
    "slow sound": (SECTIONS["soft"], SOFT, ("prandtl-glauert:sound_mps=150",)),
}
HELD = 2e-4
"""[m] from tip and hub, in which Prandtl's factor approaches zero."""


@dataclass(frozen=True)
class LiteralCorrected(LiteralRotor):
    """The literal rotor with Snel's stall delay and Prandtl and Glauert's rule, as printed."""

    strength: float = 0.0  # factor of (c/y)^2
    sound: float = np.inf  # [m/s]

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
        # M^2 is limited smoothly between 0.36 and 0.49.
        held = np.clip(square, 0.0, 0.62)
        held = held - np.maximum(held - 0.36, 0.0) ** 2 / (2.0 * 0.26)
        return phi, lift / np.sqrt(1.0 - held), drag


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


def literal(
    section: Section, texts: tuple[str, ...], motion: tuple[float, ...], windmill: bool
) -> LiteralRotor:
    """The rotor on the same branch of the wake."""
    wake = LiteralWake(
        RHO,
        *motion,
        BLADE.blades,
        BLADE.radius,
        tip_loss="tip-loss" in texts,
        hub_radius=BLADE.root if "hub-loss" in texts else None,
        windmill=windmill,
    )
    blade = (BLADE.station, BLADE.chord, BLADE.twist, BLADE.blades)
    air = (RHO, MU, *motion, 0.0, 24, 0.004)
    numbers = {text.partition(":")[0]: float(text.partition("=")[2] or 0.0) for text in texts}
    more = (numbers.get("stall-delay", 0.0), numbers.get("prandtl-glauert", np.inf))
    return LiteralCorrected(*blade, section, wake, (0.0, 0.0), *air, *more)


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


@pytest.mark.parametrize("name", CASES)
def test_inflow_is_the_largest_of_all_roots(name: str) -> None:
    section, law, texts = CASES[name]
    corrections = tuple(pm.correction(text) for text in texts)
    core = pm.Rotor(pm.Model(BLADE, law, corrections=corrections))._core
    random, states = np.random.default_rng(3), set()
    for count, motion in enumerate(points(13, 8)):
        found = core.solution(along_and_across(*motion).rows)
        states.add((motion[1] < 0.0, found["windmill"]))
        rotor = literal(section, texts, motion, found["windmill"])
        azimuth = half_turn(found["azimuths"])
        radius, inflow = found["radius"], found["inflow"]
        free = np.flatnonzero((radius > BLADE.root + HELD) & (radius < BLADE.radius - HELD))
        assert (np.diff(found["edge"]) > 0.0).all()
        assert found["edge"][[0, -1]] == pytest.approx([BLADE.root, BLADE.radius], rel=1e-14)
        for k in (*random.choice(free, 2), free[0], free[-1])[: 3 + count % 2]:
            at = float(radius[k]), float(inflow[k]), azimuth
            within = 1e-8 * (motion[0] * at[0] + abs(motion[1]))
            assert is_root(rotor, *at, within) and is_largest(rotor, *at, within), (motion, at[0])
    assert states == {(False, False), (True, False), (True, True)}


def test_inflow_beside_the_hub_is_the_largest_of_all_roots() -> None:
    model = pm.Model(BLADE, SOFT, corrections=(pm.correction("hub-loss"),))
    motion = (262.6545839714763, 0.0, 6.218851813681983)
    found = pm.Rotor(model)._core.solution(along_and_across(*motion).rows)
    rotor = literal(SECTIONS["soft"], ("hub-loss",), motion, windmill=False)
    v_i = float(found["inflow"][0])
    at = float(found["radius"][0]), v_i, half_turn(found["azimuths"]), 1e-8 * abs(v_i)
    assert is_root(rotor, *at) and is_largest(rotor, *at)


@pytest.mark.parametrize(
    ("name", "low", "high"), [("soft", 0.0328, 0.0353), ("apc", 0.0350, 0.0362)]
)
def test_an_edge_of_panels_lies_where_the_band_of_three_roots_ends(
    name: str, low: float, high: float
) -> None:
    """The attached branch begins at the band's inner end [m], and there the inflow jumps."""
    omega = 6000.0 * np.pi / 30.0
    plain = literal(SECTIONS[name], (), (omega, 0.0, 0.0), windmill=False)
    roots = []
    for y in (low - 0.001, 0.5 * (low + high), high + 0.001):
        values = plain.residual(y, np.linspace(-omega * y, omega * y, 8001), half_turn(1))
        roots.append(int((values[:-1] * values[1:] < 0.0).sum()))
    assert roots == [1, 3, 1]
    rotor = pm.Rotor(pm.Model(BLADE, airfoil_of(SECTIONS[name])))
    found = rotor._core.solution(along_and_across(omega, 0.0, 0.0).rows)
    edge = found["edge"][found["fold"].index("fold")]
    assert edge == pytest.approx(low, abs=1e-4)
    assert int(rotor.loads(omega, 0.0, 0.0).roots) == 3
    inside, outside = rotor.inflow(omega, 0.0, 0.0, radius=[edge - 1e-6, edge + 1e-6]).inflow
    assert outside - inside > 0.1


@pytest.mark.parametrize("one", other_rotors(4, seed=1000), ids=lambda one: one.blade)
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

    The core may take two folds for one if they are so close together that no load shows it; the
    inflow between them is a smaller root.
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
        folds = found["edge"][np.array(found["fold"]) == "fold"]
        azimuth = half_turn(found["azimuths"])
        for k in random.integers(0, found["radius"].size, some):
            y, v_i = float(found["radius"][k]), float(found["inflow"][k])
            at = y, v_i, azimuth, 1e-7 * motion[0] * y
            assert is_root(rotor, *at), (motion, y)
            if np.abs(folds - y).min(initial=np.inf) > 5e-4 * blade.radius:
                assert is_largest(rotor, *at), (motion, y)
