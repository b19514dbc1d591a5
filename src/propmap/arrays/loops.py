"""Loops that JAX compiles and NumPy runs."""

from __future__ import annotations

import contextlib
import contextvars
from collections.abc import Callable, Iterator
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from propmap.arrays.materialize import pack, unpack
from propmap.arrays.namespace import Array, Value, on_numpy

# The argument of ``in_one_function``; None outside of it.
_IN_ONE_FUNCTION: contextvars.ContextVar[int | None] = contextvars.ContextVar(
    "_IN_ONE_FUNCTION", default=None
)


@contextlib.contextmanager
def in_one_function(together: int) -> Iterator[None]:
    """Context in which programs are traced to be compiled as one function, see ``engine.lanes``.

    Parameters
    ----------
    together : int
        Terms of a mean in one step of its loop.  They are independent, so that a processor works on
        one while another waits for its operands.
    """
    token = _IN_ONE_FUNCTION.set(together)
    try:
        yield
    finally:
        _IN_ONE_FUNCTION.reset(token)


def steps_are_free() -> bool:
    """Whether a step of a loop costs no more than its arithmetic.

    Outside of ``in_one_function`` it does: XLA makes several kernels of it and calls each in turn.
    """
    return _IN_ONE_FUNCTION.get() is not None


def while_loop(
    going: Callable[[Value], Array], step: Callable[[Value], Value], state: Value
) -> Value:
    """Apply ``step`` to ``state`` again and again while ``going(state)`` is true."""
    if on_numpy():
        while going(state):
            state = step(state)
        return state
    ended = lax.while_loop(
        lambda packed: going(unpack(packed, state)),
        lambda packed: pack(step(unpack(packed, state))),
        pack(state),
    )
    return unpack(ended, state)


def repeat(times: int, step: Callable[[Value], Value], state: Value) -> Value:
    """Apply ``step`` to ``state``, ``times`` times in turn."""
    if on_numpy():
        for _ in range(times):
            state = step(state)
        return state
    ended: Value = lax.fori_loop(0, times, lambda _, now: step(now), state)
    return ended


def scan(step: Callable[[Value, Any], Value], state: Value, values: Any) -> Value:
    """Apply ``step(state, value)`` in turn for each entry of the tree ``values`` (first axis)."""
    if on_numpy():
        for one in _entries(values):
            state = step(state, one)
        return state
    ended: Value
    ended, _ = lax.scan(lambda now, one: (step(now, one), None), state, values)
    return ended


def map_entries(function: Callable[[Any], Value], values: Any) -> Value:
    """Apply ``function`` to each entry of the tree ``values`` (first axis); stack the results."""
    if on_numpy():
        found = [function(one) for one in _entries(values)]
        stacked: Value = jax.tree.map(lambda *parts: np.stack(parts), *found)
        return stacked
    mapped: Value = lax.map(function, values)
    return mapped


def _entries(values: Any) -> list[Any]:
    count = jax.tree.leaves(values)[0].shape[0]
    return [jax.tree.map(lambda a, k=k: a[k], values) for k in range(count)]


def mean_over(
    term: Callable[[Any], Value], values: Any, count: Any, together: int | None = None
) -> Value:
    """The mean of ``term(v)``, a tree of arrays, over the first ``count`` of ``values``.

    ``values`` are (n,) and ``count`` an integer, or (n, B) and (B,): each column has its own.
    ``together`` is the number of terms in one step, by default that of ``in_one_function``, else 1.
    """
    if on_numpy():
        # All at once, along a new first axis.
        used = np.asarray(values)[: int(np.max(count)), None]
        terms = term(used if used.ndim > 2 else used[..., None])
        among = np.arange(used.shape[0])[:, None, None] < count
        share = 1.0 / count
        return jax.tree.map(lambda a: np.sum(np.where(among, a, 0.0), axis=0) * share, terms)
    own = jnp.ndim(count) > 0
    together = together or _IN_ONE_FUNCTION.get() or 1
    masked = not isinstance(count, int) or count % together > 0
    term = jax.jit(term, inline=True)  # traced once, though called several times

    def one(k: Any) -> Any:
        terms = term(values[k])
        return jax.tree.map(lambda a: jnp.where(k < count, a, 0.0), terms) if masked else terms

    def add(turn: Any, total: list[Any]) -> list[Any]:
        some = [one(together * turn + k) for k in range(together)]
        terms = jax.tree.map(lambda *each: sum(each[1:], each[0]), *some)
        return [a + b for a, b in zip(total, pack(terms), strict=True)]

    like = jax.eval_shape(term, values[0])
    zero = pack(jax.tree.map(lambda a: jnp.zeros(a.shape, a.dtype), like))
    most = jnp.max(count) if own else count
    total = lax.fori_loop(0, -(-most // together), add, zero)
    share = 1.0 / jnp.asarray(count)  # one division, not one for each array
    mean: Value = jax.tree.map(lambda a: a * share, unpack(total, like))
    return mean
