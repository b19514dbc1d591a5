"""What the theory is written in: array functions and loops of JAX, or of NumPy without compiling.

One code serves both.  JAX traces and compiles it, which takes seconds and pays in batches, and
differentiates it.  Within ``by_numpy`` NumPy runs it step by step, a hundred times slower but at
once: for a few points the answer is there before the compiler would have begun.
"""

from __future__ import annotations

import contextlib
import contextvars
import functools
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

Array = jax.Array

Value = TypeVar("Value")

TOGETHER = 2
"""Terms of a mean that are computed at a time, unless ``as_one_function`` is told otherwise: a
processor waits for the results of a long chain of operations, and has another to go on with."""

_BY_NUMPY = contextvars.ContextVar("_BY_NUMPY", default=False)
# What ``as_one_function`` was told, None outside of it.
_AS_ONE_FUNCTION: contextvars.ContextVar[int | None] = contextvars.ContextVar(
    "_AS_ONE_FUNCTION", default=None
)


@contextlib.contextmanager
def by_numpy() -> Iterator[None]:
    """Within it the theory runs on NumPy arrays (of float64), in this thread."""
    token = _BY_NUMPY.set(True)
    try:
        # JAX says nothing of divisions by zero either; what they give is thrown away.
        with np.errstate(all="ignore"):
            yield
    finally:
        _BY_NUMPY.reset(token)


def on_numpy() -> bool:
    """Whether NumPy is at work."""
    return _BY_NUMPY.get()


@contextlib.contextmanager
def as_one_function(together: int) -> Iterator[None]:
    """Within it the theory is traced to be compiled as one function, see ``propmap.engine.lanes``.

    together : terms of a mean that are computed at a time, see ``TOGETHER``.
    """
    token = _AS_ONE_FUNCTION.set(together)
    try:
        yield
    finally:
        _AS_ONE_FUNCTION.reset(token)


def steps_are_free() -> bool:
    """Whether a step of a loop costs what it computes and no more: not where it is made of kernels
    that are called one after the other."""
    return _AS_ONE_FUNCTION.get() is not None


def on_accelerator() -> bool:
    """Whether JAX computes elsewhere than on a CPU."""
    return not on_numpy() and jax.default_backend() != "cpu"


class _Arrays:
    """The functions of ``jax.numpy``, or of the same name in NumPy."""

    def __getattr__(self, name: str) -> Any:
        return getattr(np if on_numpy() else jnp, name)


if TYPE_CHECKING:
    xp = jnp
else:
    xp = _Arrays()


def held(values: Value) -> Value:
    """A tree of arrays as mere numbers: what they depend on does not move them."""
    if on_numpy():
        return values
    stopped: Value = lax.stop_gradient(values)
    return stopped


def settled(function: Callable[[], Value], scalar: jax.Array) -> Value:
    """What ``function`` gives, computed once for all that use it.

    function : without arguments; its result is a tree of arrays.  scalar : any number at hand.

    XLA on a CPU fuses a value into each of its users and evaluates it there again; an optimization
    barrier is gone by then.  A branch that is always taken, as far as the compiler cannot tell, is
    a barrier that stays: without it programs take up to twice as long.  An accelerator would have
    to ask the host which branch to take: none there.
    """
    if on_numpy() or on_accelerator():
        return function()
    function = jax.jit(function)  # lest it be traced again

    def packed() -> list[Any]:
        return _in_pairs(function())

    nothing = jax.tree.map(lambda s: jnp.zeros(s.shape, s.dtype), jax.eval_shape(packed))
    always = (scalar <= scalar) | (scalar != scalar)
    return _apart(lax.cond(always, packed, lambda: nothing), jax.eval_shape(function))


def _in_pairs(values: Any) -> list[Any]:
    """The arrays of a tree in order, neighbours of one kind together as complex numbers.

    XLA on a CPU makes one kernel of all that leads to a single array.  Of two arrays that have
    intermediate values in common it makes ten, each of which writes what the next one reads, and
    so many that it hands them to several threads, at a greater cost than they take.
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


def _apart(packed: list[Any], like: Value) -> Value:
    """What was given to ``_in_pairs``, a tree ``like`` this one."""
    parts = [b for a in packed for b in ((a.real, a.imag) if jnp.iscomplexobj(a) else (a,))]
    values: Value = jax.tree.unflatten(jax.tree.structure(like), parts)
    return values


def in_one_kernel(value: jax.Array, scalar: jax.Array) -> jax.Array:
    """The value itself, to be computed in each kernel that uses it.

    value : a sum or product of two arrays, of which many others follow.  scalar : any number at
    hand.

    Where roots or quotients with several users follow, XLA on a CPU makes such a value a kernel of
    its own, but not what is made of one array and a number.
    """
    if on_numpy() or on_accelerator():
        return value
    return value * ((scalar <= scalar) | (scalar != scalar)).astype(value.dtype)


def while_loop(
    going: Callable[[Value], jax.Array], step: Callable[[Value], Value], state: Value
) -> Value:
    """``step`` taken from ``state`` on for as long as ``going``."""
    if on_numpy():
        while going(state):
            state = step(state)
        return state
    ended = lax.while_loop(
        lambda packed: going(_apart(packed, state)),
        lambda packed: _in_pairs(step(_apart(packed, state))),
        _in_pairs(state),
    )
    return _apart(ended, state)


def repeated(times: int, step: Callable[[Value], Value], state: Value) -> Value:
    """``step`` taken ``times`` times from ``state`` on."""
    if on_numpy():
        for _ in range(times):
            state = step(state)
        return state
    ended: Value = lax.fori_loop(0, times, lambda _, now: step(now), state)
    return ended


def along_first_axis(step: Callable[[Value, Any], Value], state: Value, values: Any) -> Value:
    """``step(state, value)`` for each entry of ``values``, a tree, along its first axis."""
    if on_numpy():
        for entry in _entries(values):
            state = step(state, entry)
        return state
    ended: Value
    ended, _ = lax.scan(lambda now, entry: (step(now, entry), None), state, values)
    return ended


def of_each(function: Callable[[Any], Value], values: Any) -> Value:
    """``function`` of each entry of ``values``, a tree, along its first axis; stacked."""
    if on_numpy():
        found = [function(entry) for entry in _entries(values)]
        stacked: Value = jax.tree.map(lambda *parts: np.stack(parts), *found)
        return stacked
    mapped: Value = lax.map(function, values)
    return mapped


def by_bits(function: Callable[..., Any], *values: jax.Array) -> jax.Array:
    """The number whose bits are those that ``function`` gives, as integers, of those of values.

    values : of one shape and of one kind, float64 or float32; the result is like them.
    """
    real = values[0].dtype
    whole = np.int64 if real == np.float64 else np.int32
    if on_numpy():
        found: Any = function(*(np.asarray(a).view(whole) for a in values))
        return np.asarray(found).view(real)  # type: ignore[return-value]
    bits = function(*(lax.bitcast_convert_type(a, whole) for a in values))
    return lax.bitcast_convert_type(bits, real)


def entry(values: jax.Array, k: jax.Array) -> jax.Array:
    """values[k] along the first axis: values (n, ...), k of its other axes' shape, 0 <= k < n.

    Not a gather, which takes three kernels and keeps the values from being computed on the way.
    """
    if on_numpy():
        found: Any = np.take_along_axis(np.asarray(values), np.asarray(k)[None], axis=0)[0]
        return found
    mine = jnp.arange(values.shape[0]).reshape(-1, *(1,) * jnp.ndim(k)) == k
    if values.dtype == bool:
        return jnp.any(mine & values, axis=0)
    return jnp.sum(jnp.where(mine, values, 0.0), axis=0)


def _entries(values: Any) -> list[Any]:
    count = jax.tree.leaves(values)[0].shape[0]
    return [jax.tree.map(lambda a, k=k: a[k], values) for k in range(count)]


def mean_of_each(term: Callable[[Any], Value], values: Any, count: Any) -> Value:
    """The mean of term(v), a tree of arrays, over the first ``count`` of values.

    values : (n,), and count an integer; or (n, B), and count (B,): each column has its own.
    """
    if on_numpy():
        # All at once, along a new first axis.
        used = np.asarray(values)[: int(np.max(count)), None]
        terms = term(used if used.ndim > 2 else used[..., None])
        among = np.arange(used.shape[0])[:, None, None] < count
        share = 1.0 / count
        return jax.tree.map(lambda a: np.sum(np.where(among, a, 0.0), axis=0) * share, terms)
    own = jnp.ndim(count) > 0
    together = _AS_ONE_FUNCTION.get() or TOGETHER
    masked = not isinstance(count, int) or count % together > 0

    def one(k: Any) -> Any:
        terms = term(values[k])
        return jax.tree.map(lambda a: jnp.where(k < count, a, 0.0), terms) if masked else terms

    def add(turn: Any, total: list[Any]) -> list[Any]:
        some = [one(together * turn + k) for k in range(together)]
        terms = jax.tree.map(lambda *each: sum(each[1:], each[0]), *some)
        return [a + b for a, b in zip(total, _in_pairs(terms), strict=True)]

    like = jax.eval_shape(term, values[0])
    zero = _in_pairs(jax.tree.map(lambda a: jnp.zeros(a.shape, a.dtype), like))
    most = jnp.max(count) if own else count
    total = lax.fori_loop(0, -(-most // together), add, zero)
    share = 1.0 / jnp.asarray(count)  # once, not a division for each array
    mean: Value = jax.tree.map(lambda a: a * share, _apart(total, like))
    return mean


class DerivativeByRule:
    """A function whose derivative is given by a rule, ``jax.custom_jvp``; a decorator."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function, self._with_rule = function, jax.custom_jvp(function)
        functools.update_wrapper(self, function)

    def defjvp(self, rule: Callable[..., Any]) -> Callable[..., Any]:
        """The rule, as for ``jax.custom_jvp``; a decorator."""
        self._with_rule.defjvp(rule)
        return rule

    def __call__(self, *arguments: Any) -> Any:
        """The function's value."""
        return (self._function if on_numpy() else self._with_rule)(*arguments)
