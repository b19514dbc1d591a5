"""From a load to the rotational speed."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.table.query import LoadTable

QUANTITIES = ("thrust", "torque", "power")

END_SLACK = 1e-11
"""How far, relatively, a request may lie beyond the load at an end of the envelope for rounding;
the answer is that end."""


class Inverse(NamedTuple):
    """The rotational speeds at which a load has the value asked for; arrays of one shape.

    Attributes
    ----------
    omega, least : ndarray
        The largest and the smallest [rad/s]; NaN where there is none.
    solutions : ndarray of int
        How many there are inside the envelope.
    status : ndarray of str
        "ok" for one, "none", "several".
    """

    omega: Floats
    least: Floats
    solutions: NDArray[np.int64]
    status: NDArray[np.str_]


def solve(table: LoadTable, quantity: str, value: Floats, speed: Floats, beta: Floats) -> Inverse:
    """Every omega of the envelope at which a load has a value; arguments of one shape.

    A point outside the envelope, or where the table has no values, has none.  Where the blades
    windmill at low omega, the same thrust often occurs twice: "several".  The load at an end of
    the envelope is answered with that end, to rounding, see ``END_SLACK``.
    """
    if quantity not in QUANTITIES:
        raise InputError(f"quantity is {quantity!r}: it must be one of {', '.join(QUANTITIES)}")
    shape = value.shape
    roots = [
        _roots(table, quantity, *point)
        for point in zip(
            value.ravel().tolist(), speed.ravel().tolist(), beta.ravel().tolist(), strict=True
        )
    ]
    count = np.array([len(found) for found in roots], np.int64).reshape(shape)
    largest = np.array([found[-1] if found else np.nan for found in roots]).reshape(shape)
    least = np.array([found[0] if found else np.nan for found in roots]).reshape(shape)
    status = np.array(["none", "ok", "several"])[np.minimum(count, 2)]
    return Inverse(largest, least, count, status)


def _roots(table: LoadTable, quantity: str, value: float, speed: float, beta: float) -> list[float]:
    """Rising omegas at which the load is ``value``."""
    omega = _pieces(table, speed)
    field = getattr(table.loads(omega, speed, beta), quantity) - value
    slope = getattr(table.gradient(omega, speed, beta), quantity)[:, 0]
    field = _met_at_the_ends(field, value, omega, slope)

    def excess(w: float) -> float:
        return float(getattr(table.loads(w, speed, beta), quantity)) - value

    def rate(w: float) -> float:
        return float(getattr(table.gradient(w, speed, beta), quantity)[0])

    found: list[float] = []
    points = list(zip(omega.tolist(), field.tolist(), slope.tolist(), strict=True))
    for (a, fa, da), (b, fb, db) in itertools.pairwise(points):
        if fa * fb >= 0.0 and da * db < 0.0:
            # The load turns back on its way; perhaps it meets the value before and after.
            turn = _bisect(rate, a, b, da)
            middle = excess(turn)
            found += _met(excess, a, fa, turn, middle) + _met(excess, turn, middle, b, fb)
        else:
            found += _met(excess, a, fa, b, fb)
    if points[-1][1] == 0.0:
        found.append(points[-1][0])
    return found


def _met_at_the_ends(excess: Floats, value: float, omega: Floats, slope: Floats) -> Floats:
    """The excess (n,) of a load over ``value``, zero at the envelope's ends if mere rounding."""
    size = np.fmax(np.abs(omega * slope), abs(value))
    near = np.abs(excess) <= END_SLACK * size
    near[1:-1] = False
    return np.where(near, 0.0, excess)


def _met(
    excess: Callable[[float], float], low: float, at_low: float, high: float, at_high: float
) -> list[float]:
    """The root in [low, high) of a function that is monotonic there, if it has one."""
    if at_low == 0.0:
        return [low]
    return [_bisect(excess, low, high, at_low)] if at_low * at_high < 0.0 else []


def _pieces(table: LoadTable, speed: float) -> Floats:
    """Omegas between which the load is one smooth piece, halved; rising, within the envelope."""
    low, high = table.envelope["omega"]
    knots = table.content.advance
    with np.errstate(divide="ignore", invalid="ignore"):
        crossed = speed / (knots * table.content.radius)
    crossed = crossed[(crossed > low) & (crossed < high)]
    ends = np.unique(np.concatenate([[low], crossed, [high]]))
    return np.sort(np.concatenate([ends, 0.5 * (ends[:-1] + ends[1:])]))


def _bisect(function: Callable[[float], float], low: float, high: float, start: float) -> float:
    """Where ``function``, of the sign of ``start`` at low and the other at high, vanishes."""
    for _ in range(200):
        middle = 0.5 * (low + high)
        if not low < middle < high:
            break
        value = function(middle)
        if value == 0.0:
            return middle
        if (value > 0.0) == (start > 0.0):
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
