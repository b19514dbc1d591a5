"""How many roots equation (11) has at a station."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
from jax import lax

from propmap.theory.inflow import InflowQuestion, residual
from propmap.theory.parameters import Array
from propmap.theory.stall_split import inflow_at_angle
from propmap.theory.velocities import AzimuthNodes

_ABOUT_STALL = np.array([-0.05, -0.01, 0.02, 0.05, 0.1, 0.2])
"""[rad] from the stall angle at which the residual is sampled, on either side."""


def count_roots(ask: InflowQuestion, root: Array, azimuth: AzimuthNodes) -> Array:
    """Number of roots of (11), the largest over the stations; int (B,).

    root : the largest root (S, B) [m/s].  Below it the residual is positive until the next
    root.  It is sampled where the blade is near stall, which is where further roots arise,
    and changes of its sign are counted.  Roots closer to each other than the samples are
    missed: this is a diagnosis, the largest root does not depend on it.
    """
    stall = ask.at.section.alpha_0
    # In the order of falling v_i, that is of rising angle of attack.
    samples = jnp.concatenate(
        [-stall - jnp.asarray(_ABOUT_STALL[::-1]), stall + jnp.asarray(_ABOUT_STALL)]
    )
    margin = 1e-4 * (ask.at.omega * ask.at.radius + ask.at.v_inplane)

    def look(k: Array, state: tuple[Array, Array]) -> tuple[Array, Array]:
        count, was = state
        v = inflow_at_angle(ask, samples[k])
        below = v < root - margin
        value = residual(ask, jnp.where(below, v, 0.0), azimuth)
        now = jnp.where(below, jnp.sign(value), was)
        return count + (now != was), now

    start = (jnp.ones(root.shape, int), jnp.ones(root.shape))
    count, last = lax.fori_loop(0, len(samples), look, start)
    # Far below, the residual is positive: what is open at the end closes with one more.
    return jnp.max(count + (last < 0), axis=0)
