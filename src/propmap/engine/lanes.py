"""A program that takes a few operating points at a time, all its steps as one function.

XLA on a CPU makes a kernel of every few operations, and calls one after the other.  That costs so
much that each has to serve many points: all of them wait for the slowest root, have as many
azimuths as the one with most, and are computed where a block is filled up.  Of a few points at a
time none of that is left, and what they need stays in the innermost cache; but the kernels have to
be parts of one function then.  XLA compiles a call so that is marked as it marks short loops
itself.  The mark is nowhere promised, hence ``KNOWN_JAXLIB``.
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
from propmap.engine.compilation import KNOWN_JAXLIB
from propmap.engine.plan import ISLAND_PANELS

Shared = TypeVar("Shared")
Each = TypeVar("Each")

LANES = 8
"""Operating points at a time: as many as a processor's widest vectors hold."""


def serve(panels: tuple[int, ...]) -> bool:
    """Whether programs for these panels take a few points at a time.

    Those for islands sort along the blade, for which XLA has no part of a function.
    """
    return _known() and not on_accelerator() and len(panels) < ISLAND_PANELS


def in_groups(points: int, panels: tuple[int, ...]) -> bool:
    """Whether a program for so many points does."""
    # A fit's few points are one such group: made of kernels, its programs compile sooner.
    return points > LANES and points % LANES == 0 and serve(panels)


@functools.cache
def _known() -> bool:
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
        Of ``shared`` and a part of ``each``.
    shared : tree of Array
        Real arrays.
    each : tree of Array
        Their last axis is the points (B,), a multiple of ``LANES``, as it is of the results.
    used : Array
        How many points are asked for, from the first on; the results of others are zero.
    together : int
        Azimuths at a time, see ``arrays.loops.TOGETHER``.
    """
    # As one array each: XLA ends the process over an argument that is not used, as some may be.
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
    # A mark on what the call gives is one on the call; within a context it would be on all in it.
    mark: Any = set_xla_metadata  # untyped in JAX
    return mark(found, xla_cpu_small_call="true", inlineable="false")
