"""Prandtl's factor is the printed one, with its derivative."""

from __future__ import annotations

import numpy as np
import pytest

import propmap as pm
from propmap.arrays.namespace import by_numpy
from propmap.physics.element import Annulus, Station
from propmap.physics.tip_loss import LEAST_REACH, PrandtlLoss

BLADES, ROOT, TIP, OMEGA = 3.0, 0.02, 0.1, 500.0


def factor(loss: PrandtlLoss, radius: float, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """F and its slope where the air passes the disk at ``u`` [m/s], half of it by the inflow."""
    y = np.full((1, 1), radius)
    station = Station(y, 0.1 * y, 0.2 * y, 1.0 + 0.0 * y, y, y)
    flow = (np.full(u.size, OMEGA), 0.5 * u, np.full(u.size, 7.0))
    at = Annulus(station, *flow, *(np.float64(a) for a in (BLADES, ROOT, TIP)), law=None)  # type: ignore[arg-type]
    with by_numpy():
        f, slope = loss.factor_slope(at, 0.5 * u[None])
    return np.asarray(f)[0], np.asarray(slope)[0]


SPEEDS = np.array([-30.0, -3.0, 0.4, 5.0, 40.0])


@pytest.mark.parametrize("radius", [0.021, 0.05, 0.09, 0.0999])
@pytest.mark.parametrize("hub", [None, 0.02])
def test_factor_is_prandtls(radius: float, hub: float | None) -> None:
    loss = PrandtlLoss() if hub is None else PrandtlLoss(np.float64(hub))  # type: ignore[arg-type]
    sine = np.abs(SPEEDS) / np.hypot(SPEEDS, OMEGA * radius)
    if hub is None:
        f = 0.5 * BLADES * (TIP - radius) / (radius * sine)
    else:
        f = 0.5 * BLADES * (radius - hub) / (hub * sine)
    got, slope = factor(loss, radius, SPEEDS)
    np.testing.assert_allclose(got, 2.0 / np.pi * np.arccos(np.exp(-f)), rtol=1e-12)
    up, down = (factor(loss, radius, SPEEDS + 2.0 * h)[0] for h in (1e-5, -1e-5))
    # ``SPEEDS`` is shared by V cos(beta) and v_i, so twice as much is added to it.
    np.testing.assert_allclose(slope, (up - down) / 4e-5, rtol=1e-5, atol=1e-9)


def test_nothing_is_lost_where_no_air_passes() -> None:
    f, slope = factor(PrandtlLoss(), 0.09, np.array([0.0, 1e-12]))
    np.testing.assert_allclose(f, 1.0, rtol=1e-15)
    np.testing.assert_allclose(slope, 0.0, atol=1e-15)


def test_the_factor_is_held_at_the_very_tip() -> None:
    """Instead of zero, by which the search would divide."""
    (at_tip,), _ = factor(PrandtlLoss(), TIP, np.array([40.0]))
    sine = 40.0 / np.hypot(40.0, OMEGA * TIP)
    assert at_tip == pytest.approx(2.0 / np.pi * np.arccos(np.exp(-LEAST_REACH / sine)), rel=1e-9)


def test_each_correction_changes_the_loads() -> None:
    blade, law = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")
    found = {
        text: float(
            pm.Rotor(
                pm.Model(blade, law, corrections=tuple(map(pm.correction, text.split()))),
                compiled=False,
            )
            .loads(600.0, 4.0, 1.0)
            .thrust
        )
        for text in ("", "tip-loss", "hub-loss", "hub-loss:radius_m=0.012")
    }
    assert found["tip-loss"] < 0.99 * found[""]
    assert len({round(value, 6) for value in found.values()}) == 4
