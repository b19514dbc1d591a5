"""WISDEM's CCBlade, configured for a propeller, for `python -m benchmarks.peers`.

CCBlade applies blade element momentum theory to wind turbines.  In yawed flow, it solves each
azimuth sector independently.  The angle of attack of a turbine is the inflow angle minus the twist;
that of a propeller is the twist minus the inflow angle.  The section law is therefore mirrored,
C_l(a) -> -C_l(-a), C_d(a) -> C_d(-a).  Twist and direction of rotation are unchanged.  A climb is a
positive wind speed in CCBlade, and thrust and torque have the opposite sign.  Effects that the
paper's theory does not contain are switched off: tip loss, hub loss, rotation of the wake, and
CCBlade's default wind shear.  In axial flow, both tools then solve the same equations, except that
CCBlade uses one Reynolds number for the skin friction of all sections.
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
"""Speed [rad/s] and y/R at which the Reynolds number of the section table is computed."""

ANGLES = 7201
"""Number of angles in the section table.  CCBlade smooths the table.  With this many
angles, smoothing changes the coefficients little."""


class Grid(NamedTuple):
    """Stations along the blade, and sectors of the disk in yawed flow, 1 in axial flow."""

    stations: int
    sectors: int


REFERENCE = Grid(960, 72)
"""Grid of the reference.  In oblique flow, errors decrease slowly with the number of stations,
because stall begins between stations."""


def ccblade_module() -> Any:
    """Return CCBlade's module, or raise ``ModuleNotFoundError`` without WISDEM.

    ``import wisdem`` would load all of WISDEM and about ninety packages, of which CCBlade requires
    only NumPy and SciPy.  This function therefore does not run the ``__init__`` of the package.
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
        """Return CCBlade's rotor at an angle beta [rad] between axis and flow.

        Stations are dense at root and tip, because CCBlade sets the load to zero there.
        Equally spaced stations have errors that are several times as large.
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
    """Return thrust [N] and torque [N m], or NaN if CCBlade finds no solution.

    CCBlade then returns zero, with or without a warning.
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
    """Return CCBlade's thrust and torque divided by propmap's."""
    thrust, torque = thrust_torque(peer.model(grid, point[2]), point)
    ours = peer.rotor.loads(*point)
    return {"thrust": float(thrust / ours.thrust), "torque": float(torque / ours.torque)}


def evaluate_seconds(model: Any, point: Point) -> float:
    """Return the median time of one evaluation [s]."""
    omega, speed, _ = point
    return median_seconds(lambda: model.evaluate([speed], [omega / RPM], [0.0]), 3)


def ladder(
    peer: CCBladePropeller, grids: list[Grid], points: list[Point], static: Floats
) -> dict[Grid, Floats]:
    """Return errors (points,) of the thrust of each grid, divided by ``static`` [N]."""

    def thrust(grid: Grid) -> Floats:
        return np.array([thrust_torque(peer.model(grid, p[2]), p)[0] for p in points])

    sectors = REFERENCE.sectors if grids[0].sectors > 1 else 1
    truth = thrust(REFERENCE._replace(sectors=sectors))
    return {grid: np.abs(thrust(grid) - truth) / static for grid in grids}


def largest(errors: Floats) -> float | None:
    """Return the largest error, or None if CCBlade did not find all loads."""
    return float(errors.max()) if np.isfinite(errors).all() else None


def choose(errors: dict[Grid, Floats], allowed: float) -> tuple[Grid, bool]:
    """Return the cheapest grid within the allowed error, or else the most accurate one.

    Also return whether the error is within the allowed one.
    """
    good = [grid for grid, off in errors.items() if off.max() <= allowed]
    if good:
        return min(good, key=lambda grid: grid.stations * grid.sectors), True
    return min(errors, key=lambda grid: float(np.nan_to_num(errors[grid], nan=np.inf).max())), False
