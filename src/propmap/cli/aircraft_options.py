"""VEHICLE and the options that choose the loads of its rotors, shared by commands on aircraft."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from propmap import catalogue
from propmap.cli.options import AccuracyName, ModelName, RotorChoice, with_physics
from propmap.errors import InputError
from propmap.units import RPM

if TYPE_CHECKING:
    from propmap.aircraft.trim import Aircraft
    from propmap.model.model import Model, Propeller
    from propmap.vehicle.vehicle import Vehicle

VehicleArgument = Annotated[
    Path, typer.Argument(metavar="VEHICLE.toml", help="The aircraft, its rotors and motors.")
]
MaximumRpm = Annotated[
    float | None, typer.Option("--max-rpm", help="Largest speed of the rotors [1/min].")
]
Charge = Annotated[
    float, typer.Option("--charge", help="State of charge at which limits are taken, 1 when full.")
]
NoWakes = Annotated[
    bool, typer.Option("--no-wakes", help="Leave out [wakes], the rotors' wakes on each other.")
]
Wind = Annotated[float, typer.Option("--wind", help="Headwind [m/s], for distances.")]

MISSING = {
    "motor": "power is shaft power: the vehicle file has no [motor]",
    "esc": "nothing is lost in the speed controllers: the vehicle file has no [esc]",
    "battery": "no times and no voltage limit: the vehicle file has no [battery]",
}


def vehicle_of(path: Path, *, no_wakes: bool) -> Vehicle:
    """The vehicle of a file; with ``no_wakes`` as if it had no table ``[wakes]``."""
    from propmap.vehicle.files import read_vehicle

    found = read_vehicle(path).vehicle
    return replace(found, wakes=None) if no_wakes else found


def model_of(
    vehicle: Vehicle,
    propeller: Propeller,
    airfoil: str | None,
    model: ModelName | None,
    correction: list[str] | None,
) -> Model:
    """The model of a rotor with this propeller in the vehicle's air, as for ``propmap predict``."""
    from propmap.model.model import Model

    # A name that is not in the catalogue is of a file, written so that it is taken for one.
    name = propeller.name if propeller.name in catalogue.names() else f"./{propeller.name}"
    section = RotorChoice(name, airfoil=airfoil).section(propeller)
    return Model(propeller, with_physics(section, model, correction), vehicle.air)


def aircraft_of(
    vehicle: Vehicle,
    *,
    airfoil: str | None,
    table: Path | None,
    model: ModelName | None,
    correction: list[str] | None,
    accuracy: AccuracyName,
    maximum_rpm: float | None,
    charge: float,
) -> Aircraft:
    """The aircraft with loads from a table or from a rotor; notes say what is not known of it."""
    limits = {"maximum_rotor_speed": checked_rpm(maximum_rpm), "charge": charge}
    if table is not None:
        if airfoil or model or correction:
            raise InputError(
                "--table is given with --airfoil, --model or --correction",
                "leave these out: the table was built with its own",
            )
        from propmap.aircraft.trim import Aircraft
        from propmap.table.query import LoadTable

        found = LoadTable.load(table)
        say_missing(vehicle)
        return Aircraft(vehicle, found, **limits)
    chosen = model_of(vehicle, vehicle.propeller, airfoil, model, correction)
    say_missing(vehicle)

    from propmap.aircraft.trim import Aircraft
    from propmap.rotor import Rotor

    rotor = Rotor(chosen, accuracy=accuracy.value)
    return Aircraft(vehicle, rotor, **limits)


def checked_rpm(maximum: float | None) -> float:
    """``--max-rpm`` as rad/s, infinite where it is not given."""
    if maximum is None:
        return math.inf
    if not 0.0 < maximum < math.inf:
        raise InputError(f"--max-rpm is {maximum:g}", "give revolutions per minute, above 0")
    return maximum * RPM


def say_missing(vehicle: Vehicle) -> None:
    """A note for each table of the powertrain that the vehicle file does not have."""
    powertrain = vehicle.powertrain
    has = {
        "motor": powertrain.motor,
        "esc": powertrain.controller,
        "battery": powertrain.battery,
    }
    for name, told in MISSING.items():
        if has[name] is None:
            typer.echo(f"note: {told}", err=True)
            if name == "motor":
                return


def title(craft: Aircraft) -> str:
    """The aircraft ``craft`` in a line."""
    vehicle = craft.vehicle
    wakes = ", in each other's wakes" if vehicle.wakes is not None else ""
    return (
        f"{vehicle.name}, {vehicle.mass:g} kg, {len(vehicle.mounts)} x {vehicle.propeller.name}"
        f"{wakes}; rho = {vehicle.air.density:.4g} kg/m^3"
    )


def number_or_none(value: float) -> float | None:
    """The ``value``, None for NaN."""
    return float(value) if math.isfinite(value) else None


def digits(value: float) -> str:
    """A cell of a table for a ``value``; a dash for NaN."""
    if not math.isfinite(value):
        return "-"
    return "0" if abs(value) < 5e-4 else f"{value:.4g}"
