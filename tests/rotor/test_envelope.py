"""Random operating points: finite, or NaN with a status that says why."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import propmap as pm
from propmap.loads import LOADS
from propmap.results import STATUSES

BLADE, LAW = pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")

CASES = {
    "paper-soft": pm.Model(BLADE, pm.airfoil("paper-soft")),
    "another blade": pm.Model(pm.propeller("uiuc-gwsdd-5x4.3"), LAW),
    "all corrections": pm.Model(
        BLADE,
        LAW,
        corrections=tuple(map(pm.correction, ("pitt-peters", "blade-to-hub", "radial-friction"))),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_random_points_are_finite_or_say_why(name: str) -> None:
    points, rng, model = 1_500, np.random.default_rng(1), CASES[name]
    omega = rng.uniform(0.0, 150.0, points) / model.propeller.radius
    speed, beta = rng.uniform(0.0, 40.0, points), rng.uniform(0.0, np.pi, points)
    loads = pm.Rotor(model).loads(omega, speed, beta)
    lost = loads.status == "not_converged"
    for load in (*LOADS, "power"):
        values = getattr(loads, load)
        assert np.isfinite(values[~lost]).all()
        assert np.isnan(values[lost]).all()
    assert {"ok", "multiple_roots", "windmill", "vortex_ring"} <= set(loads.status) <= set(STATUSES)
    assert lost.sum() == 0
    for share in (loads.reverse_flow, loads.vortex_ring):
        assert np.all((share >= 0.0) & (share <= 1.0))


def test_rest_is_rest() -> None:
    loads = pm.Rotor(pm.Model(BLADE, LAW)).loads(0.0, 0.0, 0.0)
    for name in (*LOADS, "power"):
        assert float(getattr(loads, name)) == 0.0
    assert loads.status == "ok"


@pytest.mark.parametrize(
    ("point", "told"),
    [
        ((-1.0, 1.0, 0.0), "omega is negative"),
        ((100.0, -1.0, 0.0), "speed is negative"),
        ((100.0, 1.0, np.inf), "beta contains a value that is not finite"),
        (("fast", 1.0, 0.0), "omega"),
        ((np.ones(3), np.ones(2), 0.0), "shape"),
    ],
)
def test_bad_operating_points_are_refused(point: tuple[Any, ...], told: str) -> None:
    with pytest.raises(pm.InputError, match=told):
        pm.Rotor(pm.Model(BLADE, LAW)).loads(*point)


def test_wrong_kinds_are_refused() -> None:
    with pytest.raises(pm.InputError, match=r"propmap\.propeller"):
        pm.Rotor(pm.Model("apc-8x6e", LAW))  # type: ignore[arg-type]
    with pytest.raises(pm.InputError, match="accuracy"):
        pm.Rotor(pm.Model(BLADE, LAW), accuracy="best")
