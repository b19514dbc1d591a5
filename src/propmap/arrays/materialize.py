"""Values that XLA is to compute once.

XLA on a CPU fuses a value into each of its users and computes it there again.  ``materialize``
forbids that; it also keeps several results in one kernel.  On a GPU neither is wanted.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax import lax

from propmap.arrays.namespace import Array, Value, on_accelerator, on_numpy


def materialize(function: Callable[[], Value], scalar: Array) -> Value:
    """What ``function`` gives, computed once for all that use it.

    A branch that is always taken, as far as the compiler cannot tell, is a barrier that XLA
    keeps; it removes ``lax.optimization_barrier`` too early.

    Parameters
    ----------
    function : callable
        Without arguments; its result is a tree of arrays.
    scalar : Array
        Any number at hand.
    """
    if on_numpy() or on_accelerator():
        return function()
    function = jax.jit(function)  # traced once, though called twice

    def packed() -> list[Any]:
        return pack(function())

    nothing = jax.tree.map(lambda s: jnp.zeros(s.shape, s.dtype), jax.eval_shape(packed))
    always = (scalar <= scalar) | (scalar != scalar)
    return unpack(lax.cond(always, packed, lambda: nothing), jax.eval_shape(function))


def pack(values: Any) -> list[Any]:
    """The arrays of a tree in order, neighbours of one shape as the parts of a complex array.

    XLA on a CPU makes one kernel of all that leads to one array.  Of two arrays with common
    intermediate values it makes up to ten kernels, each of which writes what the next one reads.
    """
    left, packed = jax.tree.leaves(values), []
    if on_accelerator():
        return left
    while left:
        a = left.pop(0)
        alike = left and a.shape == left[0].shape and a.dtype == left[0].dtype
        if alike and jnp.issubdtype(a.dtype, jnp.floating):
            a = lax.complex(a, left.pop(0))
        packed.append(a)
    return packed


def unpack(packed: list[Any], like: Value) -> Value:
    """What ``pack`` was given: a tree ``like`` this one."""
    parts = [b for a in packed for b in ((a.real, a.imag) if jnp.iscomplexobj(a) else (a,))]
    values: Value = jax.tree.unflatten(jax.tree.structure(like), parts)
    return values
