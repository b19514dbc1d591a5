"""Operating points of users: checks, broadcasting, and velocities along and across the axis."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from propmap.errors import InputError, quoted
from propmap.typing import Floats

SPIN_REMEDY = "give a value of 0 or more [rad/s]; the spin, ccw or cw, sets the direction"
"""Remedy for a negative omega where propellers cannot turn backward."""

FAR = np.array(np.inf)  # distance of a rotor far from the ground or a ceiling [m]


class Further(TypedDict, total=False):
    """Optional quantities of an operating point; None if not given."""

    height: ArrayLike | None  # of the disk above level ground [m]
    ceiling: ArrayLike | None  # distance of a level ceiling above the disk [m]


class FlowPoints(NamedTuple):
    """Operating points for the compiled core: arrays of one shape, or ``FAR``."""

    omega: Floats  # rotational speed [rad/s]; negative for a propeller that turns backward
    v_axial: Floats  # V cos(beta) [m/s], positive in climb
    v_inplane: Floats  # V sin(beta) [m/s], >= 0
    height: Floats = FAR  # of the disk above the ground [m], > 0
    ceiling: Floats = FAR  # distance of a ceiling above the disk [m], > 0

    @property
    def rows(self) -> Floats:
        """The fields as rows of one array (F, N)."""
        found = np.empty((len(self), self.omega.size))
        for row, values in zip(found, self, strict=True):
            row[:] = values.ravel()
        return found


def arrays_of(**named: ArrayLike) -> list[Floats]:
    """Convert arguments to arrays of one shape; raise ``InputError`` for a bad argument."""
    arrays = []
    for name, value in named.items():
        if hasattr(value, "filled") and np.ma.is_masked(value):
            raise InputError(f"{name} has masked points: leave them out, as with .compressed()")
        try:
            given = np.asarray(value)
            if given.dtype.kind not in "biufO":
                raise TypeError
            arrays.append(given.astype(np.float64, copy=False))
        except (TypeError, ValueError):
            found = f"{name} is {quoted(value)}: give a real number or an array of real numbers"
            raise InputError(found) from None
    if len(arrays) == 1:
        return arrays
    try:
        return list(np.broadcast_arrays(*arrays))
    except ValueError:
        shapes = ", ".join(f"{n} {np.shape(a)}" for n, a in zip(named, arrays, strict=True))
        raise InputError(f"shapes cannot be broadcast together: {shapes}") from None


def broadcast(**named: ArrayLike) -> list[Floats]:
    """Copy arguments to finite arrays of one shape; raise ``InputError`` for a bad argument."""
    arrays = [np.array(values) for values in arrays_of(**named)]
    for name, values in zip(named, arrays, strict=True):
        if not np.isfinite(values).all():
            raise InputError(f"{name} contains a value that is not finite: remove NaN and infinity")
    return arrays


def components(velocity: ArrayLike) -> dict[str, Floats]:
    """Return x, y and z of a ``velocity`` (..., 3); raise ``InputError`` for another shape."""
    (vector,) = arrays_of(velocity=velocity)
    if vector.ndim == 0 or vector.shape[-1] != 3:
        raise InputError(f"velocity has shape {vector.shape}: its last axis must be x, y, z")
    return {f"v{axis}": vector[..., k] for k, axis in enumerate("xyz")}


def numbers(name: str, values: ArrayLike, negative: bool) -> Floats:
    """Return the finite numbers of an argument; refuse numbers below 0 unless ``negative``."""
    (found,) = broadcast(**{name: values})
    if not negative:
        _refuse_negative(name, found, SPIN_REMEDY if name == "omega" else "give 0 or more")
    return np.asarray(found, order="C")


def resolved(
    omega: ArrayLike,
    speed: ArrayLike,
    beta: ArrayLike,
    *,
    one: bool = False,
    **further: Unpack[Further],
) -> FlowPoints:
    """Resolve V along and across the axis, exact at multiples of pi/2; ``one`` excludes arrays and
    a negative omega."""
    more = _given(further)
    alone = None if more or one else _resolved_alone(omega, speed, beta)
    if alone is not None:
        return alone
    w, v, b, *rest = broadcast(omega=omega, speed=speed, beta=beta, **more)
    if one and w.ndim:
        raise InputError("only one operating point is allowed: give scalars")
    if one:
        _refuse_negative("omega", w, SPIN_REMEDY)
    _refuse_negative("speed", v, "give a value of 0 or more [m/s], and beta = pi for descent")
    cosine, sine = np.cos(b), np.abs(np.sin(b))
    rounding = 4e-16 * np.maximum(1.0, np.abs(b))
    cosine = np.where(np.abs(cosine) < rounding, 0.0, cosine)
    across = v * np.where(sine < rounding, 0.0, sine)
    return FlowPoints(w, v * cosine, across, **dict(zip(more, rest, strict=True)))


def _resolved_alone(omega: ArrayLike, speed: ArrayLike, beta: ArrayLike) -> FlowPoints | None:
    """Return ``resolved`` of three valid numbers, ten times as fast; None for other arguments."""
    w, v, b = omega, speed, beta
    number = float | int
    if not (isinstance(w, number) and isinstance(v, number) and isinstance(b, number)):
        return None
    if not (math.isfinite(w) and math.isfinite(v) and math.isfinite(b) and v >= 0.0):
        return None
    # NumPy's functions, unlike those of ``math``, round as for an array of points.
    cosine, sine = float(np.cos(float(b))), abs(float(np.sin(float(b))))
    rounding = 4e-16 * max(1.0, abs(b))
    along = 0.0 if abs(cosine) < rounding else v * cosine
    across = 0.0 if sine < rounding else v * sine
    return FlowPoints(np.array(float(w)), np.array(along), np.array(across))


def along_and_across(
    omega: ArrayLike, v_axial: ArrayLike, v_inplane: ArrayLike, **further: Unpack[Further]
) -> FlowPoints:
    """Return checked operating points from velocities along the axis and in the disk plane."""
    more = _given(further)
    w, along, across, *rest = broadcast(omega=omega, v_axial=v_axial, v_inplane=v_inplane, **more)
    _refuse_negative("omega", w, SPIN_REMEDY)
    _refuse_negative("v_inplane", across, "give its magnitude; the loads do not depend on the sign")
    return FlowPoints(w, along, across, **dict(zip(more, rest, strict=True)))


def split_velocity(
    omega: ArrayLike, velocity: ArrayLike, **further: Unpack[Further]
) -> tuple[FlowPoints, Floats]:
    """Return operating points of a velocity, and the unit vector (..., 3) of its in-plane part."""
    more = _given(further)
    alone = None if more else _split_alone(omega, velocity)
    if alone is not None:
        return alone
    w, x, y, z, *rest = broadcast(omega=omega, **components(velocity), **more)
    across = np.hypot(x, y)
    unit = np.where(across > 0.0, across, 1.0)
    direction = np.stack([np.where(across > 0.0, x / unit, 1.0), y / unit, np.zeros_like(x)], -1)
    return FlowPoints(w, z, across, **dict(zip(more, rest, strict=True))), direction


def _split_alone(omega: ArrayLike, velocity: ArrayLike) -> tuple[FlowPoints, Floats] | None:
    """Return ``split_velocity`` of valid scalars, ten times as fast; None for other arguments."""
    vector = velocity.tolist() if isinstance(velocity, np.ndarray) else velocity
    if not (isinstance(omega, float | int) and isinstance(vector, list | tuple)):
        return None
    if len(vector) != 3:
        return None
    x, y, z = vector
    for one in (omega, x, y, z):
        if not (isinstance(one, float | int) and math.isfinite(one)):
            return None
    across = float(np.hypot(x, y))
    direction = np.array([x / across, y / across, 0.0] if across > 0.0 else [1.0, float(y), 0.0])
    return FlowPoints(np.array(float(omega)), np.array(float(z)), np.array(across)), direction


def _given(further: Further) -> dict[str, Any]:
    return {name: values for name, values in further.items() if values is not None}


def _refuse_negative(name: str, values: Floats, remedy: str) -> None:
    if (values < 0.0).any():
        raise InputError(f"{name} is negative ({values.min():g}): {remedy}")
