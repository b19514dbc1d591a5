"""``propmap simulate``: flights that were not flown, and what they would tell."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from propmap.cli.aircraft_options import NoWakes
from propmap.cli.options import Corrections, ModelOption, constants, parse_axis, with_physics
from propmap.cli.output import Force, check_output, grid, show, write_text
from propmap.errors import InputError
from propmap.model.airfoil import PAPER_FOUR
from propmap.units import RPM

if TYPE_CHECKING:
    from rich.table import Table

    from propmap.flight.simulate import Expectation
    from propmap.vehicle.files import VehicleFile

LARGEST_ERROR = 0.2
"""Of the vertical force, as a share of the weight; with more, some draw leaves none to carry."""

simulate_app = typer.Typer(
    name="simulate",
    help="Flights that were not flown, and what they would tell.",
    rich_markup_mode=None,
)


@simulate_app.callback()
def _group() -> None:
    pass


@simulate_app.command("flight")
def simulate_flight(
    vehicle: Annotated[
        Path, typer.Option("--vehicle", metavar="FILE.toml", help="The vehicle and its rotors.")
    ],
    section: Annotated[
        str,
        typer.Option("--airfoil", metavar="NAME|FILE", help="Section law taken for the truth."),
    ],
    speed: Annotated[
        str, typer.Option("--speeds", metavar="A:B:N", help="Speeds [m/s], or a list 1,5,9.")
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="FILE.csv", help="The log, as CSV.")
    ],
    model: ModelOption = None,
    correction: Corrections = None,
    radius: Annotated[float, typer.Option("--radius", help="Of the circles [m].")] = 1.7,
    banked: Annotated[
        bool, typer.Option("--banked", help="Bank into the circle instead of a tether.")
    ] = False,
    noise: Annotated[
        float,
        typer.Option("--noise", help="Vertical force error of each speed, share of the weight."),
    ] = 0.01,
    rotor_noise: Annotated[
        float, typer.Option("--rotor-noise", help="Of a sample of rotor speed, as a share.")
    ] = 0.005,
    velocity_noise: Annotated[
        float, typer.Option("--velocity-noise", help="Of a sample of velocity [m/s].")
    ] = 0.05,
    attitude_noise: Annotated[
        float, typer.Option("--attitude-noise", help="Of a sample of pitch and roll [deg].")
    ] = 0.3,
    accelerometer_noise: Annotated[
        float, typer.Option("--accelerometer-noise", help="Of a sample [m/s^2].")
    ] = 0.3,
    dwell: Annotated[float, typer.Option("--dwell", help="Time at each speed [s].")] = 6.0,
    rate: Annotated[float, typer.Option("--rate", help="Samples per second.")] = 100.0,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of the noise.")] = 0,
    no_wakes: NoWakes = False,
    free: Annotated[
        str, typer.Option("--free", metavar="NAME,...", help="Parameters of the planned fit.")
    ] = ",".join(PAPER_FOUR),
    no_expectation: Annotated[
        bool, typer.Option("--no-expectation", help="Do not reckon the intervals to expect.")
    ] = False,
    force: Force = False,
) -> None:
    """The paper's experiment: level circles at each speed, on a tether, written as a log.

    Before that, the 95 % intervals to expect of an identification from such a flight.
    """
    speeds = parse_axis("--speeds", "speed", speed)
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
        raise InputError(
            f"--noise is {noise:g}, a share of the weight", f"give at most {LARGEST_ERROR:g}"
        )
    check_output(output, (".csv",), keep_existing=not force)
    law = with_physics(constants(section), model, correction)

    from propmap.fit.parameters import Choice
    from propmap.flight.simulate import SensorNoise, check_sampling, fly, log_csv
    from propmap.vehicle.files import read_vehicle

    check_sampling(dwell, rate)
    names = Choice(tuple(name.strip() for name in free.split(","))).free
    read = read_vehicle(vehicle)
    flown = replace(read.vehicle, wakes=None) if no_wakes else read.vehicle
    if any(read.vehicle.sensor):
        raise InputError(
            "the vehicle has [sensor], and a simulated accelerometer is at the centre of mass",
            "remove that table",
            str(vehicle),
        )

    from propmap.flight.simulate import expectation, trim

    # Another stream than that of the sensors.
    error = noise * np.random.default_rng([seed, 1]).standard_normal(speeds.size)
    points = trim(flown, law, speeds, radius=radius, tether=not banked, disturbance=error)
    sensors = SensorNoise(
        rotor_noise, velocity_noise, math.radians(attitude_noise), accelerometer_noise
    )
    log = fly(points, dwell=dwell, rate=rate, noise=sensors, seed=seed)
    if not no_expectation:
        expected = expectation(flown, law, points, free=names, error=noise)
        show(None, _expected(expected, len(points)))
    write_text(log_csv(log), output)
    typer.echo(
        f"wrote {output}: {speeds.size} speeds, {log.time[-1]:.0f} s, "
        f"{np.min(points.rotor_speed) / RPM:.0f} to {np.max(points.rotor_speed) / RPM:.0f} rpm, "
        f"flown with {' + '.join([law.name, *(law.corrections or ())])}"
    )
    _how_to_read(read, str(vehicle))


def _expected(expected: Expectation, flights: int) -> Table:
    from propmap.fit.parameters import EVERY

    found = expected.uncertainty
    rows = [
        (
            name,
            *(f"{value:.4g}" for value in (expected.truth[k], found.low[k], found.high[k])),
            EVERY[name].unit,
            found.verdicts[k],
        )
        for k, name in enumerate(expected.choice.free)
    ]
    title = (
        f"To expect of {flights} speeds with a force error of {expected.error:.2%} of the weight "
        "each"
    )
    return grid("<parameter|truth|95 % from|to|<unit|<verdict", rows, title)


def _how_to_read(read: VehicleFile, name: str) -> None:
    """Say how the log is read back, unless the vehicle file already does."""
    from propmap.flight.simulate import log_map, log_table

    rotors = len(read.vehicle.mounts)
    if replace(log_map(rotors), file=read.log.file) == read.log:
        typer.echo(f"{name} reads it as it is")
        return
    typer.echo(f"to read it, let the vehicle file say:\n\n{log_table(rotors)}", nl=False)
