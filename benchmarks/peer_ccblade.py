"""WISDEM's CCBlade set up as a propeller, for `python -m benchmarks.peers`.

CCBlade is blade-element momentum theory of wind turbines; where the rotor is yawed it solves each
azimuth sector by itself.  A turbine's angle of attack is the inflow angle less the twist, a
propeller's the twist less the inflow angle.  So the section law goes in mirrored,
C_l(a) -> -C_l(-a), C_d(a) -> C_d(-a); twist and sense of rotation stay, climb is wind from ahead,
and the propeller's thrust and torque are CCBlade's with the sign reversed.  What the paper's
theory has not is off: losses at tip and hub, rotation of the wake, and the wind shear that CCBlade
has by default.  In axial flow both then solve the same equations, but for the friction's Reynolds
number.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
import types
import warnings
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

from benchmarks.speed import RPM, median_seconds
from propmap.rotor import Rotor
from propmap.typing import Floats

Point = tuple[float, float, float]
"""omega [rad/s], speed [m/s], beta [rad]."""

NOMINAL_OMEGA, NOMINAL_SHARE = 6000.0 * RPM, 0.75
"""[rad/s], and share of the radius: where the Reynolds number of the section's table is taken."""

ANGLES = 7201
"""Points of the section's table: CCBlade smooths it by a sum of squares, with so many by little."""


class Grid(NamedTuple):
    """Stations along the blade, and sectors of the disk in yawed flow, 1 in axial flow."""

    stations: int
    sectors: int


REFERENCE = Grid(960, 72)
"""CCBlade's error falls slowly and unevenly in oblique flow: stall begins between two stations."""


def ccblade_module() -> Any:
    """CCBlade's module; ``ModuleNotFoundError`` without WISDEM.

    ``import wisdem`` would load all of WISDEM and some ninety packages, of which CCBlade needs
    none but NumPy and SciPy; so the package is entered without running its ``__init__``.
    """
    if "wisdem" not in sys.modules:
        found = importlib.util.find_spec("wisdem")
        if found is None:
            raise ModuleNotFoundError("wisdem is not installed: run `make bench ONLY=peers`")
        package = types.ModuleType("wisdem")
        package.__path__ = list(found.submodule_search_locations or [])
        sys.modules["wisdem"] = package
    return importlib.import_module("wisdem.ccblade.ccblade")


class CCBladePropeller:
    """A rotor's propeller, section law and air in CCBlade."""

    def __init__(self, rotor: Rotor) -> None:
        self.rotor = rotor
        self.module = ccblade_module()
        blade, air = rotor.model.propeller, rotor.model.air
        place = NOMINAL_SHARE * blade.radius
        chord = float(PchipInterpolator(blade.station, blade.chord)(place))
        self.reynolds = air.density * NOMINAL_OMEGA * place * chord / air.viscosity
        degrees = np.linspace(-180.0, 180.0, ANGLES)
        law: Any = rotor.model.airfoil
        lift, drag = law.coefficients(-np.radians(degrees), self.reynolds)
        self.foil = self.module.CCAirfoil(degrees, [self.reynolds], -lift, drag)

    def model(self, grid: Grid, beta: float, *, derivatives: bool = False) -> Any:
        """CCBlade's rotor at an angle to the flow, beta [rad].

        Stations are closest at root and tip, where CCBlade's integral runs out to zero load;
        evenly spaced ones have several times the error.
        """
        blade, air = self.rotor.model.propeller, self.rotor.model.air
        turn = np.pi * np.arange(1, grid.stations + 1) / (grid.stations + 1)
        radius = blade.root + (blade.radius - blade.root) * 0.5 * (1.0 - np.cos(turn))
        chord, twist = (
            PchipInterpolator(blade.station, shape)(radius) for shape in (blade.chord, blade.twist)
        )
        return self.module.CCBlade(
            radius,
            chord,
            np.degrees(twist),
            [self.foil] * grid.stations,
            blade.root,
            blade.radius,
            B=blade.blades,
            rho=air.density,
            mu=air.viscosity,
            yaw=float(np.degrees(beta)),
            shearExp=0.0,
            nSector=grid.sectors,
            tiploss=False,
            hubloss=False,
            wakerotation=False,
            derivatives=derivatives,
        )


def thrust_torque(model: Any, point: Point) -> tuple[float, float]:
    """Thrust [N] and torque [N m]; NaN where CCBlade has none.

    It leaves the load at zero, with or without a warning, where it finds none.
    """
    omega, speed, _ = point
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        loads, _ = model.evaluate([speed], [omega / RPM], [0.0])
    thrust, torque = -float(loads["T"][0]), -float(loads["Q"][0])
    if told or thrust == 0.0:
        return float("nan"), float("nan")
    return thrust, torque


def over_package(peer: CCBladePropeller, grid: Grid, point: Point) -> dict[str, float]:
    """CCBlade's thrust and torque over the package's."""
    thrust, torque = thrust_torque(peer.model(grid, point[2]), point)
    ours = peer.rotor.loads(*point)
    return {"thrust": float(thrust / ours.thrust), "torque": float(torque / ours.torque)}


def evaluate_seconds(model: Any, point: Point) -> float:
    """Median time of one evaluation."""
    omega, speed, _ = point
    return median_seconds(lambda: model.evaluate([speed], [omega / RPM], [0.0]), 3)


def ladder(
    peer: CCBladePropeller, grids: list[Grid], points: list[Point], static: Floats
) -> dict[Grid, Floats]:
    """Errors (points,) of the thrust against ``REFERENCE``, shares of the thrusts static [N]."""

    def thrust(grid: Grid) -> Floats:
        return np.array([thrust_torque(peer.model(grid, p[2]), p)[0] for p in points])

    sectors = REFERENCE.sectors if grids[0].sectors > 1 else 1
    truth = thrust(REFERENCE._replace(sectors=sectors))
    return {grid: np.abs(thrust(grid) - truth) / static for grid in grids}


def largest(errors: Floats) -> float | None:
    """The largest of the errors; None where some load was not found."""
    return float(errors.max()) if np.isfinite(errors).all() else None


def choose(errors: dict[Grid, Floats], allowed: float) -> tuple[Grid, bool]:
    """The cheapest grid within the allowed error, or else the best; and whether it is within."""
    good = [grid for grid, off in errors.items() if off.max() <= allowed]
    if good:
        return min(good, key=lambda grid: grid.stations * grid.sectors), True
    return min(errors, key=lambda grid: float(np.nan_to_num(errors[grid], nan=np.inf).max())), False
