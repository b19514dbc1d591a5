"""Derivatives of functions of one number, which know what does not depend on it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
from jax.extend.core import ClosedJaxpr, Literal, jaxpr_as_fun
from jax.interpreters.partial_eval import dce_jaxpr


def derivative(function: Callable[[Any], Any]) -> Any:
    """The derivative of a ``function`` of one number at 0, and None where it is zero throughout.

    JAX fills in zeros where a result does not depend on the number; XLA multiplies by them.

    Parameters
    ----------
    function : callable
        Takes a scalar and gives a tree of arrays.

    Returns
    -------
    tree
        Like the function's, each leaf an array of the leaf's shape, or None.
    """
    traced, shapes = jax.make_jaxpr(function, return_shape=True)(0.0)
    depends = set(traced.jaxpr.invars)
    for step in traced.jaxpr.eqns:
        if any(not isinstance(value, Literal) and value in depends for value in step.invars):
            depends.update(step.outvars)
    moves = [not isinstance(v, Literal) and v in depends for v in traced.jaxpr.outvars]
    found: list[Any] = [None] * len(moves)
    if any(moves):
        kept, _ = dce_jaxpr(traced.jaxpr, moves)
        _, changes = jax.jvp(jaxpr_as_fun(ClosedJaxpr(kept, traced.consts)), (0.0,), (1.0,))
        moved = iter(changes)
        found = [next(moved) if one else None for one in moves]
    return jax.tree.unflatten(jax.tree.structure(shapes), found)
