"""Balances of whole flights: derivatives by all parameters, wakes, refusals, and twins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.fit.fit import Settings, fit
from propmap.fit.flight import ForceModel, balance_rows, level_rows
from propmap.fit.parameters import FIRST_GUESS, SECTION, Choice, Prior
from propmap.vehicle.log import joined
from propmap.vehicle.vehicle import Wakes, Wing
from tests.fit.flight_twin import (
    BEFOREHAND,
    FIXED,
    FLIGHTS,
    FREE,
    LAW,
    TRUTH,
    VEHICLE,
    Noise,
    Twin,
    manoeuvre,
)

LAW_VALUES = {name: getattr(LAW, name) for name in SECTION}
LOG = manoeuvre(0, 20)
BODY = replace(VEHICLE, inertia=None)


def forces(more: dict[str, float], wakes: Wakes | None = None) -> np.ndarray:
    """All forces [N] (n, 3) with the true section law and these parameters."""
    vehicle = replace(BODY, wakes=wakes)
    return ForceModel(vehicle, LOG, LAW).at(FIRST_GUESS | LAW_VALUES | more, ()).force


def test_slopes_of_all_parameters_against_differences() -> None:
    log = joined([manoeuvre(seed, 8) for seed in range(2)], FLIGHTS)
    jerk = np.stack([20.0 * np.cos(log.time + k) for k in range(3)], axis=1)
    winged = replace(VEHICLE, wing=Wing(0.1, 0.05))
    model = ForceModel(winged, replace(log, specific_force_rate=jerk), LAW)
    more = {"untwist": 0.02, "rotor_speed_scale": 1.01, "alpha_0": 0.3}
    more |= {"download_area_y": 0.01, "drag_area_z": 0.01, "drag_area_x": 0.02, "lift_area": 0.01}
    more |= {"wing_c_l1": 4.0, "wing_c_l2": 1.0, "wing_alpha_0": 0.2}
    values, free = FIRST_GUESS | FIXED | TRUTH | more, (*FREE, *more)
    found = model.at(values, free)
    # Within wider steps of the untwist a panel may get a node more, and loads another value.
    steps = dict.fromkeys(free, 1e-4) | {"rotor_inertia": 1e-6, "untwist": 3e-6}
    for k, name in enumerate(free):
        h = steps[name]
        up, down = (model.at({**values, name: values[name] + d}, (name,)).loads for d in (h, -h))
        wanted = (up - down) / (2.0 * h)
        assert np.abs(wanted).max() > 0.0, name
        for part in (slice(0, 3), slice(3, 6)):
            size = max(np.abs(wanted[:, part]).max(), 1e-6)
            off = np.abs(found.slopes[k][:, part] - wanted[:, part]) / size
            # At a few points a difference quotient spans a jump of the loads.
            assert np.quantile(off, 0.95) < 5e-3, name


def test_gains_of_wakes_are_those_of_the_vehicle_file() -> None:
    plain = forces({})
    np.testing.assert_array_equal(
        forces({f"wake_{name}": 0.0 for name in ("ahead", "beside", "downwash")}), plain
    )
    by_file = forces({}, Wakes(3.0, 1.0, 1.0))
    named = {"wake_ahead": 3.0, "wake_beside": 1.0, "wake_downwash": 1.0}
    np.testing.assert_array_equal(forces(named), by_file)
    assert np.max(np.abs(by_file - plain)) > 0.05


def test_segments_of_two_flights_are_not_one() -> None:
    log = joined([LOG, manoeuvre(1, 20)])
    rows = balance_rows(ForceModel(BODY, log, LAW), Choice(("c_l1",)))
    assert rows.group is not None
    first, second = np.split(rows.group, 2)
    assert not set(first.tolist()) & set(second.tolist())


def test_parameters_without_effect_are_refused() -> None:
    model = ForceModel(BODY, LOG, LAW)
    with pytest.raises(InputError, match="sensor_x has no effect in steady segments"):
        level_rows(model, Choice(("c_l1", "sensor_x")))
    with pytest.raises(InputError, match=r"'thrust_scale\[2\]' names no flight of the logs"):
        model.at(FIRST_GUESS | LAW_VALUES, ("c_l1", "thrust_scale[2]"))


@pytest.mark.slow
def test_the_parameters_of_a_twin_are_identified() -> None:
    """`make bench ONLY=flight_twins` fits a hundred with noise."""
    twin, once = Twin(), Settings(starts=1, folds=0)
    priors = {name: Prior(TRUTH[name], deviation) for name, deviation in BEFOREHAND.items()}
    choice = Choice(FREE, FIXED, priors, start={"c_l1": 5.0})
    found = fit(replace(twin.rows, measured=twin.measured(TRUTH)), choice, once)
    np.testing.assert_allclose(found.x, [TRUTH[name] for name in FREE], rtol=1e-3)
    rows, choice, truth = twin.noisy(1000, Noise())
    found = fit(rows, choice, once)
    sure = found.uncertainty
    off = (found.x - [truth[name] for name in FREE]) / np.sqrt(np.diag(sure.covariance))
    good = np.array(sure.identified)
    named = {"c_l1", "sensor_x", "sensor_z", "center_x", "clock_offset[1]"}
    assert named <= {name for name, sure_of in zip(FREE, good, strict=True) if sure_of}
    # Some ten numbers of variance 1, correlated in part.
    assert 0.5 < np.sqrt(np.mean(off[good] ** 2)) < 1.6 and np.max(np.abs(off[good])) < 4.5
