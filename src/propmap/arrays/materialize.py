"""Make XLA compute a value once.

XLA on a CPU fuses a value into every operation that uses it, and so computes it several times.
``materialize`` forbids that, and keeps several results in one kernel.  On a GPU neither helps.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jax import lax

from propmap.arrays.namespace import Array, Value, on_accelerator, on_numpy


def materialize(function: Callable[[], Value], scalar: Array) -> Value:
    """The result of ``function``, computed once and kept for every operation that uses it.

    It stands in a ``lax.cond`` whose condition is always true, which the compiler cannot know; it
    does not fuse across that.  ``lax.optimization_barrier`` will not do: XLA removes it too early.

    Parameters
    ----------
    function : callable
        Without arguments; its result is a tree of arrays.
    scalar : Array
        Any number that is not a constant of the program: the condition is made of it.
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
    """The arrays of a tree in order, each two neighbours of one shape joined as a complex array.

    XLA on a CPU computes one array in one kernel.  Two arrays with common intermediate values take
    it up to ten kernels, which hand these values on through memory.
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
    """The inverse of ``pack``: a tree with the structure of ``like``."""
    parts = [b for a in packed for b in ((a.real, a.imag) if jnp.iscomplexobj(a) else (a,))]
    values: Value = jax.tree.unflatten(jax.tree.structure(like), parts)
    return values
