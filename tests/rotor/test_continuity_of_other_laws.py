"""No jumps of the loads with losses at tip and hub or a tabulated section, descent included."""

from __future__ import annotations

import numpy as np
import pytest

import propmap as pm
from tests.rotor.test_largest_root import BLADE, COARSE, LAWS

LINES = {
    "speed, 45 deg": lambda s: (600.0 + 0 * s, 3.0 * s, np.pi / 4 + 0 * s),
    "omega, 1 m/s": lambda s: (200.0 + 800.0 * s, 1.0 + 0 * s, 1.0 + 0 * s),
    "beta, 3 m/s": lambda s: (600.0 + 0 * s, 3.0 + 0 * s, np.pi / 2 * s),
    "descent, 165 deg": lambda s: (600.0 + 0 * s, 11.0 * s, np.radians(165.0) + 0 * s),
    "descent, 105 deg": lambda s: (600.0 + 0 * s, 11.0 * s, np.radians(105.0) + 0 * s),
}
STEPS = 121

LIMITS = {"tip loss": 1e-4, "hub loss": 1e-3, "coarse table": 1e-3}
"""A share of static thrust, in climb.  With the paper's law and with tip loss there are two folds,
whose radii are followed, so that loads do not step.  With hub loss there are three, and a table
stalls at another angle for each Reynolds number: there, as with any law in descent, nodes flip at
some points, and loads step by the error of "standard" at most."""

SOONER = {
    ("tip loss", "beta, 3 m/s"),
    ("hub loss", "descent, 165 deg"),
    ("coarse table", "beta, 3 m/s"),
}


def cases() -> list[object]:
    return [
        pytest.param(name, line, marks=() if (name, line) in SOONER else (pytest.mark.slow,))
        for name in LIMITS
        for line in LINES
    ]


@pytest.mark.parametrize(("name", "line"), cases())
def test_loads_do_not_jump_with_the_operating_point(name: str, line: str) -> None:
    """The steps that stand out, and the largest ones, become small when zoomed in on."""
    _, law, losses = LAWS[name]
    corrections = tuple(pm.correction(text) for text in losses)
    rotor = pm.Rotor(pm.Model(BLADE, law or COARSE, corrections=corrections))
    static = float(rotor.loads(600.0, 0.0, 0.0).thrust)

    def thrust(s: np.ndarray) -> np.ndarray:
        omega, speed, beta = LINES[line](s)
        found = rotor.loads(omega, speed, beta)
        assert np.all(found.status != "not_converged")
        return found.thrust / (static * (omega / 600.0) ** 2)

    s = np.linspace(0.0, 1.0, STEPS)
    step = np.abs(np.diff(thrust(s)))
    stands_out = step[1:-1] - np.maximum(step[:-2], step[2:])
    k = np.union1d(1 + np.argsort(stands_out)[-3:], np.argsort(step)[-2:])
    low, high, each = s[k], s[k + 1], np.arange(k.size)
    for _ in range(3):
        fine = low[:, None] + (high - low)[:, None] * np.linspace(0.0, 1.0, 17)
        step = np.abs(np.diff(thrust(fine), axis=1))
        j = step.argmax(axis=1)
        low, high = fine[each, j], fine[each, j + 1]
    limit = max(LIMITS[name], 1e-3 * line.startswith("descent"))
    assert step.max() < limit, f"{step.max():.1e} at s = {low[step.max(axis=1).argmax()]}"
