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
from propmap.fit.files import DataSource, FitFile
from propmap.fit.flight import ForceModel
from propmap.fit.parameters import FIRST_GUESS, PER_FLIGHT, SECTION
from propmap.model.envelope import Envelope
from propmap.vehicle.log import hub_flow
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
        "data": [DataSource(name, "abc") for name in ("first.csv", "second.csv", "vehicle.toml")],
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
    squares = np.zeros_like(here)
    for name, deviation in PER_FLIGHT.items():
        if name != "clock_offset":
            moved = forces(LAW, **{name: values[name] + h})
            squares = squares + (deviation * (moved - here) / h) ** 2
    # The rotors pull along z, so drag acts along x and y.
    squares = squares + np.square(DRAG_DEVIATION * here * [1.0, 1.0, 0.0])
    squares = squares + (PER_FLIGHT["clock_offset"] * VEHICLE.mass * LOG.specific_force_rate) ** 2
    # The parameters of a fit to two flights contain the mean difference of these flights.
    squares = 1.5 * squares + SPREAD**2 * ((forces(steeper) - here) / h) ** 2
    # Measured forces of the made-up fit have a root mean square of 1 along each axis.
    growth = np.maximum(np.sum(here**2, axis=1, keepdims=True) / 3.0, 1.0)
    wanted = np.sqrt(squares + growth * np.square(LEFT))
    # Where stall begins the quotient is of another slope.
    assert np.quantile(np.abs(found[:, :3] / wanted - 1.0), 0.95) < 1e-3
    # Moments were not fitted: how far they err is not known.
    assert np.isnan(found[:, 3:]).all()
    assert force_errors(flown(kind="tunnel"), VEHICLE, LOG, {}) is None


def test_errors_beyond_the_data_of_the_fit_are_common_to_all_samples() -> None:
    """The error grows with V/(Omega R) over its maximum in the fit; the growth is a parameter."""
    narrow = Envelope((0.0, 100.0), (0.0, 0.02), (0.0, 0.02), (-0.02, 0.02), (100.0, 1e5))
    file = flown(envelope=narrow)
    beyond = file.beyond(hub_flow(VEHICLE, LOG)[:3], VEHICLE.propeller.radius)
    known, found = (force_errors(one, VEHICLE, LOG, {}) for one in (flown(), file))
    assert known is not None and found is not None and beyond is not None
    np.testing.assert_array_equal(found.left, known.left)
    growth = (known.left[:, :3] / LEFT) ** 2
    more = np.maximum(beyond.reach[:, None] ** 2 - growth, 0.0) * np.square(LEFT)
    assert np.any(more > 0.0)
    grown = found.deviations**2 - known.deviations**2
    np.testing.assert_allclose(grown[:, :3], more, atol=1e-12)


def test_the_band_contains_the_priors_of_what_slow_flights_do_not_determine() -> None:
    prior = {"plate_area": 0.01, "download_area_x": 0.02}
    known, found = (
        force_errors(flown(settings=settings), VEHICLE, LOG, {})
        for settings in ({}, {"undetermined": prior})
    )
    assert known is not None and found is not None
    pressure = 0.5 * VEHICLE.air.density
    plate = pressure * prior["plate_area"] * LOG.speed * LOG.velocity[:, 2]
    download = pressure * prior["download_area_x"] * LOG.velocity[:, 0] ** 2
    assert download.max() > 0.5
    more = found.deviations[:, :3] ** 2 - known.deviations[:, :3] ** 2
    np.testing.assert_allclose(more[:, 2], plate**2 + download**2, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(more[:, :2], 0.0, atol=1e-12)
    np.testing.assert_array_equal(found.loads, known.loads)


def test_the_share_of_samples_in_the_band() -> None:
    measured = VEHICLE.mass * LOG.specific_force
    model = np.concatenate([measured, np.zeros((len(LOG), 3))], axis=1)
    model[:6, 1] += 1.01 * BAND
    model[:, 2] += 0.99 * BAND
    deviations = np.ones((len(LOG), 6))
    found = compare_forces(VEHICLE, LOG, FlightForces(model, model), None, deviations)
    shares = [found[f"force_{axis}_N"].in_band for axis in "xyz"]
    assert shares == pytest.approx([1.0, 0.8, 1.0])
