"""Derivatives in two passes over the azimuth are those of the loads as they stand."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import propmap as pm
from propmap.engine.batch import nodes_of_each
from propmap.solve.disk import solve_disk
from propmap.solve.load_slopes import FLOW, directions_of, load_slopes, moving
from propmap.solve.problem import Case
from propmap.solve.resolution import Resolution
from propmap.solve.rotor_loads import disk_loads

NAMES = ("c_l1", "c_d", "alpha_0", "zero_lift_angle", "omega", "v_axial", "v_inplane")
PANELS = Resolution(stations=48).panels

# Hover and slow climb with a fold, oblique with stall spread over azimuth, attached, descent in
# the vortex ring and on the windmill branch.
OMEGA = np.array([628.0, 900.0, 600.0, 500.0, 700.0, 600.0])
V_AXIAL = np.array([0.0, 1.0, 4.0, 9.0, -4.0, -14.0])
V_INPLANE = np.array([0.0, 0.0, 9.0, 5.0, 1.0, 0.5])
AZIMUTHS = np.array([8, 8, 24, 16, 8, 8])


@pytest.mark.slow
def test_two_passes_give_what_differentiation_of_the_whole_does() -> None:
    rotor = pm.Rotor(pm.Model(pm.propeller("apc-8x6e"), pm.airfoil("paper-soft")))
    arrays = rotor.arrays
    movable = moving(arrays)
    v_hover = np.asarray(rotor.hover_inflow(OMEGA))
    nodes = nodes_of_each(AZIMUTHS, 24)
    with jax.enable_x64(True):
        flow = tuple(jnp.asarray(a) for a in (OMEGA, V_AXIAL, V_INPLANE, v_hover))

        def loads(moved: Any) -> Any:
            change = dict(zip(movable, moved, strict=True))
            omega, v_axial, v_inplane = (change.pop(name) for name in FLOW)
            rotor = arrays._replace(law=arrays.law.plus(**change))
            here = (flow[0] + omega, flow[1] + v_axial, flow[2] + v_inplane, flow[3])
            found = disk_loads(Case(rotor, *here), PANELS, nodes)
            return jnp.stack(found.loads)

        def along(way: Any) -> Any:
            return jax.jvp(loads, (jnp.zeros(len(movable)),), (way,))[1]

        ways = np.eye(len(movable))[[movable.index(name) for name in NAMES]]
        want = np.asarray(jax.jit(jax.vmap(along))(ways))

        def two_passes(directions: Any) -> Any:
            case = Case(arrays, *flow)
            solution, _ = solve_disk(case, PANELS, nodes)
            still = jnp.zeros((len(NAMES), OMEGA.size))
            return load_slopes(case, solution, PANELS, nodes, directions, still)

        got = np.asarray(jax.jit(two_passes)(directions_of(movable, NAMES, len(NAMES))))
    scale = np.max(np.abs(want), axis=2, keepdims=True)
    assert (scale[:, 0] > 0.0).all()
    scale = np.where(scale > 0.0, scale, 1.0)  # the paper's rotor has no force across
    np.testing.assert_allclose(got / scale, want / scale, atol=1e-9)
