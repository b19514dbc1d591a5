"""Lanes: programs that evaluate a few operating points at a time, compiled as one function.

XLA on a CPU splits a program into kernels of a few operations and calls one after the other.  Each
call has a cost, so that a kernel has to serve many points.  But then all points wait for the
slowest root, all get as many azimuths as the one with most, and padding is computed too.

With a few points at a time these losses are gone, and their arrays stay in the innermost cache.
That pays only if XLA compiles all kernels into one function.  It does so for a call with the mark
that XLA itself puts on short loops.  The mark is undocumented, hence ``KNOWN_JAXLIB``.
"""

from __future__ import annotations

import functools
import importlib.metadata
import math
from collections.abc import Callable
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
from jax import lax
from jax.experimental.xla_metadata import set_xla_metadata
from jax.flatten_util import ravel_pytree

from propmap.arrays.loops import in_one_function
from propmap.arrays.namespace import on_accelerator
from propmap.compilation import KNOWN_JAXLIB
from propmap.engine.plan import ISLAND_PANELS

Shared = TypeVar("Shared")
Each = TypeVar("Each")

LANES = 8
"""Operating points at a time: as many float64 as a processor's widest vector register holds."""


def use_lanes(panels: tuple[int, ...]) -> bool:
    """Whether programs for these ``panels`` use lanes.

    Those for ``solve.islands`` do not: they sort, which XLA cannot compile into a function.
    """
    return known_jaxlib() and not on_accelerator() and len(panels) < ISLAND_PANELS


def in_groups(points: int, panels: tuple[int, ...]) -> bool:
    """Whether a program for so many points uses lanes."""
    # Not for the few points of a fit, one group of lanes: without lanes programs compile sooner.
    return points > LANES and points % LANES == 0 and use_lanes(panels)


@functools.cache
def known_jaxlib() -> bool:
    """Whether the installed jaxlib is one whose undocumented options are known."""
    return importlib.metadata.version("jaxlib").startswith(KNOWN_JAXLIB)


def in_lanes(
    function: Callable[[Shared, Each], Any],
    shared: Shared,
    each: Each,
    used: jax.Array,
    together: int,
) -> Any:
    """``function(shared, each)``, computed for ``LANES`` points at a time; traceable.

    Parameters
    ----------
    function : callable
        Called with ``shared`` and ``LANES`` points of ``each``.
    shared : tree of Array
        Real arrays, the same for all points.
    each : tree of Array
        Arrays whose last axis is the points, like that of the results; a multiple of ``LANES``.
    used : Array
        Number of points that are evaluated, from the first on; results of the others are zero.
    together : int
        Azimuths in one step of a loop, see ``loops.mean_over``.
    """
    # Joined in one array each: XLA ends the process if an argument of the call is not used.
    flat, shared_of = ravel_pytree(shared)
    leaves, form = jax.tree.flatten(each)
    points = leaves[0].shape[-1]
    rows = jnp.concatenate([a.reshape(-1, points).astype(flat.dtype) for a in leaves])

    def some(values: jax.Array, few: jax.Array) -> Any:
        parts, at = [], 0
        for a in leaves:
            height = math.prod(a.shape[:-1])
            part = few[at : at + height].reshape(*a.shape[:-1], LANES)
            parts.append(part.astype(a.dtype))
            at += height
        return function(shared_of(values), jax.tree.unflatten(form, parts))

    def whole(values: jax.Array, rows: jax.Array, count: jax.Array) -> Any:
        def group(turn: Any) -> Any:
            few = lax.dynamic_slice_in_dim(rows, LANES * turn, LANES, axis=-1)
            return some(values, few)

        def add(turn: Any, found: Any) -> Any:
            def put(among: jax.Array, few: jax.Array) -> jax.Array:
                return lax.dynamic_update_slice_in_dim(among, few, LANES * turn, axis=-1)

            return jax.tree.map(put, found, group(turn))

        like = jax.eval_shape(group, 0)
        nothing = jax.tree.map(lambda a: jnp.zeros((*a.shape[:-1], points), a.dtype), like)
        return lax.fori_loop(0, -(-count // LANES), add, nothing)

    with in_one_function(together):
        found = jax.jit(whole)(flat, rows, used)
    # Marking the result marks the call; as a context the mark would be on all operations in it.
    mark: Any = set_xla_metadata  # untyped in JAX
    return mark(found, xla_cpu_small_call="true", inlineable="false")
