"""Intermediate values that are computed once."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import jax
import jax.numpy as jnp
from jax import lax

Value = TypeVar("Value")


def settled(function: Callable[[], Value], scalar: jax.Array) -> Value:
    """What ``function`` gives, computed once for all that use it.

    function : without arguments; its result is a tree of arrays.  scalar : any number at hand.

    XLA on a CPU fuses a value into each of its users and evaluates it there again; an optimization
    barrier is gone by then.  A branch that is always taken, as far as the compiler cannot tell, is
    a barrier that stays: without them the program is twice as long to compile and slower.
    """
    shapes = jax.eval_shape(function)
    taken = (scalar <= scalar) | (scalar != scalar)  # noqa: PLR0124 - true, NaN or not
    nothing = jax.tree.map(lambda s: jnp.zeros(s.shape, s.dtype), shapes)
    found: Value = lax.cond(taken, function, lambda: nothing)
    return found
