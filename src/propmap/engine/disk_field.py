"""The inflow and the angle of attack over the disk at one operating point."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable

import jax
import numpy as np

from propmap.arrays.namespace import by_numpy
from propmap.physics.rotor import RotorArrays
from propmap.physics.velocities import azimuth_nodes
from propmap.results import Inflow
from propmap.solve.disk_field import DiskField, disk_field
from propmap.solve.problem import Case
from propmap.typing import Floats


def look_at_disk(
    rotor: RotorArrays,
    flow: tuple[float, float, float, float],
    radius: Floats,
    azimuth: Floats,
    *,
    compiled: bool,
) -> Inflow:
    """The fields over the disk at one operating point.

    Parameters
    ----------
    rotor : RotorArrays
        Blade, section law and air.
    flow : tuple of 4 float
        omega [rad/s], and v_axial, v_inplane, v_hover [m/s].
    radius, azimuth : ndarray, shape (S,), (P,)
        [m] and [rad].
    compiled : bool
        Whether JAX compiles the program; else NumPy runs it.
    """
    nodes = azimuth_nodes(1 if flow[2] == 0.0 else 128)
    case = Case(rotor, *(np.array([value]) for value in flow))  # type: ignore[arg-type]
    with jax.enable_x64(True), contextlib.nullcontext() if compiled else by_numpy():
        solve: Callable[..., DiskField] = _program() if compiled else disk_field
        found = solve(case, radius, azimuth, nodes)
        fields = jax.tree.map(np.asarray, found)
    return Inflow(
        radius=radius,
        azimuth=azimuth,
        inflow=fields.inflow,
        local_inflow=fields.local_inflow,
        thrust_per_radius=fields.per_radius.thrust,
        drag_per_radius=fields.per_radius.drag,
        torque_per_radius=fields.per_radius.torque,
        alpha=(fields.alpha + np.pi) % (2.0 * np.pi) - np.pi,
        u_tangential=fields.u_t,
        u_normal=fields.u_p,
        past_stall=fields.past_stall,
        stalled=fields.past_stall > 0.0,
        reverse=fields.u_t < 0.0,
        normal_force=fields.normal_force,
    )


@functools.cache
def _program() -> Callable[..., DiskField]:
    return jax.jit(disk_field)
