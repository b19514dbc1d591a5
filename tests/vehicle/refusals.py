"""What the tests of bad logs share."""

from __future__ import annotations

from pathlib import Path

import pytest

from propmap.errors import InputError
from propmap.vehicle.files import VehicleFile
from propmap.vehicle.log_readers import read_flight_log
from tests.flight.synthetic import flight

LOG = flight(rate=50.0).picked(slice(0, 120))
LINE_LENGTH = 600


def message_of(path: Path, vehicle_file: VehicleFile) -> str:
    with pytest.raises(InputError) as caught:
        read_flight_log(path, vehicle_file)
    message = str(caught.value)
    assert message.isprintable() and len(message) < LINE_LENGTH
    return message
