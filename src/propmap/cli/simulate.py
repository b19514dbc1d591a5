"""``propmap simulate`` and ``propmap vehicle``: simulated logs and drafts of vehicle files."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from typer import Argument, Option, echo

from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.errors import InputError
from propmap.fit.parameters import EVERY, Choice
from propmap.units import RPM
from propmap.vehicle.files import read_vehicle

if TYPE_CHECKING:
    from rich.table import Table

    from propmap.flight.simulate import Expectation

LARGEST_ERROR = 0.2  # fraction of the weight; above it, a random draw can exceed the weight

simulate_app = typer.Typer(
    name="simulate",
    help="Simulate flight logs, and predict the accuracy of a fit to them.",
    rich_markup_mode=None,
)


@simulate_app.callback()
def _group() -> None:
    pass


@simulate_app.command("flight")
def simulate_flight(
    vehicle: opt.VehicleOption,
    section: Annotated[
        str,
        Option(
            "--airfoil",
            metavar="NAME|FILE",
            help="Section law of the simulated blade: a name that `propmap airfoils` lists, or a "
            "fit or parameter set (.toml).",
        ),
    ],
    speed: Annotated[
        str,
        Option("--speeds", metavar="A:B:N", help=f"Airspeeds in m/s, {opt.AXIS_HELP}."),
    ],
    output: Annotated[Path, out.output_option("Output file of the log.", "FILE.csv")],
    model: opt.ModelOption = None,
    correction: opt.Corrections = None,
    radius: Annotated[float, Option(help="Radius of the circles in m.")] = 1.7,
    banked: Annotated[bool, Option("--banked", help="Fly banked turns without a tether.")] = False,
    noise: Annotated[
        float,
        Option(help="Error of the vertical force at each speed, as a fraction of the weight."),
    ] = 0.01,
    rotor_noise: Annotated[float, Option(help="Relative error of rotor speeds.")] = 0.005,
    velocity_noise: Annotated[float, Option(help="Error of velocities in m/s.")] = 0.05,
    attitude_noise: Annotated[float, Option(help="Error of pitch and roll in degrees.")] = 0.3,
    accelerometer_noise: Annotated[float, Option(help="Error of specific forces in m/s^2.")] = 0.3,
    dwell: Annotated[float, Option(help="Time at each speed in s.")] = 6.0,
    rate: Annotated[float, Option(help="Sampling rate in Hz.")] = 100.0,
    seed: Annotated[int, Option(min=0, help="Seed of the random errors.")] = 0,
    no_wakes: opt.NoWakes = False,
    free: Annotated[
        str, Option(metavar="NAMES", help="Free parameters of the fit, separated by commas.")
    ] = "c_l1,c_l2,c_d,alpha_0",
    no_expectation: Annotated[
        bool, Option("--no-expectation", help="Do not predict the 95 % intervals.")
    ] = False,
    force: out.Force = False,
) -> None:
    """Simulate the flight experiment of the paper and write its log.

    The vehicle flies a level circle on a tether at each airspeed. The command also
    predicts the 95 % intervals that a fit to this flight would give for the section constants. All
    error options are standard deviations.
    """
    speeds = opt.parse_axis("--speeds", "speed", speed)
    sizes = {
        "--noise": noise,
        "--rotor-noise": rotor_noise,
        "--velocity-noise": velocity_noise,
        "--attitude-noise": attitude_noise,
        "--accelerometer-noise": accelerometer_noise,
    }
    for option, size in sizes.items():
        if not 0.0 <= size < math.inf:
            raise InputError(f"{option} is {size:g}", "give a standard deviation, 0 or more")
    if noise > LARGEST_ERROR:
        found = f"--noise is {noise:g} times the weight"
        raise InputError(found, f"give at most {LARGEST_ERROR:g}")
    out.check_output(output, (".csv",), keep_existing=not force)
    law = opt.with_physics(opt.constants(section), model, correction)

    from propmap.flight import simulate

    simulate.check_sampling(dwell, rate)
    names = Choice(tuple(name.strip() for name in free.split(","))).free
    read = read_vehicle(vehicle)
    flown = replace(read.vehicle, wakes=None) if no_wakes else read.vehicle
    if any(read.vehicle.sensor):
        found = "there is a table [sensor], but the simulated sensor is at the center of mass"
        raise InputError(found, "remove this table", str(vehicle))

    # A random stream independent of the sensor noise.
    error = noise * np.random.default_rng([seed, 1]).standard_normal(speeds.size)
    points = simulate.trim(flown, law, speeds, radius=radius, tether=not banked, disturbance=error)
    sensors = simulate.SensorNoise(
        rotor_noise, velocity_noise, math.radians(attitude_noise), accelerometer_noise
    )
    log = simulate.fly(points, dwell=dwell, rate=rate, noise=sensors, seed=seed)
    if not no_expectation:
        expected = simulate.expectation(flown, law, points, free=names, error=noise)
        out.show(None, _expected(expected, len(points)))
    out.write_text(simulate.log_csv(log), output)
    echo(
        f"wrote {output}: {speeds.size} speeds, {log.time[-1]:.0f} s, "
        f"{np.min(points.rotor_speed) / RPM:.0f} to {np.max(points.rotor_speed) / RPM:.0f} rpm, "
        f"flown with {' + '.join([law.name, *(law.corrections or ())])}"
    )
    rotors = len(read.vehicle.mounts)
    if replace(simulate.log_map(rotors), file=read.log.file) == read.log:
        echo(f"{vehicle} already describes this log")
    else:
        echo(f"the vehicle file needs this table:\n\n{simulate.log_table(rotors)}", nl=False)


def _expected(expected: Expectation, flights: int) -> Table:
    found = expected.uncertainty
    rows = []
    for k, name in enumerate(expected.choice.free):
        values = (f"{each[k]:.4g}" for each in (expected.truth, found.low, found.high))
        rows.append((name, *values, EVERY[name].unit, found.verdicts[k]))
    share = f"{expected.error:.2%} of the weight each"
    title = f"Expected fit to {flights} speeds with a force error of {share}"
    return out.grid("<parameter|truth|95 % from|to|<unit|<verdict", rows, title)


vehicle_app = typer.Typer(
    name="vehicle", help="Draft a vehicle file from a flight log.", rich_markup_mode=None
)


vehicle_app.callback()(_group)


@vehicle_app.command("from-log")
def vehicle_from_log(
    log: Annotated[Path, Argument(metavar="LOG", help="ULog file of PX4.")],
    output: Annotated[
        Path | None, out.output_option("Output file (default: the terminal).", "VEHICLE.toml")
    ] = None,
    force: out.Force = False,
) -> None:
    """Draft a vehicle file from the parameters in a PX4 log.

    CA_ROTORn_* define the positions, axes and spin directions of the rotors. For each missing
    value the draft has a comment that begins with MISSING. Replace these comments
    before using the file.
    """
    if output is not None:
        out.check_output(output, (".toml",), keep_existing=not force)

    from propmap.vehicle.draft import draft_vehicle

    with out.blamed_on(log):
        text, notes = draft_vehicle(log)
    out.emit(text, output)
    out.note(*notes)
