"""The inflow and the angle of attack over the disk at one operating point."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable
from dataclasses import dataclass

import jax
import numpy as np
from numpy.typing import NDArray

from propmap.arrays.namespace import by_numpy
from propmap.physics.rotor import RotorArrays
from propmap.physics.velocities import azimuth_nodes
from propmap.solve.disk_field import DiskField, disk_field
from propmap.solve.problem import Case
from propmap.typing import Floats


@dataclass(frozen=True)
class Inflow:
    """Fields over the disk at one operating point; S stations and P azimuths.

    Attributes
    ----------
    radius : ndarray, shape (S,)
        y [m].
    azimuth : ndarray, shape (P,)
        psi [rad], pi/2 on the advancing side, 0 at the rear with respect to the in-plane velocity.
    inflow : ndarray, shape (S,)
        v_i(y) [m/s], positive against the thrust, its mean over azimuth.
    local_inflow : ndarray, shape (S, P)
        v_i [m/s]; the same at every azimuth where the model has no harmonics of it.
    thrust_per_radius, drag_per_radius, torque_per_radius : ndarray, shape (S,)
        Means over azimuth [N/m], [N/m], [N].
    alpha : ndarray, shape (S, P)
        Angle of attack from the chord line [rad], in (-pi, pi].
    u_tangential, u_normal : ndarray, shape (S, P)
        The section velocities (1) and (2) [m/s].
    past_stall : ndarray, shape (S, P)
        How far alpha is past the stall angle, negative before it [rad].
    stalled : ndarray, shape (S, P)
        Where ``past_stall`` is positive.
    reverse : ndarray, shape (S, P)
        Where the air meets the section from behind.
    normal_force : ndarray, shape (S, P)
        Force along the axis on one blade per radius [N/m].
    """

    radius: Floats
    azimuth: Floats
    inflow: Floats
    local_inflow: Floats
    thrust_per_radius: Floats
    drag_per_radius: Floats
    torque_per_radius: Floats
    alpha: Floats
    u_tangential: Floats
    u_normal: Floats
    past_stall: Floats
    stalled: NDArray[np.bool_]
    reverse: NDArray[np.bool_]
    normal_force: Floats


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
