"""Parameters of a vehicle for the firmware of an autopilot: values, errors, files and a note."""

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
from propmap.catalogue.identified import identified_with_name
from propmap.errors import InputError
from propmap.export import check_direction, find_export
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
    """Parameters of one kind with their explanation.

    Attributes
    ----------
    title : str
        Name of the parameters, with n for the number of a rotor.
    values : dict of str to float or int
        Values by the firmware's parameter names; integer parameters are int.
    unit : str
        Unit of the values.
    std : float or None
        Standard deviation in the same unit; None if it is not known.
    meaning, source, holds : str
        Equation of the firmware, source file of the equation, and range in which it holds.
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
    """Parameters in one file.

    Attributes
    ----------
    suffix : str
        End of the file name, as in "quad_px4.params".
    purpose : str
        Use of the parameters, as a title.
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
    """Parameters that are not written: their names, and the reason as a sentence."""

    name: str
    why: str


@dataclass(frozen=True)
class AutopilotParameters:
    """Result of an export to an autopilot.

    Attributes
    ----------
    firmware : str
        Name of the firmware.
    sets : list of ParameterSet
        Parameters by file.
    left_out : list of NotWritten
        Parameters that are not written.
    comparisons : list of DragComparison
        Drag model of the firmware compared with the full model, along x and y.
    remarks : list of str
        Further remarks, one or more sentences each.
    file_text : callable
        Returns the text of the file of a set, in the format of the firmware's tools.
    """

    firmware: str
    sets: list[ParameterSet]
    left_out: list[NotWritten]
    comparisons: list[DragComparison]
    remarks: list[str]
    file_text: Callable[[ParameterSet, Vehicle], str]


Flights = tuple[InplaneForces, InplaneForces]  # level flights of a vehicle along x and y

SPEEDS = np.linspace(1.0, 15.0, 8)  # default airspeeds of the level flights [m/s]


def autopilot_parameters(
    aircraft: Aircraft, target: str, speeds: Floats = SPEEDS
) -> AutopilotParameters:
    """Compute the autopilot parameters of a vehicle.

    Parameters
    ----------
    aircraft : Aircraft
        The vehicle with the loads of its rotors.
    target : str
        One of ``propmap.export.AUTOPILOTS``.
    speeds : ndarray, shape (n,)
        Airspeeds of the level flights to which the drag model is fitted [m/s]; 0 is ignored.  Not
        used for a vehicle with one or two rotors that has a wing or thrusts forward.

    Raises
    ------
    InputError
        For an unknown target, a vehicle that does not fit the drag models of autopilots, and fewer
        than two speeds that can be flown.  With one or two rotors: for a target without a propeller
        model, and for a vehicle whose rotor speed at full throttle is unknown.
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
    """Write the autopilot parameters of a vehicle and a note, all files or none.

    Parameters
    ----------
    aircraft, target, speeds
        As for ``autopilot_parameters``.
    folder, replace
        As for ``propmap.export.export_table``.

    Returns
    -------
    list of Path
        The written files.

    Raises
    ------
    InputError
        As ``autopilot_parameters``, and for a folder that is not writable and existing files.
    """
    check_direction(aircraft.loads, target)
    place, vehicle = Path(folder), aircraft.vehicle
    check_folder(place)
    found = autopilot_parameters(aircraft, target, speeds)
    name = vehicle_identifier(vehicle)
    files = {f"{name}_{part.suffix}": found.file_text(part, vehicle) for part in found.sets}
    files[f"README-{target}.md"] = autopilot_note(found, aircraft)
    return write_files(files, place, replace=replace)


def comment_lines(part: ParameterSet, vehicle: Vehicle, target: str) -> list[str]:
    """Return the header of a parameter file, in lines short enough for ArduPilot's reader."""
    # AP_Param reads lines of 98 characters and takes the rest of a longer line as another line.
    clean = "".join(c if c.isprintable() else "?" for c in vehicle.name)[:50]
    return [
        f"{clean}: {part.purpose}"[:90],
        f"written by propmap {propmap.__version__}; README-{target}.md has definitions and errors",
    ]


def common_remarks(aircraft: Aircraft, omega: float) -> list[str]:
    """List the assumptions of the drag coefficients of an ``aircraft``, with a warning if its
    fastest rotor speed ``omega`` [rad/s] exceeds the data of the section constants."""
    words = assumption_lines(assumptions(aircraft.vehicle, aircraft.loads))
    words = [*words, *aircraft.balance.allocation.notes]
    remarks = [f"{each[:1].upper()}{each[1:]}." for each in words]
    tilted = any(mount.axis[2] < 0.9999 for mount in aircraft.vehicle.mounts)
    if tilted and not aircraft.rotors.forward:
        remarks.append(
            "Rotors are tilted: the fitted coefficients include the components of their thrust "
            "along x and y in forward flight."
        )
    loads, blade, rpm = aircraft.loads, aircraft.vehicle.propeller, omega / RPM
    if isinstance(loads, Rotor):
        own = identified_with_name(loads.model.airfoil.name, blade.blades)
        if own is not None and rpm > own.rpm_high:
            remarks.append(
                f"The section constants are extrapolated: for these parameters rotors turn at up "
                f"to {rpm:.0f} rpm, and the data of the constants end at {own.rpm_high:.0f} rpm."
            )
    return remarks


# -------------------------------------------------------------------------------------------------
# The note of an autopilot export, in Markdown: definitions, errors and ranges of the parameters.


def autopilot_note(found: AutopilotParameters, aircraft: Aircraft) -> str:
    """Return the note on the parameters ``found`` for an ``aircraft``."""
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
# The drag model of an autopilot's Kalman filter: its parameters and its errors in level flight.

SEA_LEVEL = 1.225  # density [kg/m^3] at which both PX4 and ArduPilot define the drag of the rotors
STEP = 1e-4  # relative change of a velocity in a difference quotient


def where_it_holds(comparisons: list[DragComparison]) -> str:
    """Return a sentence on the speeds at which a filter's drag model agrees with the full model."""
    parts = []
    for comparison in comparisons:
        run = comparison.holds
        where = AXES[comparison.flight.axis]
        worst = float(abs(comparison.filtered - comparison.full).max())
        if run is None:
            parts.append(
                f"{where} above {CLOSE:.0%} of the force at all speeds, up to {worst:.2g} N"
            )
        else:
            parts.append(
                f"{where} at most {CLOSE:.0%} of the force from {run[0]:g} to {run[1]:g} m/s, and "
                f"at most {worst:.2g} N at all speeds"
            )
    return f"Error in level flight: {'; '.join(parts)}."


@dataclass(frozen=True)
class DragFilter:
    """Equation of a filter along a body axis: specific force against the motion = M (rho /
    1.225)^power v + 1/2 rho v s / B, where s is v or the magnitude of the velocity."""

    momentum: str  # parameter name of M [1/s]
    ballistic: str  # parameter name of B [kg/m^2], without the axis
    power: float  # exponent of the density ratio
    whole: bool  # whether s is the magnitude of the velocity
    largest: float  # larger values of B are written as 0, no body drag [kg/m^2]
    source: str  # source file of the equation
    between: str  # how the filter combines both axes in diagonal flight, in words

    def parameters(
        self, flights: Flights, vehicle: Vehicle
    ) -> tuple[list[Explained], list[DragComparison]]:
        """Fit the parameters to level flights and compare the filter with the full model."""
        density = vehicle.air.density
        scale = float((density / SEA_LEVEL) ** self.power)
        constants, errors = fit_drag(
            flights, lambda one: self._square(one.along, one.through), density, 1.0 / self.largest
        )
        rotors, *bodies = constants.tolist()
        momentum, values = round(rotors / scale, 6), {}
        for axis, inverse in zip("XY", bodies, strict=True):
            values[self.ballistic + axis] = 0.0 if not inverse else round(1.0 / inverse, 4)
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
                    f"Specific force against the motion, along x and along y: {self.momentum} "
                    f"{ratio} v, where v is the component of the velocity through the air. This "
                    "linear term is the drag of the rotors. The filter ignores values below 0.001."
                ),
                source=self.source,
                holds=(
                    f"{where_it_holds(comparisons)} A fit at {flights[0].speed[0]:g} m/s alone "
                    f"would give {slope:.4f}."
                ),
            )
        ]
        size = "v |V|" if self.whole else "v^2"
        whole = " and |V| the magnitude of the velocity" if self.whole else ""
        for k, ((name, value), inverse) in enumerate(zip(values.items(), bodies, strict=True)):
            kinds.append(
                Explained(
                    title=name,
                    values={name: value},
                    unit="kg/m^2",
                    std=None if std is None or not inverse else std[1 + k] / inverse**2,
                    meaning=(
                        f"Specific force along {'xy'[k]} against the motion: 1/2 rho {size} / "
                        f"{name}, where v is the component of the velocity along the axis{whole}. "
                        f"{self.between}{name} is the mass over the drag area of the quadratic "
                        "drag: drag of the body, and nonlinear drag of the rotors. A value above "
                        f"{self.largest:g} is written as 0, which disables this term."
                    ),
                    source=self.source,
                    holds=f"Valid in the range of {self.momentum}: use both together.",
                )
            )
        return kinds, comparisons

    def _square(self, along: Floats, through: Floats) -> Floats:
        """Return v s [m^2/s^2] for velocities along the axis and magnitudes [m/s]."""
        return along * through if self.whole else along**2

    def _comparison(
        self, flight: InplaneForces, vehicle: Vehicle, rotors: float, ballistic: float
    ) -> DragComparison:
        """Compare a flight with the filter; ``rotors`` is M in this air [1/s], ``ballistic`` B."""
        inverse, mass = (ballistic > 1.0) / max(ballistic, 1.0), vehicle.mass
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
