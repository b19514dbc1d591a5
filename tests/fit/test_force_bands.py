"""The 95 % bands of forces and moments on a vehicle, by a fit of other flights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import propmap
from propmap.fit.comparison import (
    BAND,
    DRAG_DEVIATION,
    FlightForces,
    compare_forces,
    force_errors,
)
from propmap.fit.files import FitFile
from propmap.fit.flight import ForceModel
from propmap.fit.parameters import FIRST_GUESS, PER_FLIGHT, SECTION
from tests.fit.fit_records import load, parameter, record
from tests.fit.flight_twin import VEHICLE, manoeuvre

LAW = propmap.airfoil("paper-apc")
LOG = replace(manoeuvre(0, 30), specific_force_rate=np.full((30, 3), 4.0))
SPREAD = 0.2  # standard deviation of c_l1
LEFT = (0.1, 0.2, 0.3)  # cross-validated, of the forces


def flown(**changed: object) -> FitFile:
    """A fit of flights in which c_l1 and the clock of another flight were free."""
    loads = [load(f"force_{axis}", 0.01, 0.3, left) for axis, left in zip("xyz", LEFT, strict=True)]
    entries = {
        "kind": "flight",
        "parameters": [
            parameter("c_l1", LAW.c_l1, 0.5, 12.0),
            parameter("clock_offset[other]", 0.0, -0.1, 0.1),
        ],
        "covariance": np.diag([SPREAD**2, 1e6]),
        "loads": loads,
    }
    return FitFile(LAW, None, record(**entries | changed))


def test_a_band_is_made_of_all_that_is_not_known() -> None:
    errors = force_errors(flown(), VEHICLE, LOG, {})
    assert errors is not None
    found = errors.deviations
    assert found.shape == (len(LOG), 6)
    values = FIRST_GUESS | {name: getattr(LAW, name) for name in SECTION}

    def forces(law: propmap.Airfoil, **more: float) -> np.ndarray:
        changed = values | {"c_l1": law.c_l1, **more}
        return ForceModel(VEHICLE, LOG, law).at(changed, ()).force

    h = 1e-3
    steeper = LAW.with_parameters(c_l1=LAW.c_l1 + h)
    here = forces(LAW)
    squares = SPREAD**2 * ((forces(steeper) - here) / h) ** 2
    for name, deviation in PER_FLIGHT.items():
        if name != "clock_offset":
            moved = forces(LAW, **{name: values[name] + h})
            squares = squares + (deviation * (moved - here) / h) ** 2
    # The rotors pull along z, so drag acts along x and y.
    squares = squares + np.square(DRAG_DEVIATION * here * [1.0, 1.0, 0.0])
    squares = squares + (PER_FLIGHT["clock_offset"] * VEHICLE.mass * LOG.specific_force_rate) ** 2
    # Measured forces of the made-up fit have a root mean square of 1 along each axis.
    growth = np.maximum(np.sum(here**2, axis=1, keepdims=True) / 3.0, 1.0)
    wanted = np.sqrt(squares + growth * np.square(LEFT))
    # Where stall begins the quotient is of another slope.
    assert np.quantile(np.abs(found[:, :3] / wanted - 1.0), 0.95) < 1e-3
    # Moments were not fitted: how far they err is not known.
    assert np.isnan(found[:, 3:]).all()
    assert force_errors(flown(kind="tunnel"), VEHICLE, LOG, {}) is None


def test_the_share_of_samples_in_the_band() -> None:
    measured = VEHICLE.mass * LOG.specific_force
    model = np.concatenate([measured, np.zeros((len(LOG), 3))], axis=1)
    model[:6, 1] += 1.01 * BAND
    model[:, 2] += 0.99 * BAND
    deviations = np.ones((len(LOG), 6))
    found = compare_forces(VEHICLE, LOG, FlightForces(model, model), None, deviations)
    shares = [found[f"force_{axis}_N"].in_band for axis in "xyz"]
    assert shares == pytest.approx([1.0, 0.8, 1.0])
