"""Loads where the search for the inflow takes its rare paths: folds, stall, vortex ring, descent.

Another path gives loads that differ by less than the promised 1e-3 of the loads at rest, so a
comparison with the literal reference does not notice it.  `make bench ONLY=convergence` compares
such points with the literal reference.
"""

from __future__ import annotations

import numpy as np
import pytest

import propmap as pm

FROZEN = [  # propeller, model, Omega [rad/s], V [m/s], beta [rad]; T [N], tau and roll moment [N m]
    ("apc-8x6e", "recommended", 605.14, 27.16, 1.367, "ok", 2.7824201, 0.046854467, 0.10696819),
    (
        "uiuc-apcsf-10x4.7",
        "paper",
        693.18,
        28.203,
        0.282,
        "ok",
        -8.9702251,
        -0.23341611,
        -0.00171967,
    ),
    ("apc-8x6e", "paper", 511.38, 7.983, 1.4335, "ok", 1.8533086, 0.028710609, 0.033439566),
    (
        "hqp-8x4.5",
        "paper",
        493.29,
        1.688,
        1.7368,
        "multiple_roots",
        1.2948158,
        0.017502981,
        0.00597884,
    ),
    ("apc-8x6e", "paper", 427.16, 5.505, 1.3264, "ok", 1.2171994, 0.019817824, 0.018906402),
    ("hqp-8x4.5", "paper", 558.71, 9.789, 0.022, "ok", 0.05777490, 0.0050532631, 0.00057814),
    (
        "uiuc-apcsf-10x4.7",
        "recommended",
        700.84,
        27.092,
        0.1555,
        "ok",
        -8.7673685,
        -0.22274839,
        0.00118365,
    ),
    ("apc-11x7e", "paper", 663.63, 11.795, 1.3251, "ok", 7.7632775, 0.14656784, 0.16628093),
    ("hqp-8x4.5", "paper", 1074.13, 8.962, 1.6899, "ok", 6.7639855, 0.082713907, 0.070732967),
    ("apc-8x6e", "paper", 608.25, 1.371, 3.1226, "vortex_ring", 2.4854390, 0.039431264, 0.00013538),
]


@pytest.mark.parametrize("row", FROZEN, ids=lambda row: f"{row[0]} {row[2]} {row[3]}")
def test_loads_near_folds_and_in_descent(row: tuple) -> None:
    propeller, model, omega, speed, beta, status, *loads = row
    corrections = pm.model_corrections(model)
    blade, law = pm.propeller(propeller), pm.airfoil("paper-apc")
    rotor = pm.Rotor(pm.Model(blade, law, corrections=corrections))
    found, rest = rotor.loads(omega, speed, beta), rotor.loads(omega, 0.0, 0.0)
    assert str(found.status) == status
    size = [float(rest.thrust), float(rest.torque), float(rest.torque)]
    error = np.array([found.thrust, found.torque, found.roll_moment]) - loads
    assert np.abs(error / size).max() < 2e-6


def test_the_share_of_reverse_flow_is_an_area() -> None:
    """Elements with Omega y + V sin(beta) sin(psi) < 0, from the root to the tip."""
    blade = pm.propeller("apc-8x6e")
    omega, speed = 300.0, np.array([4.0, 12.0, 40.0])
    found = (
        pm.Rotor(pm.Model(blade, pm.airfoil("paper-apc")))
        .loads(omega, speed, 0.5 * np.pi)
        .reverse_flow
    )
    edge = np.linspace(blade.root, blade.radius, 2001)
    y, psi = 0.5 * (edge[1:] + edge[:-1])[:, None], (np.arange(4000) + 0.5) * (np.pi / 2000)
    shares = [np.mean((omega * y + v * np.sin(psi) < 0.0) * y) / y.mean() for v in speed]
    assert found == pytest.approx(shares, abs=2e-4)
