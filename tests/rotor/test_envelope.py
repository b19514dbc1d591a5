"""Random operating points: finite, or NaN with a status that says why."""

from __future__ import annotations

import numpy as np
import pytest

import propmap as pm
from propmap.loads import LOADS
from propmap.results import STATUSES, Loads


def _random(points: int, airfoil: str, seed: int) -> Loads:
    rng = np.random.default_rng(seed)
    omega, speed = rng.uniform(0.0, 1500.0, points), rng.uniform(0.0, 40.0, points)
    rotor = pm.Rotor(pm.Model(pm.propeller("apc-8x6e"), pm.airfoil(airfoil)))
    return rotor.loads(omega, speed, np.deg2rad(rng.uniform(0.0, 180.0, points)))


def _check(loads: Loads) -> None:
    lost = loads.status == "not_converged"
    for name in (*LOADS, "power"):
        values = getattr(loads, name)
        assert np.isfinite(values[~lost]).all()
        assert np.isnan(values[lost]).all()
    assert set(np.unique(loads.status)) <= set(STATUSES)
    assert lost.sum() <= lost.size / 10_000
    assert np.all((loads.reverse_flow >= 0.0) & (loads.reverse_flow <= 1.0))
    assert np.all((loads.vortex_ring >= 0.0) & (loads.vortex_ring <= 1.0))


@pytest.mark.parametrize("airfoil", ["paper-soft", "paper-stiff", "paper-apc"])
def test_random_points_are_finite_or_say_why(airfoil: str) -> None:
    loads = _random(4_000, airfoil, seed=1)
    _check(loads)
    assert {"ok", "multiple_roots", "windmill", "vortex_ring"} <= set(np.unique(loads.status))


@pytest.mark.slow
def test_forty_thousand_random_points() -> None:
    _check(_random(40_000, "paper-apc", seed=2))


def test_rest_is_rest() -> None:
    loads = pm.Rotor(pm.Model(pm.propeller("apc-8x6e"), pm.airfoil("paper-apc"))).loads(
        0.0, 0.0, 0.0
    )
    for name in (*LOADS, "power"):
        assert float(getattr(loads, name)) == 0.0
    assert loads.status == "ok"


@pytest.mark.parametrize("name", ["uiuc-apce-9x6", "uiuc-gwsdd-5x4.3", "apc-8x4.5mr"])
def test_other_propellers(name: str) -> None:
    rng = np.random.default_rng(3)
    blade = pm.propeller(name)
    tip = rng.uniform(10.0, 120.0, 300)
    rotor = pm.Rotor(pm.Model(blade, pm.airfoil("paper-apc")))
    speed, beta = rng.uniform(0.0, 20.0, 300), rng.uniform(0.0, np.pi, 300)
    loads = rotor.loads(tip / blade.radius, speed, beta)
    assert np.isfinite(loads.thrust).all()


BAD = {
    "negative omega": (-1.0, 1.0, 0.0),
    "negative speed": (100.0, -1.0, 0.0),
    "nan": (np.nan, 1.0, 0.0),
    "infinite beta": (100.0, 1.0, np.inf),
    "text": ("fast", 1.0, 0.0),
    "shapes": (np.ones(3), np.ones(2), 0.0),
}


@pytest.mark.parametrize("what", BAD)
def test_bad_operating_points_are_refused_in_one_line(what: str) -> None:
    rotor = pm.Rotor(pm.Model(pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")))
    with pytest.raises(pm.InputError) as caught:
        rotor.loads(*BAD[what])
    assert "\n" not in str(caught.value)


def test_wrong_kinds_are_refused() -> None:
    with pytest.raises(pm.InputError, match=r"propmap\.propeller"):
        pm.Rotor(pm.Model("apc-8x6e", pm.airfoil("paper-apc")))  # type: ignore[arg-type]
    with pytest.raises(pm.InputError, match="accuracy"):
        pm.Rotor(pm.Model(pm.propeller("apc-8x6e"), pm.airfoil("paper-apc")), accuracy="best")
