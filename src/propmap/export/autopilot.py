"""A vehicle's parameters for the firmware of an autopilot: values, errors, files and a note."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import propmap
from propmap.aircraft.assumptions import assumption_lines, assumptions
from propmap.aircraft.trim import STATUSES, Aircraft
from propmap.catalogue.identified import identified
from propmap.errors import InputError
from propmap.export import find_export
from propmap.export.files import check_folder, filled, vehicle_identifier, write_files
from propmap.export.steady_loads import (
    AXES,
    CLOSE,
    DragComparison,
    InplaneForces,
    check_vehicle,
    fit_drag,
    inplane_forces,
)
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import RPM
from propmap.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class Explained:
    """Parameters of one kind.

    Attributes
    ----------
    title : str
        Their name, with n for the number of a rotor.
    values : dict of str to float or int
        By the names that the firmware knows; whole numbers are int.
    unit : str
        Unit of the values.
    std : float or None
        Their standard deviation, in the unit; None where it is not known.
    meaning, source, holds : str
        The firmware's equation; where it stands; and where the simplification holds.
    """

    title: str
    values: dict[str, float]
    unit: str
    std: float | None
    meaning: str
    source: str
    holds: str


@dataclass(frozen=True)
class ParameterSet:
    """What is written for one use.

    Attributes
    ----------
    suffix : str
        Ending of the file's name, as in "quad_px4.params".
    purpose : str
        In a sentence.
    kinds : list of Explained
        The parameters.
    """

    suffix: str
    purpose: str
    kinds: list[Explained]

    @property
    def values(self) -> dict[str, float]:
        """All parameters by name."""
        return {name: value for kind in self.kinds for name, value in kind.values.items()}


@dataclass(frozen=True)
class NotWritten:
    """Parameters that are not written: by name, and ``why`` in a sentence."""

    name: str
    why: str


@dataclass(frozen=True)
class AutopilotParameters:
    """All that an export says.

    Attributes
    ----------
    firmware : str
        Its name.
    sets : list of ParameterSet
        What is written, a file each.
    left_out : list of NotWritten
        What is not.
    comparisons : list of DragComparison
        The drag model of the firmware beside the full model, along x and y.
    remarks : list of str
        What else to know, a sentence or more each.
    file_text : callable
        The text of a set's file, in the format that the firmware's tools read.
    """

    firmware: str
    sets: list[ParameterSet]
    left_out: list[NotWritten]
    comparisons: list[DragComparison]
    remarks: list[str]
    file_text: Callable[[ParameterSet, Vehicle], str]


Flights = tuple[InplaneForces, InplaneForces]  # level flights of a vehicle along x and y

SPEEDS = np.linspace(1.0, 15.0, 8)  # level flights by default [m/s]


def autopilot_parameters(
    aircraft: Aircraft, target: str, speeds: Floats = SPEEDS
) -> AutopilotParameters:
    """Find a vehicle's parameters for an autopilot.

    Parameters
    ----------
    aircraft : Aircraft
        The vehicle with the loads of its rotors.
    target : str
        One of ``propmap.export.AUTOPILOTS``.
    speeds : ndarray, shape (n,)
        Through the air [m/s], at which the drag model is fitted; at rest nothing is to be seen.  A
        vehicle with one or two rotors that has a wing, or is pulled forward, has none.

    Raises
    ------
    InputError
        For an unknown target, for a vehicle that is no multirotor as the drag models of autopilots
        take it to be, and where too few of the speeds are flown; for such a one with few rotors
        where the target has no model of its propeller, or the full throttle is not known.
    """
    export, vehicle = find_export(target, "autopilot"), aircraft.vehicle
    if len(vehicle.mounts) <= 2 and (vehicle.wing is not None or aircraft.rotors.forward):
        return find_export(target, "pusher").make()(aircraft)
    check_vehicle(vehicle)
    moving = np.asarray(speeds, dtype=np.float64)
    moving = moving[moving > 0.0]
    if moving.size < 2:
        raise InputError("fewer than two speeds above 0", "give two or more, in m/s")
    flights = (inplane_forces(aircraft, "x", moving), inplane_forces(aircraft, "y", moving))
    return export.make()(aircraft, flights)


def export_autopilot(
    aircraft: Aircraft,
    target: str,
    folder: str | os.PathLike[str],
    *,
    speeds: Floats = SPEEDS,
    replace: bool = False,
) -> list[Path]:
    """Write a vehicle's parameters in the autopilot's own format, and a note, all files or none.

    Parameters
    ----------
    aircraft, target, speeds
        As for ``autopilot_parameters``.
    folder, replace
        As for ``propmap.export.export_table``.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    InputError
        As ``autopilot_parameters``, and for a folder that cannot be written to and files that
        exist.
    """
    place, vehicle = Path(folder), aircraft.vehicle
    check_folder(place)
    found = autopilot_parameters(aircraft, target, speeds)
    name = vehicle_identifier(vehicle)
    files = {f"{name}_{part.suffix}": found.file_text(part, vehicle) for part in found.sets}
    files[f"README-{target}.md"] = autopilot_note(found, aircraft)
    return write_files(files, place, replace=replace)


def comment_lines(part: ParameterSet, vehicle: Vehicle, target: str) -> list[str]:
    """Write the head of a parameter file, in lines short enough for ArduPilot's own reader."""
    # AP_Param takes lines of 98 characters and reads what is left over as a line of its own.
    clean = "".join(c if c.isprintable() else "?" for c in vehicle.name)[:50]
    return [
        f"{clean}: {part.purpose}"[:90],
        f"written by propmap {propmap.__version__}; see README-{target}.md for definitions, errors",
    ]


def common_remarks(aircraft: Aircraft, omega: float) -> list[str]:
    """Say what the drag coefficients of an ``aircraft`` have in them and what not, and whether
    ``omega`` [rad/s], of its fastest rotors here, is beyond the data of the section constants."""
    words = assumption_lines(assumptions(aircraft.vehicle, aircraft.loads))
    remarks = [f"{each[:1].upper()}{each[1:]}." for each in words]
    tilted = any(mount.axis[2] < 0.9999 for mount in aircraft.vehicle.mounts)
    if tilted and not aircraft.rotors.forward:
        remarks.append(
            "Rotors are tilted: what their thrust adds along x and y in forward flight is part of "
            "the fitted coefficients."
        )
    loads, blade, rpm = aircraft.loads, aircraft.vehicle.propeller, omega / RPM
    if isinstance(loads, Rotor):
        own, name = identified(blade.name, blade.blades), loads.model.airfoil.name
        if own is not None and own.airfoil.name == name and rpm > own.rpm_high:
            remarks.append(
                f"The section constants are extrapolated: rotors turn at up to {rpm:.0f} rpm for "
                f"these parameters, and the data of the constants end at {own.rpm_high:.0f}."
            )
    return remarks


# -------------------------------------------------------------------------------------------------
# The note beside an autopilot's parameters, in Markdown: definitions, errors, ranges.


def autopilot_note(found: AutopilotParameters, aircraft: Aircraft) -> str:
    """Return a note on what was ``found`` of an ``aircraft``."""
    vehicle, loads = aircraft.vehicle, aircraft.loads
    if isinstance(loads, Rotor):
        law, known = loads.model.law_title, loads.model.uncertainty is not None
    else:
        name = (loads.info.get("airfoil") or {}).get("name", "not stated")
        law, known = f"a table of the section law {name}", loads.content.deviations is not None
    return filled(
        "README-autopilot.md",
        found=found,
        vehicle=vehicle,
        law=law,
        known=known,
        areas=", ".join(f"{area:g}" for area in vehicle.body.drag_area),
        axes=AXES,
        statuses=STATUSES,
        version=propmap.__version__,
        shown=lambda value: f"{value:.5g}",
        degrees=math.degrees,
        zip=zip,
    )


# -------------------------------------------------------------------------------------------------
# The drag model of an autopilot's Kalman filter: its parameters, and what it makes of flights.

SEA_LEVEL = 1.225  # density [kg/m^3] at which both PX4 and ArduPilot define the drag of the rotors
STEP = 1e-4  # share by which a velocity is changed in a difference quotient


def where_it_holds(comparisons: list[DragComparison]) -> str:
    """Say where the drag model of a filter is close to the full model."""
    parts = []
    for comparison in comparisons:
        run = comparison.holds
        where = AXES[comparison.flight.axis]
        worst = float(abs(comparison.filtered - comparison.full).max())
        if run is None:
            parts.append(f"{where}: nowhere within {CLOSE:.0%}, the error is up to {worst:.2g} N")
        else:
            parts.append(
                f"{where} within {CLOSE:.0%} of the force from {run[0]:g} to {run[1]:g} m/s, over "
                f"all speeds within {worst:.2g} N"
            )
    return f"In level flight, {'; '.join(parts)}."


@dataclass(frozen=True)
class DragFilter:
    """The equation of a filter along a body axis: specific force against the motion = M (rho /
    1.225)^power v + 1/2 rho v s / B, s being v or the size of the whole velocity."""

    momentum: str  # name of M [1/s]
    ballistic: str  # name of B [kg/m^2], but for the axis
    power: float  # of the density's ratio
    whole: bool  # whether s is the size of the whole velocity
    largest: float  # B beyond which there is no body drag [kg/m^2]
    source: str  # where the equation stands
    between: str  # what the filter does in flight between the axes, in words

    def parameters(
        self, flights: Flights, vehicle: Vehicle
    ) -> tuple[list[Explained], list[DragComparison]]:
        """Fit the parameters, and compare the flights with what the filter makes of them."""
        density = vehicle.air.density
        scale = float((density / SEA_LEVEL) ** self.power)
        constants, errors = fit_drag(
            flights, lambda one: self._square(one.along, one.through), density, 1.0 / self.largest
        )
        rotors, *bodies = constants.tolist()
        momentum, values = round(rotors / scale, 6), {}
        for axis, inverse in zip("XY", bodies, strict=True):
            values[self.ballistic + axis] = round(1.0 / inverse, 4) if inverse else 0.0
        std = np.sqrt(np.sum(errors**2, axis=0)).tolist() if errors.size else None
        comparisons = [
            self._comparison(flight, vehicle, momentum * scale, ballistic)
            for flight, ballistic in zip(flights, values.values(), strict=True)
        ]
        slope = flights[0].force[0] / flights[0].along[0] / scale
        ratio = "sqrt(rho / 1.225 kg/m^3)" if self.power == 0.5 else "(rho / 1.225 kg/m^3)"
        kinds = [
            Explained(
                title=self.momentum,
                values={self.momentum: momentum},
                unit="1/s",
                std=None if std is None else std[0] / scale,
                meaning=(
                    f"Specific force against the motion, along x and y alike: {self.momentum} "
                    f"{ratio} v, v the component of the velocity through the air. It is what the "
                    "rotors add, linear in the speed; below 0.001 the filter leaves it out."
                ),
                source=self.source,
                holds=(
                    f"{where_it_holds(comparisons)} At {flights[0].speed[0]:g} m/s alone it would "
                    f"be {slope:.4f}."
                ),
            )
        ]
        size = "v |V|" if self.whole else "v^2"
        whole = ", |V| the size of it all" if self.whole else ""
        for k, ((name, value), inverse) in enumerate(zip(values.items(), bodies, strict=True)):
            kinds.append(
                Explained(
                    title=name,
                    values={name: value},
                    unit="kg/m^2",
                    std=None if std is None or not inverse else std[1 + k] / inverse**2,
                    meaning=(
                        f"Specific force along {'xy'[k]} against the motion: 1/2 rho {size} / "
                        f"{name}, v the component of the velocity along the axis{whole}"
                        f"{self.between}. It is the mass over the drag area of what is quadratic "
                        "in the speed: the body, and what of the rotors' drag is not linear. It is "
                        f"0, which leaves it out, where it would be above {self.largest:g}."
                    ),
                    source=self.source,
                    holds=f"As {self.momentum}: the two belong together.",
                )
            )
        return kinds, comparisons

    def _square(self, along: Floats, through: Floats) -> Floats:
        """Return v s [m^2/s^2] of velocities along the axis and their sizes [m/s]."""
        return along * through if self.whole else along**2

    def _comparison(
        self, flight: InplaneForces, vehicle: Vehicle, rotors: float, ballistic: float
    ) -> DragComparison:
        """Compare a flight with the filter, M ``rotors`` in this air [1/s], B [kg/m^2]."""
        inverse, mass = 1.0 / ballistic if ballistic > 1.0 else 0.0, vehicle.mass
        density = vehicle.air.density
        slower, here, faster = (
            rotors * share * flight.along
            + 0.5 * inverse * density * self._square(share * flight.along, share * flight.through)
            for share in (1.0 - STEP, 1.0, 1.0 + STEP)
        )
        slope = (faster - slower) / (2.0 * STEP * flight.along)
        spread = np.sqrt(np.sum(flight.errors**2, axis=0))
        std = mass * spread if flight.errors.size else np.full_like(spread, np.nan)
        wind = (here - flight.force) / slope
        return DragComparison(flight, mass * flight.force, mass * here, std, wind)
