"""Tables and vehicles in the core, at points that no table has: what `make sanitize` looks into."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import propmap
from propmap import core
from propmap.table import STATUSES, LoadTable
from propmap.vehicle.vehicle import Body, Mount, Vehicle, Wakes, Wing
from propmap.vehicle.vehicle_forces import VehicleForces, airframe
from propmap.vehicle.wakes import core_wakes
from tests.table.conftest import invented_content

WILD = (0.0, -1.0, 1e-300, 1e300, np.inf, -np.inf, np.nan)
TABLE = LoadTable(invented_content())
BLADE = propmap.propeller("apc-8x6e")
ALONE = (None, np.zeros(5))  # a free body without wakes


def test_any_number_has_loads_or_none() -> None:
    """One by one as in arrays; NaN where there are none, and finite inside."""
    ends = [each for low_high in TABLE.envelope.values() for each in low_high]
    numbers = (*WILD, *ends, *np.nextafter(ends, np.inf), *np.nextafter(ends, -np.inf), 600.0)
    points = np.array(list(itertools.product(numbers, repeat=3)))
    for clamp in (False, True):
        every = TABLE.loads(*points.T, clamp=clamp)
        lost = np.isin(every.status, ["outside", "no_value"])
        np.testing.assert_array_equal(np.isnan(every.thrust), lost)
        assert lost.any() and not lost.all()
        for k in range(0, len(points), 7):
            one = TABLE.loads(*points[k].tolist(), clamp=clamp)
            np.testing.assert_array_equal(one, [field[k] for field in every])
    slopes = TABLE.gradient(*points.T)
    assert np.isfinite(slopes.thrust[TABLE.loads(*points.T).inside]).all()


def test_a_free_body_has_the_forces_of_its_vehicle() -> None:
    """And where it has none, names the rotor and adds nothing."""
    places = ((0.1, 0.2, 0.0), (-0.1, 0.2, 0.01), (0.0, -0.2, 0.02))
    mounts = tuple(Mount(place, (0.0, 0.6, 0.8), spin) for place, spin in
                   zip(places, ("cw", "ccw", "cw"), strict=True))  # fmt: skip
    wing, body = Wing(0.05, 0.1, span=0.6), Body((0.01, 0.02, 0.03), 0.01, (0.004, 0.006))
    vehicle = Vehicle("tri", 1.2, BLADE, mounts, body=body, wing=wing)
    # The inflow of Coleman has no dynamics.
    coleman = (propmap.correction("coleman"),)
    rotor = propmap.Rotor(propmap.Model(BLADE, propmap.airfoil("paper-apc"), corrections=coleman))
    rows = np.array([[*m.position, *m.axis, 1.0 if m.spin == "ccw" else -1.0] for m in mounts])
    frame = airframe(body, wing, vehicle.air.density)
    free = core.FreeBody(rows, frame, [rotor._core] * 3, 0.0, np.zeros(3), False, *ALONE)
    omega, motion = np.array([500.0, 520.0, 500.0]), np.array([3.0, 1.0, 2.0, 0.1, 0.2, 0.3])
    still, pose = np.zeros(3), np.array([1.0, 2.0, 3.0, 2.0, 0.0, 0.0, 0.0])
    forces, codes, none = np.ones(6), np.zeros((2, 3), np.uint8), np.zeros(0)
    given = (pose, motion, still, omega, still, forces, codes)
    assert free.push(*given, none, none, 0.01, True) is None
    want = VehicleForces(vehicle, rotor).wrench(omega, motion[:3], motion[3:])
    np.testing.assert_allclose(forces[:3] - 1.0, want.force, rtol=1e-12)
    np.testing.assert_allclose(forces[3:] - 1.0, want.moment, rtol=0.0, atol=1e-12)

    sources = [rotor._core, TABLE._core, rotor._core]
    for wakes in (ALONE, core_wakes(vehicle, Wakes())):
        table = core.FreeBody(rows, frame, sources, 0.0, still, False, *wakes)
        for which, number in itertools.product((1, 0), WILD):
            omega[:], forces[:] = 500.0, 1.0
            omega[which] = number
            lost = table.push(*given, none, none, 0.01, True)
            assert lost == 1 if which == 1 else lost in (None, 0)
            assert lost is None or (forces == 1.0).all()
            assert lost != 1 or STATUSES[codes[0, 1]] == "outside"


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_any_flow_and_thrust_has_wakes_or_none() -> None:
    """A rotor with unknown thrust leaves the flow at the other rotors unknown, not its own."""
    vehicle = Vehicle("pair", 1.2, BLADE, (Mount((0.0, 0.2, 0.0)), Mount((0.1, -0.1, 0.02))))
    wakes, gains = core_wakes(vehicle, Wakes())
    points = np.array(list(itertools.product((*WILD, 3.0), repeat=3)))
    axial, inplane, thrust = np.stack([points, np.full_like(points, 2.0)], axis=-1).swapaxes(0, 1)
    axis = np.tile([1.0, 0.0, 0.0], (2 * len(points), 1))
    inflow, added, *_ = wakes.flow(
        gains, *(x.ravel() for x in (axial, inplane)), axis, thrust.ravel()
    )
    assert np.isfinite(added[:, 0]).all()
    known = np.isfinite(added[:, 1])
    assert not known[~np.isfinite(inflow[:, 0])].any()
    assert known[(abs(points) < 1e100).all(axis=1)].all() and added[-1].any()


def test_what_is_no_source_of_loads() -> None:
    rows = np.array([[0.1, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0]])
    with pytest.raises(RuntimeError):
        core.FreeBody(
            rows, airframe(Body(), None, 1.2), [object()], 0.0, np.zeros(3), False, *ALONE
        )
