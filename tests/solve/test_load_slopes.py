"""Derivatives in two passes over the azimuth are those of the loads as they stand."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from propmap.physics.parameters import Resolution, Section

import propmap as pm
from propmap.engine.batch import nodes_of_each
from propmap.solve.disk import solve_disk
from propmap.solve.load_slopes import LOADS, MOVING, directions_of, load_slopes
from propmap.solve.rotor_loads import case_of, disk_loads

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
    blade, section, medium = rotor.arrays
    v_hover = np.asarray(rotor.hover_inflow(OMEGA))
    nodes = nodes_of_each(AZIMUTHS, 24)
    with jax.enable_x64(True):
        flow = tuple(jnp.asarray(a) for a in (OMEGA, V_AXIAL, V_INPLANE, v_hover))
        law = jnp.stack([jnp.asarray(value) for value in section])

        def loads(moved: Any) -> Any:
            *values, w, v_axial, v_inplane = moved
            here = (flow[0] + w, flow[1] + v_axial, flow[2] + v_inplane, flow[3])
            section = Section(*(a + b for a, b in zip(law, values, strict=True)))
            found = disk_loads(blade, section, medium, *here, PANELS, nodes)
            return jnp.stack([getattr(found, name) for name in LOADS])

        def along(way: Any) -> Any:
            return jax.jvp(loads, (jnp.zeros(len(MOVING)),), (way,))[1]

        ways = np.eye(len(MOVING))[[MOVING.index(name) for name in NAMES]]
        want = np.asarray(jax.jit(jax.vmap(along))(ways))

        def two_passes(directions: Any) -> Any:
            case = case_of(blade, section, medium, *flow)
            solution, _ = solve_disk(case, PANELS, nodes)
            still = jnp.zeros((len(NAMES), OMEGA.size))
            return load_slopes(case, solution, flow[3], PANELS, nodes, directions, still)

        got = np.asarray(jax.jit(two_passes)(directions_of(NAMES, len(NAMES))))
    scale = np.max(np.abs(want), axis=2, keepdims=True)
    assert (scale[:, 0] > 0.0).all()
    np.testing.assert_allclose(got / scale, want / scale, atol=1e-9)
