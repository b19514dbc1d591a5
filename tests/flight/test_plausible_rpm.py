"""Rotor speeds in a wrong unit are told from the weight that they would carry."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.flight.checks import check_rotor_speed
from propmap.model.airfoil import parameter_set
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.vehicle.files import read_vehicle

from .synthetic import NEUROBEM, flight

LOG = flight(rate=50.0)
VEHICLE = read_vehicle(NEUROBEM).vehicle
RPM = np.pi / 30.0


@pytest.fixture(scope="module")
def rotor() -> Rotor:
    return Rotor(Model(VEHICLE.propeller, parameter_set("paper-apc"), VEHICLE.air))


@pytest.mark.parametrize(
    ("factor", "unit", "parts"),
    [
        (1.0 / RPM, "rad/s", ["rpm read as rad/s", 'write rotor_unit = "rpm"']),
        (12.0, "rpm", ["electrical rpm", "pole_pairs"]),
        (7.0 / RPM, "rad/s", ["electrical rpm", 'write rotor_unit = "erpm" and pole_pairs (']),
        (7.0, "erpm", ["pole_pairs looks too small", "correct pole_pairs"]),
        (1.0 / 7.0, "erpm", ["mechanical rpm", 'write rotor_unit = "rpm", or correct pole_pairs']),
    ],
)
def test_a_wrong_unit_is_an_error(
    rotor: Rotor, factor: float, unit: str | None, parts: list[str]
) -> None:
    log = replace(LOG, rotor_speed=LOG.rotor_speed * factor)
    with pytest.raises(InputError) as caught:
        check_rotor_speed(log, rotor, VEHICLE, unit)
    message = str(caught.value)
    assert message.isprintable() and message.startswith("synthetic: ")
    for part in [*parts, "[log] of the vehicle file"]:
        assert part in message


@pytest.mark.parametrize(
    ("values", "part"),
    [
        # Hover takes about 10800 rpm, 1130 rad/s.
        ((1650.0, 1750.0), "they look like PWM in us; log measured speeds"),
        ((1050.0, 1150.0), "like rad/s read as rpm, or like PWM in us"),
        ((0.45, 0.55), "no common error of units.*throttle are commands"),
    ],
)
def test_commands_are_an_error(rotor: Rotor, values: tuple[float, float], part: str) -> None:
    """PWM and throttle read as speeds, which a fit would take minutes to make nothing of."""
    span = (LOG.rotor_speed - LOG.rotor_speed.min()) / np.ptp(LOG.rotor_speed)
    commands = (values[0] + (values[1] - values[0]) * span) * RPM
    with pytest.raises(InputError, match=part):
        check_rotor_speed(replace(LOG, rotor_speed=commands), rotor, VEHICLE, "rpm")


def test_without_slow_flight_the_slowest_samples_serve(rotor: Rotor) -> None:
    fast = LOG.picked(LOG.speed > 5.0)
    assert check_rotor_speed(fast, rotor, VEHICLE, "rad/s") == []
    unmeasured = replace(fast, specific_force=np.full_like(fast.velocity, np.nan))
    assert check_rotor_speed(unmeasured, rotor, VEHICLE, "rad/s") == []
    wrong = replace(unmeasured, rotor_speed=fast.rotor_speed / RPM)
    with pytest.raises(InputError, match="rpm read as rad/s"):
        check_rotor_speed(wrong, rotor, VEHICLE, "rad/s")


def test_wrong_masses_axes_and_rotors_at_rest(rotor: Rotor) -> None:
    assert check_rotor_speed(LOG, rotor, VEHICLE) == []
    (warning,) = check_rotor_speed(LOG, rotor, replace(VEHICLE, mass=2.5))
    assert "times the weight" in warning and "check mass, propeller" in warning
    speeds = LOG.rotor_speed.copy()
    speeds[LOG.time < 3.0] = 100.0  # time on the ground does not count
    assert check_rotor_speed(replace(LOG, rotor_speed=speeds), rotor, VEHICLE, "rad/s") == []
    speeds[:, 2] = 0.0
    down = tuple(replace(mount, axis=(0.0, 0.0, -1.0)) for mount in VEHICLE.mounts)
    for log, vehicle, told in (
        (LOG, replace(VEHICLE, mass=1000.0 * VEHICLE.mass), "kg looks like grams; write kilograms"),
        (replace(LOG, rotor_speed=speeds), VEHICLE, r"rotor 3 stands still.*rotor_order"),
        (LOG, replace(VEHICLE, mounts=down), "check body_frame, world_frame and the axes"),
    ):
        with pytest.raises(InputError, match=told):
            check_rotor_speed(log, rotor, vehicle)
