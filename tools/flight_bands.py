"""Print coverage and score of the bands of flight fits on held-out flights.

Usage: python -m tools.flight_bands FOLDER

FOLDER contains the flights of two vehicles, one CSV file each: neuralfly_CONTROLLER_WIND.csv
(O'Connell et al., Neural-Fly, Science Robotics 2022) and the two neurobem_*.csv (Bauersfeld et al.,
NeuroBEM, RSS 2021).  Each NeuroBEM flight, and each Neural-Fly flight in the fastest wind, is
predicted by a fit of the other flights of the vehicle.  The flights in the fastest wind are also
predicted by a fit of the flights in slower wind.  The tool varies the standard deviations, over
flights, of the trim [rad] and of a factor on the drag.  It prints the mean over flights of the
interval score of ``tools.coverage``, divided by the weight.
"""

from __future__ import annotations

import itertools
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from propmap.cli.fit_flight import read_flights
from propmap.fit import comparison, parameters
from propmap.fit.files import read_fit
from propmap.fit.flight import TILT
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.files import read_vehicle
from tools.catalogue.left_out import BAND, interval_score
from tools.wind_of_flights import CONTROLLERS, FAST, NEURALFLY, NEUROBEM, SLOW, SPEEDS, fitted

TRIMS, DRAGS = (0.005, 0.0075, 0.01, 0.0125, 0.015, 0.03), (0.0, 0.08, 0.10, 0.12, 0.14)


class HeldOut(NamedTuple):
    """Errors of the force on a held-out flight and their deviations, divided by the weight."""

    name: str
    error: Floats  # (n, 3)
    deviations: dict[tuple[float, float], Floats]  # (n, 3), by deviations of trim and drag


def splits(folder: Path) -> Iterator[tuple[str, list[Path], list[Path]]]:
    """Yield a vehicle file, the flights to fit, and the flights to predict."""
    first = [folder / f"neurobem_{name}.csv" for name in (SLOW, FAST)]
    second = [folder / f"neuralfly_{one}_{wind}.csv" for wind in SPEEDS for one in CONTROLLERS]
    slow, fast = second[:-2], second[-2:]
    yield from ((NEUROBEM, first[:k] + first[k + 1 :], [one]) for k, one in enumerate(first))
    yield from ((NEURALFLY, [*slow, fast[1 - k]], [one]) for k, one in enumerate(fast))
    yield NEURALFLY, slow, fast


def held_out(vehicle: str, fit: Path, path: Path, name: str) -> HeldOut:
    """Predict the force on the flight ``path``."""
    file, known = read_vehicle(vehicle), read_fit(fit)
    flown = file.vehicle
    log = read_flights([path], file, "balance", low_pass=known.low_pass, curve=known.curve).log
    values, _ = comparison.values_for(known, flown, log, [path])
    found = comparison.force_errors(known, flown, log, values)
    assert found is not None
    weight, deviations = flown.mass * GRAVITY, {}
    between = found.covariance[-1, -1] / comparison.DRAG_DEVIATION**2  # 1 + 1/flights of the fit
    last = np.arange(-3, 0)  # trims about x and y, and drag
    for trim, drag in itertools.product(TRIMS, DRAGS):
        covariance = found.covariance.copy()
        covariance[last, last] = between * np.square([trim, trim, drag])
        each = found._replace(covariance=covariance).deviations
        deviations[trim, drag] = each[:, :3] / weight
    error = found.loads[:, :3] - flown.mass * log.specific_force
    return HeldOut(name, error / weight, deviations)


def main(folder: str) -> None:
    """Print the scores, and the coverage with the deviations of ``propmap.fit.comparison``."""
    every = []
    with tempfile.TemporaryDirectory() as place:
        for k, (vehicle, seen, unseen) in enumerate(splits(Path(folder))):
            fit = fitted(seen, vehicle, Path(place) / f"{k}.toml")
            among = f"fit of {len(seen)}"
            every += [held_out(vehicle, fit, path, f"{path.stem}, {among}") for path in unseen]
    print("trim [rad], drag [-]; mean score / weight along x, y, z; mean of x and y")
    for trim, drag in itertools.product(TRIMS, DRAGS):
        each = [
            np.nanmean(interval_score(f.error, f.deviations[trim, drag]), axis=0) for f in every
        ]
        x, y, z = np.mean(each, axis=0)
        print(f"{trim:.4f} {drag:.2f}   {x:.4f} {y:.4f} {z:.4f}   {(x + y) / 2.0:.4f}")
    now = parameters.PER_FLIGHT[TILT[0]], comparison.DRAG_DEVIATION
    print("share of the samples in the 95 % band along x, y, z")
    for one in every:
        inside = np.mean(np.abs(one.error) <= BAND * one.deviations[now], axis=0)
        print(f"{one.name:<40}" + "".join(f"{share:8.1%}" for share in inside))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
