"""Loads with their derivatives by section parameters, for batches: what a fit needs."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from propmap.blocks import Block, cut, padded_azimuths, run
from propmap.evaluation import Prepared, advance_ratio
from propmap.schedule import Accuracy, Floats, Outlook, may_leave_islands, plan
from propmap.theory.loads import disk_loads
from propmap.theory.momentum import static_inflow
from propmap.theory.parameters import Blade, Medium, Section
from propmap.theory.velocities import AzimuthNodes

LOADS = ("thrust", "drag", "torque", "roll_moment")

BLOCK = 8
"""Operating points per call of a compiled program: with their derivatives they fill the vector
units, and a fit's few points per number of azimuth nodes leave less of a block unused."""


DIRECTIONS = 8
"""Parameters for which programs are compiled.  With fewer, some directions go along idle: they
fill the vector units as well as fewer would, and other parameters need no other program."""


class LoadGradients(NamedTuple):
    """Loads (4, N) in the order of ``LOADS`` [N], [N], [N m], [N m], NaN where not found, and
    their derivatives (4, P, N) per unit of each parameter."""

    loads: Floats
    slopes: Floats


def load_gradients(
    rotor: Prepared,
    setting: Accuracy,
    names: tuple[str, ...],
    omega: Floats,
    v_axial: Floats,
    v_inplane: Floats,
) -> LoadGradients:
    """Loads at N operating points and their derivatives by P parameters of ``Section``.

    names : the parameters.  omega [rad/s], velocities [m/s] : (N,), v_inplane >= 0.
    Stall is followed wherever the advance ratio allows, foreseen or not: one program less to
    compile, at a higher cost per point.
    """
    ways = _directions(names)
    v_hover, v_hover_slope = np.zeros_like(omega), np.zeros((len(ways), omega.size))
    down = v_axial < 0.0
    if down.any():
        rates, where = np.unique(omega[down], return_inverse=True)
        still = np.zeros_like(rates)
        static = load_gradients(rotor, setting, names, rates, still, still)
        v, slope = _static_inflow(rotor, static)
        v_hover[down] = v[where]
        v_hover_slope[: len(names), down] = slope[:, where]
    everyone = np.arange(omega.size)
    advance = advance_ratio(rotor, omega, v_inplane)
    islands = may_leave_islands(v_axial, v_hover)
    outlook = Outlook(advance, np.ones(omega.size, bool), down, islands)
    jobs = plan(setting, outlook, everyone)
    loads = np.full((len(LOADS), omega.size), np.nan)
    slopes = np.full((len(LOADS), len(names), omega.size), np.nan)
    flow = (omega, v_axial, v_inplane, v_hover)

    def one(block: Block) -> None:
        count, which, kept = block.job.azimuths, block.padded, block.points
        nodes = padded_azimuths(count, setting.most_azimuths)
        with jax.enable_x64(True):
            program = _program(block.job.panels)
            moving = v_hover_slope[:, which]
            found = program(*rotor.on_device, *(a[which] for a in flow), ways, moving, nodes)
            values, derivatives = (np.asarray(a) for a in found)
        loads[:, kept] = values[:, : kept.size]
        by_name = derivatives[: len(names)].transpose(1, 0, 2)
        slopes[:, :, kept] = by_name[:, :, : kept.size]

    run(cut(jobs, BLOCK), one)
    return LoadGradients(loads, slopes)


def _static_inflow(rotor: Prepared, static: LoadGradients) -> tuple[Floats, Floats]:
    """v_h (N,) [m/s], eq. (12), and its derivatives (P, N)."""
    thrust, slope = static.loads[0], static.slopes[0]
    density, tip = rotor.theory[2].density, rotor.theory[0].station[-1]
    with jax.enable_x64(True):
        found: Any = jax.jvp(
            lambda t: static_inflow(t, density, tip),
            (jnp.asarray(thrust),),
            (jnp.ones_like(thrust),),
        )
    v, per_thrust = (np.asarray(a) for a in found)
    return v, per_thrust * slope


def _directions(names: tuple[str, ...]) -> Floats:
    """One row per parameter, 1 at its place in ``Section``; then idle rows of zeros."""
    ways = np.zeros((max(DIRECTIONS, len(names)), len(Section._fields)))
    for row, name in enumerate(names):
        ways[row, Section._fields.index(name)] = 1.0
    return ways


@functools.cache
def _program(panels: tuple[int, ...]) -> Callable[..., Any]:
    def with_slopes(
        blade: Blade,
        section: Section,
        medium: Medium,
        omega: Any,
        v_axial: Any,
        v_inplane: Any,
        v_hover: Any,
        directions: Any,
        v_hover_slope: Any,
        azimuth: AzimuthNodes,
    ) -> Any:
        def loads(values: Any, v_hover: Any) -> Any:
            flow = (omega, v_axial, v_inplane, v_hover)
            found = disk_loads(blade, Section(*values), medium, *flow, panels, azimuth)
            return jnp.stack([getattr(found, name) for name in LOADS])

        values = jnp.stack([jnp.asarray(value) for value in section])

        def along(direction: Any, v_hover_change: Any) -> Any:
            return jax.jvp(loads, (values, v_hover), (direction, v_hover_change))

        return jax.vmap(along, out_axes=(None, 0))(directions, v_hover_slope)

    return jax.jit(with_slopes)
