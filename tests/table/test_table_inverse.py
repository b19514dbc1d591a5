"""From a load back to the rotational speed: round trips, none, several."""

from __future__ import annotations

import numpy as np
import pytest

from propmap.table import LoadTable

from .conftest import random_points


@pytest.mark.parametrize("quantity", ["thrust", "torque", "power"])
def test_there_and_back(invented: LoadTable, quantity: str) -> None:
    omega, speed, beta = random_points(invented, 60, seed=4)
    value = getattr(invented.loads(omega, speed, beta), quantity)
    found = invented.omega_for(quantity, value, speed, beta)
    assert (found.status != "none").all()
    single = found.status == "ok"
    assert single.sum() > 30
    np.testing.assert_allclose(found.omega[single], omega[single], rtol=1e-9)
    for name in ("omega", "least"):
        again = getattr(invented.loads(getattr(found, name), speed, beta), quantity)
        np.testing.assert_allclose(again, value, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(("quantity", "end"), [("thrust", 0), ("torque", 1), ("power", 1)])
def test_the_ends_of_the_envelope_are_answered(
    invented: LoadTable, table: LoadTable, quantity: str, end: int
) -> None:
    """A request for the load at the fastest or slowest omega, however it was computed."""
    for source in (invented, table):
        omega = source.envelope["omega"][end]
        _, speed, beta = random_points(source, 40, seed=12)
        together = getattr(source.loads(omega, speed, beta), quantity)
        alone = [
            getattr(source.loads(omega, v, b), quantity)
            for v, b in zip(speed.tolist(), beta.tolist(), strict=True)
        ]
        for value in (together, alone, together * (1.0 + 4e-16), together * (1.0 - 4e-16)):
            found = source.omega_for(quantity, value, speed, beta)
            assert (found.status != "none").all()
            np.testing.assert_allclose(
                found.omega if end else found.least, omega, rtol=1e-12, err_msg=repr(source)
            )


def test_impossible_requests_have_none(invented: LoadTable) -> None:
    low, high = (float(invented.loads(w, 0.0, 0.0).thrust) for w in invented.envelope["omega"])
    wanted = [low * (1.0 - 1e-9), high * (1.0 + 1e-9), 1.0, np.nan]
    found = invented.omega_for("thrust", wanted, [0.0, 0.0, 99.0, 1.0], 0.0)
    assert found.status.tolist() == ["none"] * 4
    assert found.solutions.tolist() == [0] * 4
    assert np.isnan(found.omega).all() and np.isnan(found.least).all()


def test_thrust_that_falls_and_rises_again_has_several(invented: LoadTable) -> None:
    # Thrust over omega^2 is 0.016 - 0.08 J + 0.02 J^2 in climb: least thrust at J = 0.4.
    omega = np.linspace(200.0, 1000.0, 4001)
    speed = 0.95 * invented.envelope["speed"][1]
    thrust = invented.loads(omega, speed, 0.0).thrust
    lowest = int(np.argmin(thrust))
    assert 0 < lowest < omega.size - 1
    wanted = thrust[lowest] + 1e-6 * (thrust.max() - thrust[lowest])
    found = invented.omega_for("thrust", wanted, speed, 0.0)
    assert found.status == "several"
    assert found.solutions == 2
    assert found.least < omega[lowest] + 1.0 and found.omega > omega[lowest] - 1.0
    assert invented.omega_for("thrust", thrust[lowest] - 1e-3, speed, 0.0).status == "none"
