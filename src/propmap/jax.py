"""Loads as a JAX function, for programs that JAX compiles and differentiates."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from propmap.errors import InputError, require
from propmap.loads import FLOW, LOADS
from propmap.rotor import Rotor
from propmap.typing import Floats

require("jax")
import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402

_Shape: Any = jax.ShapeDtypeStruct


def loads(rotor: Rotor, omega: Any, v_axial: Any, v_inplane: Any) -> Any:
    """Return the loads at operating points as a JAX array.

    The function supports ``jit``, ``vmap``, ``grad``, ``jacfwd`` and ``jacrev``.

    Parameters
    ----------
    rotor : Rotor
        The rotor; constant in a compiled function.
    omega, v_axial, v_inplane : array, shape (...)
        Rotational speed >= 0 [rad/s], V cos(beta) [m/s] and V sin(beta) >= 0 [m/s]; broadcast.

    Returns
    -------
    jax.Array, shape (L, ...)
        Loads in the order of ``propmap.loads.LOADS`` [N], [N m]; NaN where no inflow was found.

    Notes
    -----
    JAX calls the compiled core on the CPU through a callback.  The core computes in float64, all
    points of a call in parallel.  JAX rounds arguments and results to float32, unless the caller
    creates and uses the arrays inside ``jax.enable_x64(True)``.  First derivatives are those of
    ``Rotor.gradients``.  Second derivatives do not exist.  For derivatives with respect to section
    constants and blade, use ``Rotor.gradients``.  If ``Rotor.gradients`` refuses a value, the
    computation stops with the message of ``Rotor.gradients``.
    """
    flow = {"omega": (omega, 0), "v_axial": (v_axial, 0), "v_inplane": (v_inplane, 0)}
    given = real_arrays(jnp.result_type(float), **flow)
    return jnp.moveaxis(_loads(rotor, *jnp.broadcast_arrays(*given)), -1, 0)


def real_arrays(dtype: Any, **given: tuple[Any, int]) -> list[Any]:
    """Return ``given`` values, each with the length of its last axis (0 for any), as arrays."""
    found = []
    for name, (x, count) in given.items():
        if jnp.iscomplexobj(x):
            raise InputError(f"{name} is complex", "give real numbers")
        found.append(jnp.asarray(x, dtype))
        if count and found[-1].shape[-1:] != (count,):
            remedy = f"its last axis must have {count} values"
            raise InputError(f"{name} has shape {found[-1].shape}", remedy)
    return found


@functools.partial(jax.custom_jvp, nondiff_argnums=(0,))
def _loads(rotor: Rotor, omega: Any, v_axial: Any, v_inplane: Any) -> Any:
    """Return loads (..., L); the last axis is fixed because ``vmap`` adds axes in front."""
    wanted = _Shape((*omega.shape, len(LOADS)), omega.dtype)

    def found(*flow: Any) -> Floats:
        values, _ = rotor.gradients((), *_double(flow))
        return np.moveaxis(values, 0, -1).astype(wanted.dtype)

    return jax.pure_callback(found, wanted, omega, v_axial, v_inplane, vmap_method="broadcast_all")


@_loads.defjvp
def _loads_jvp(rotor: Rotor, primals: Any, tangents: Any) -> Any:
    shape, dtype = primals[0].shape, primals[0].dtype
    wanted = (_Shape((*shape, len(LOADS)), dtype), _Shape((*shape, len(LOADS), len(FLOW)), dtype))

    def found(*flow: Any) -> tuple[Floats, Floats]:
        values, slopes = rotor.gradients(FLOW, *_double(flow))
        return (
            np.moveaxis(values, 0, -1).astype(dtype),
            np.moveaxis(slopes, (0, 1), (-2, -1)).astype(dtype),
        )

    values, slopes = jax.pure_callback(found, wanted, *primals, vmap_method="broadcast_all")
    return values, jnp.einsum("...lk,...k->...l", slopes, jnp.stack(tangents, axis=-1))


def _double(flow: Any) -> list[Floats]:
    return [np.asarray(values, np.float64) for values in flow]
