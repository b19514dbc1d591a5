"""``xp``: the array functions of JAX, or those of NumPy within ``by_numpy``.

The equations are written once, in functions that both have.  JAX compiles and differentiates them;
compilation takes seconds, which pays for batches.  NumPy runs them a hundred times slower but needs
no compilation, so that a few points are ready sooner.
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

_BY_NUMPY = contextvars.ContextVar("_BY_NUMPY", default=False)


@contextlib.contextmanager
def by_numpy() -> Iterator[None]:
    """Context in which ``xp`` is NumPy, in this thread."""
    token = _BY_NUMPY.set(True)
    try:
        # As JAX, do not warn of divisions by zero: ``where`` discards their results.
        with np.errstate(all="ignore"):
            yield
    finally:
        _BY_NUMPY.reset(token)


def on_numpy() -> bool:
    """Whether ``xp`` is NumPy now."""
    return _BY_NUMPY.get()


def on_accelerator() -> bool:
    """Whether ``xp`` is JAX and computes elsewhere than on a CPU."""
    return not on_numpy() and jax.default_backend() != "cpu"


class _Namespace:
    """Looks up each function in ``jax.numpy`` or in NumPy."""

    def __getattr__(self, name: str) -> Any:
        return getattr(np if on_numpy() else jnp, name)


if TYPE_CHECKING:
    xp = jnp
else:
    xp = _Namespace()


def stop_gradient(values: Value) -> Value:
    """``jax.lax.stop_gradient`` of a tree of arrays; NumPy has no gradients to stop."""
    if on_numpy():
        return values
    stopped: Value = lax.stop_gradient(values)
    return stopped


class custom_jvp:  # noqa: N801 - named like the decorator of JAX that it stands for
    """``jax.custom_jvp``; under NumPy the function itself."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function, self._with_rule = function, jax.custom_jvp(function)
        functools.update_wrapper(self, function)

    def defjvp(self, rule: Callable[..., Any]) -> Callable[..., Any]:
        """Set the rule, as for ``jax.custom_jvp``."""
        self._with_rule.defjvp(rule)
        return rule

    def __call__(self, *arguments: Any) -> Any:
        """The function's value."""
        return (self._function if on_numpy() else self._with_rule)(*arguments)


def entry(values: Array, k: Array) -> Array:
    """``values[k]`` along the first axis, with a k of its own at each place of the other axes.

    Computed by a mask and a sum, which XLA fuses; it makes three kernels of a gather.

    Parameters
    ----------
    values : Array, shape (n, ...)
        Where to choose from.
    k : Array, shape (...)
        Integers, 0 <= k < n.
    """
    if on_numpy():
        found: Any = np.take_along_axis(np.asarray(values), np.asarray(k)[None], axis=0)[0]
        return found
    mine = jnp.arange(values.shape[0]).reshape(-1, *(1,) * jnp.ndim(k)) == k
    if values.dtype == bool:
        return jnp.any(mine & values, axis=0)
    return jnp.sum(jnp.where(mine, values, 0.0), axis=0)
