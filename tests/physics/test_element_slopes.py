"""Partial derivatives of the elements' forces are those of the loads of annuli."""

from __future__ import annotations

import functools
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import propmap as pm
from propmap.engine.rotor_arrays import rotor_arrays
from propmap.physics.element import annulus_loads
from propmap.physics.element_slopes import mean_slopes, moved_forces
from propmap.physics.inflow_harmonics import Harmonics
from propmap.physics.velocities import azimuth_nodes
from propmap.solve.followed_loads import loads_of_turn
from propmap.solve.moved_case import (
    GEOMETRY,
    RADIUS,
    change_of,
    motion_of,
    moved,
    moving,
    sources_of,
)
from propmap.solve.problem import Case, annulus_problem

BLADE = pm.propeller("apc-8x6e")
PAPER = pm.airfoil("paper-apc")
TERMS = pm.Airfoil(
    *(5.0, 1.6, 1.7, 0.38),
    zero_lift_angle=-0.05,
    c_d0=0.02,
    reynolds_camber=-0.02,
    drag_angle=0.07,
)
LAWS: dict[str, tuple[Any, tuple[str, ...]]] = {
    "the paper's": (PAPER, ()),
    "with both terms": (TERMS, ()),
    "wrapped": (TERMS, ("stall-delay", "prandtl-glauert", "tip-loss")),
}
RADII = np.array([0.02, 0.04, 0.07, 0.098])[:, None]
FLOW = [np.array(a) for a in ([600.0, 500.0, 300.0], [2.0, -1.0, 9.0], [9.0, 14.0, 3.0])]
INFLOW = np.array([[2.0, 1.0, 0.5]]) * np.array([[0.7], [1.0], [1.2], [0.8]])
CASES = {"the paper's": None, "with both terms": (0.2, 0.7, -1.1), "wrapped": None}
"""Harmonics of the inflow [m/s] with each law."""


@pytest.mark.slow
@pytest.mark.parametrize("law", CASES)
def test_forces_move_as_jax_says(law: str) -> None:
    """By every name, with reverse flow at the root, stall and descent among the points."""
    section, texts = LAWS[law]
    corrections = tuple(pm.correction(text) for text in texts)
    arrays = rotor_arrays(pm.Model(BLADE, section, corrections=corrections))
    azimuth, size = azimuth_nodes(12), CASES[law]
    names = (*moving(arrays), *GEOMETRY, RADIUS)

    def both(case: Case, radius: Any, inflow: Any) -> Any:
        harmonics = None if size is None else Harmonics(*(v + jnp.zeros(3) for v in size))
        at = annulus_problem(case, radius).at
        changes = {name: change_of(case, radius, inflow, name) for name in names}
        means = mean_slopes(at, inflow, azimuth, sources_of(at, changes), harmonics)

        def loads(name: str, x: Any) -> Any:
            here, y = (case, radius + x) if name == RADIUS else (moved(case, {name: x}), radius)
            return jnp.stack(annulus_loads(annulus_problem(here, y).at, inflow, azimuth, harmonics))

        got, want = {}, {}
        for name in names:
            motion = motion_of(at, name, changes[name])
            if name == RADIUS and harmonics is not None:
                sideways = (harmonics.lateral / at.tip, harmonics.longitudinal / at.tip)
                motion = motion._replace(lateral=sideways[0], longitudinal=sideways[1])
            got[name] = jnp.stack(loads_of_turn(at, moved_forces(means, motion)))
            _, want[name] = jax.jvp(functools.partial(loads, name), (0.0,), (1.0,))
        return got, want

    with jax.enable_x64(True):
        found = jax.jit(both)(Case(arrays, *FLOW, None), RADII, INFLOW)
    for name in names:
        got, want = (np.asarray(part[name]) for part in found)
        if name == "drag_factor":
            continue  # it leaves the forces of an element alone
        # The moments' arms are not the elements' affair.
        kept = [0, 1, 4] if name == RADIUS else list(range(6))
        scale = np.abs(want).max(axis=(1, 2), keepdims=True)
        assert scale[0] > 1e-9, name
        assert (np.abs(got - want) <= 1e-12 * scale + 1e-18)[kept].all(), name
