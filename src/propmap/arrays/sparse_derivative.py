"""Derivatives of functions of one number, which know what does not depend on it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
from jax.extend.core import Literal, jaxpr_as_fun


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
        _, changes = jax.jvp(jaxpr_as_fun(traced), (0.0,), (1.0,))
        found = [by if moved else None for by, moved in zip(changes, moves, strict=True)]
    return jax.tree.unflatten(jax.tree.structure(shapes), found)
