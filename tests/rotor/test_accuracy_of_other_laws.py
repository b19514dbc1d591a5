"""The accuracy promised holds for any section law, or a status says that it may not.

Errors are shares of static thrust and torque (rolling moment: of thrust times radius); of
rho A (Omega R)^2 / 2 times the solidity (torque: times R) where the blade is stalled at rest.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

import propmap as pm
from propmap.loads import LOADS
from propmap.results import Loads
from tests.oracle.make_reference import LAW, frozen_rows
from tests.other_laws import Flow, OtherRotor, error_scales_of, other_flow, other_rotors

FLOW = ("omega", "v_axial", "v_inplane")

PROMISED = 1e-3
"""A share of the static load."""

COARSE_AT_MOST = 0.005
"""Share of points with that status."""


def loads(model: pm.Model, flow: Flow, accuracy: str = "standard") -> Loads:
    """Loads of a rotor at each point."""
    omega, along, across = flow
    velocity = np.stack([across, np.zeros_like(across), along], axis=-1)
    return pm.Rotor(model, accuracy=accuracy).loads_at_velocity(omega, velocity)


def errors_of(
    model: pm.Model, flow: Flow, truth: Mapping[str, ArrayLike] | None = None
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Largest error [-] of the loads against the truth or "fine", and whether it is "coarse"."""
    got, scales = loads(model, flow), error_scales_of(model, flow[0])
    truth = vars(loads(model, flow, "fine")) if truth is None else truth
    errors = [np.abs(getattr(got, k) - truth[k]) / scales[k] for k in LOADS if k in truth]
    return np.max(errors, axis=0), got.status == "coarse"


def test_a_fit_of_a_user_meets_what_is_promised() -> None:
    """No point is even coarse, the once worst one and 20 random ones."""
    law = pm.Airfoil(c_l1=6.59, c_l2=0.302, c_d=1.3, alpha_0=0.39, zero_lift_angle=-0.048)
    model = pm.Model(pm.propeller("apc-8x6e"), law)
    beta = np.radians(88.0)
    worst = (3578.0 * np.pi / 30.0, 9.6 * np.cos(beta), 9.6 * np.sin(beta))
    flow = tuple(np.append(one, w) for one, w in zip(other_flow(20, 25), worst, strict=True))
    error, coarse = errors_of(model, flow)
    assert error.max() < PROMISED and not coarse.any()


def test_other_laws_meet_what_is_promised_against_the_literal_reference() -> None:
    """The reference shares no code with the package."""
    rows: dict[OtherRotor, list[Any]] = {}
    for row in frozen_rows("reference_loads_other_laws"):
        law = pm.Airfoil(**{name: getattr(row, name) for name in LAW})
        rows.setdefault(OtherRotor(row.blade, int(row.blades), law), []).append(row)
    parts = []
    for one, mine in rows.items():
        columns = {k: np.array([getattr(row, k) for row in mine]) for k in list(vars(mine[0]))[9:]}
        flow = tuple(columns[k] for k in FLOW)
        parts.append(errors_of(pm.Model(one.propeller(), one.airfoil), flow, columns))
    error, coarse = np.concatenate(parts, axis=1)
    assert error.size == 300
    assert (error[coarse == 0] < PROMISED).all()
    assert coarse.mean() < COARSE_AT_MOST


@pytest.mark.slow
def test_twenty_thousand_points_meet_what_is_promised_or_say_so() -> None:
    parts = [
        errors_of(pm.Model(one.resampled(), one.airfoil), other_flow(200, k))
        for k, one in enumerate(other_rotors(100, seed=1000), start=1000)
    ]
    error, coarse = np.concatenate(parts, axis=1)
    assert error.size == 20_000
    unsaid = error[~(error < PROMISED) & (coarse == 0)]
    assert unsaid.size == 0, unsaid
    assert coarse.mean() < COARSE_AT_MOST


def test_what_no_nodes_resolve_is_said() -> None:
    """A blade stalled at rest, whose annuli attach and stall by turns in slow climb."""
    law = pm.Airfoil(
        c_l1=5.86, c_l2=0.04, c_d=1.24, alpha_0=0.23, zero_lift_angle=-0.12, sharpness=110.0
    )
    model = pm.Model(pm.propeller("apc-9x6e", blades=3), law)
    slow, fast = pm.Rotor(model).loads(600.0, [3.0508, 12.0], 0.0), pm.Rotor(model, accuracy="fine")
    assert slow.status[1] == "ok"
    assert np.isfinite(slow.thrust).all()
    truth = fast.loads(600.0, 3.0508, 0.0)
    scale = float(fast.loads(600.0, 0.0, 0.0).thrust)
    # Said, or resolved.
    assert slow.status[0] == "coarse" or abs(slow.thrust[0] - truth.thrust) < PROMISED * scale


def test_a_blade_without_lift_is_not_judged_by_it() -> None:
    """Nor are errors of a rotor at rest in a wind divided by nothing."""
    blade = pm.propeller("apc-8x6e")
    flat = pm.Propeller("flat", 2, blade.station, blade.chord, 0.0 * blade.twist)
    rotor = pm.Rotor(pm.Model(flat, pm.airfoil("paper-apc")))
    found = rotor.loads([600.0, 0.0, 0.0], [0.0, 0.0, 9.0], [0.0, 0.0, np.pi / 2])
    assert (found.status[:2] == "ok").all()
    assert np.isfinite(found.thrust).all()
