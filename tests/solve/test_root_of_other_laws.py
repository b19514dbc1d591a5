"""The search finds the largest root of (11) of tabulated sections and with losses, too."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import propmap as pm
from propmap.arrays.namespace import by_numpy
from propmap.engine.rotor_arrays import rotor_arrays
from propmap.physics.velocities import azimuth_nodes
from propmap.solve.problem import Case, annulus_problem
from propmap.solve.root import MAX_STEPS, search
from tests.oracle.literal_rotor import LiteralRotor
from tests.oracle.literal_section import LiteralTable, Section
from tests.oracle.literal_wake import LiteralWake
from tests.oracle.naca_0015 import FILE, naca_0015
from tests.oracle.points import MU, RHO, SECTIONS
from tests.physics.paper_physics import TABLE_I
from tests.physics.sections.sampled import sampled

AZIMUTHS = 16
V_HOVER = 5.0
BLADE = pm.propeller("apc-8x6e")
COARSE = sampled(TABLE_I["soft"], 2.5, 10.0, np.geomspace(1e4, 4e5, 4))

LAWS: dict[str, tuple[str, Any, tuple[str, ...]]] = {
    "naca-0015": ("naca-0015", None, ()),
    "coarse table": ("table", COARSE, ()),
    "tip loss": ("apc", pm.airfoil("paper-apc"), ("tip-loss",)),
    "hub loss": ("soft", pm.airfoil("paper-soft"), ("hub-loss",)),
    "table and both losses": ("table", COARSE, ("tip-loss", "hub-loss")),
}


def points(count: int, seed: int) -> tuple[np.ndarray, ...]:
    """Radii [m], omega [rad/s], V cos(beta) and V sin(beta) [m/s], every third in descent.

    Some are close to tip and hub, but not where Prandtl's factor is held (``LEAST_REACH``).
    """
    random, k = np.random.default_rng(seed), np.arange(count)
    low, high = BLADE.root, BLADE.radius
    radius = low + (high - low) * random.uniform(0.0, 1.0, count)
    radius[:6] = high - (high - low) * 10.0 ** np.linspace(-1.5, -4.0, 6)
    radius[6:12] = low + (high - low) * 10.0 ** np.linspace(-1.5, -4.0, 6)
    omega = random.uniform(150.0, 900.0, count)
    along, across = random.uniform(0.0, 15.0, count), random.uniform(0.0, 20.0, count)
    across[k % 4 == 0] = 0.0
    along[k % 4 == 1] = 0.0
    return radius, omega, np.where(k % 3 == 2, -along, along), across


def literal(section: Section, losses: tuple[str, ...], motion: tuple[float, ...]) -> LiteralRotor:
    along = motion[1]
    wake = LiteralWake(
        RHO,
        *motion,
        BLADE.blades,
        BLADE.radius,
        tip_loss="tip-loss" in losses,
        hub_radius=BLADE.root if "hub-loss" in losses else None,
        windmill=along < -0.95 * V_HOVER,
    )
    blade = (BLADE.station, BLADE.chord, BLADE.twist, BLADE.blades)
    air = (RHO, MU, *motion, 0.0, AZIMUTHS, 0.004)
    return LiteralRotor(*blade, section, wake, (0.0, 0.0), *air)


def largest_root(rotor: LiteralRotor, y: float) -> float:
    """By a scan in even steps of v_i and of the inflow angle; the nodes are the package's."""
    nodes = azimuth_nodes(AZIMUTHS)
    azimuth = (np.arcsin(np.asarray(nodes.sines)), np.full(AZIMUTHS // 2, 2.0 / AZIMUTHS))
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
    kind, law, losses = LAWS[name]
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
    corrections = tuple(pm.correction(text) for text in losses)
    arrays = rotor_arrays(pm.Model(BLADE, law, corrections=corrections))
    radius, *flow = points(60, 8)
    with by_numpy():
        case = Case(arrays, *flow, np.full(radius.size, V_HOVER))
        problem = annulus_problem(case, radius[None])
        ended = search(problem, np.array(MAX_STEPS), azimuth_nodes(AZIMUTHS))
    assert ended.found.all()
    for k, v_i in enumerate(ended.inflow[0]):
        motion = tuple(float(a[k]) for a in flow)
        want = largest_root(literal(section, losses, motion), float(radius[k]))
        speed = motion[0] * radius[k] + abs(motion[1])
        assert v_i == pytest.approx(want, abs=1e-8 * speed), f"point {k}"
