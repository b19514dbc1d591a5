"""Operating points as users give them: checked, broadcast, and resolved along the axis."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from propmap.errors import InputError
from propmap.typing import Floats

SPIN_REMEDY = "give the spin by its direction, not by a sign [rad/s]"
"""What to do instead of a negative omega."""


def broadcast(**named: ArrayLike) -> list[Floats]:
    """Arguments as arrays of one shape, of numbers that are all finite.

    Raises
    ------
    InputError
        That names the argument at fault.
    """
    arrays = []
    for name, value in named.items():
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError(f"{name} is {value!r}: give a number or an array of numbers") from None
        if not np.isfinite(array).all():
            raise InputError(f"{name} holds a value that is not finite: remove NaN and infinity")
        arrays.append(array)
    try:
        return [np.array(a) for a in np.broadcast_arrays(*arrays)]
    except ValueError:
        shapes = ", ".join(f"{n} {np.shape(a)}" for n, a in zip(named, arrays, strict=True))
        raise InputError(f"shapes do not fit together: {shapes}; they must broadcast") from None


def rates(omega: ArrayLike) -> Floats:
    """Rotational speeds ``omega`` [rad/s], none of them negative."""
    return rates_of("omega", omega)


def rates_of(name: str, values: ArrayLike) -> Floats:
    """The same of an argument ``name`` with these ``values``."""
    (w,) = broadcast(**{name: values})
    _refuse_negative(name, w, SPIN_REMEDY)
    return w


def resolved(
    omega: ArrayLike, speed: ArrayLike, beta: ArrayLike, *, one: bool = False
) -> tuple[Floats, Floats, Floats]:
    """omega [rad/s], V cos(beta) and |V sin(beta)| [m/s]; a multiple of pi/2 is taken at its word.

    Where ``one`` is true, arrays are refused.
    """
    alone = _resolved_alone(omega, speed, beta)
    if alone is not None:
        return alone
    w, v, b = broadcast(omega=omega, speed=speed, beta=beta)
    if one and w.ndim:
        raise InputError("this takes one operating point: give scalars")
    _refuse_negative("omega", w, SPIN_REMEDY)
    _refuse_negative("speed", v, "give the direction by beta, pi for descent [m/s]")
    cosine, sine = np.cos(b), np.abs(np.sin(b))
    rounding = 4e-16 * np.maximum(1.0, np.abs(b))
    cosine = np.where(np.abs(cosine) < rounding, 0.0, cosine)
    return w, v * cosine, v * np.where(sine < rounding, 0.0, sine)


def _resolved_alone(
    omega: ArrayLike, speed: ArrayLike, beta: ArrayLike
) -> tuple[Floats, Floats, Floats] | None:
    """``resolved`` of three good numbers, in a tenth of the time; None for anything else."""
    w, v, b = omega, speed, beta
    number = float | int
    if not (isinstance(w, number) and isinstance(v, number) and isinstance(b, number)):
        return None
    if not (math.isfinite(w) and math.isfinite(v) and math.isfinite(b) and w >= 0.0 and v >= 0.0):
        return None
    # NumPy's functions, for the bits that an array of points has.
    cosine, sine = float(np.cos(float(b))), abs(float(np.sin(float(b))))
    rounding = 4e-16 * max(1.0, abs(b))
    along = 0.0 if abs(cosine) < rounding else v * cosine
    across = 0.0 if sine < rounding else v * sine
    return np.array(float(w)), np.array(along), np.array(across)


def along_and_across(
    omega: ArrayLike, v_axial: ArrayLike, v_inplane: ArrayLike
) -> tuple[Floats, Floats, Floats]:
    """omega [rad/s], and the velocity along the axis and in the disk plane [m/s], of one shape."""
    w, along, across = broadcast(omega=omega, v_axial=v_axial, v_inplane=v_inplane)
    _refuse_negative("omega", w, SPIN_REMEDY)
    _refuse_negative("v_inplane", across, "give its size; either direction has the same loads")
    return w, along, across


def split_velocity(omega: ArrayLike, velocity: ArrayLike) -> tuple[Floats, Floats, Floats, Floats]:
    """omega, velocity along the axis and across it, and the unit vector (..., 3) of the latter."""
    (vector,) = broadcast(velocity=velocity)
    if vector.ndim == 0 or vector.shape[-1] != 3:
        raise InputError(f"velocity has shape {vector.shape}: its last axis must hold x, y, z")
    w, x, y, z = broadcast(omega=omega, vx=vector[..., 0], vy=vector[..., 1], vz=vector[..., 2])
    across = np.hypot(x, y)
    unit = np.where(across > 0.0, across, 1.0)
    direction = np.stack([np.where(across > 0.0, x / unit, 1.0), y / unit, np.zeros_like(x)], -1)
    _refuse_negative("omega", w, SPIN_REMEDY)
    return w, z, across, direction


def _refuse_negative(name: str, values: Floats, remedy: str) -> None:
    if (values < 0.0).any():
        raise InputError(f"{name} is negative ({values.min():g}): {remedy}")
