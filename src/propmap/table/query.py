"""``LoadTable``: loads from a table, their derivatives, and the omega for a given load."""

from __future__ import annotations

import functools
import itertools
import math
import os
from collections import namedtuple
from collections.abc import Callable
from inspect import cleandoc
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.operating_points import arrays_of, components
from propmap.table import interpolation
from propmap.table.files import read_table, write_netcdf, write_table
from propmap.typing import CoreTable, Floats

if TYPE_CHECKING:
    from propmap.model.propeller import Propeller


# --- Results of queries: named tuples with every load of the registry ----------------------------

TORQUE = list(LOADS).index("torque")


def _every_load(*further: str) -> Any:
    """Return a named tuple type of all loads; dataclasses are too slow for single points."""
    return namedtuple("_EveryLoad", (*LOADS, *further))


class TableLoads(_every_load("power", "code")):  # type: ignore[misc]
    """Loads from a table: floats for a single point, arrays for several points.

    The fields are the loads of ``propmap.loads.LOADS``, the power, and ``code``, an index into
    ``propmap.table.STATUSES``; see ``status``.
    """

    __slots__ = ()

    @property
    def status(self) -> Any:
        """Status of each point, one of ``STATUSES``.

        - "vortex_ring": momentum theory is not valid at or near the point;
        - "unresolved": the model's loads jump or are very steep, and the table's error may exceed
          its tolerance;
        - "clamped": the point is outside the envelope and has the loads of the nearest point;
        - "no_value": NaN, since the model found no loads nearby, or since the table excludes loads
          in the vortex ring state;
        - "outside": NaN, since the point is outside the envelope;
        - "reversed": the propeller turns backward, see ``propmap.Loads.status``.
        """
        words = np.asarray(interpolation.STATUSES)[self.code]
        return str(words) if words.ndim == 0 else words

    @property
    def inside(self) -> Any:
        """Whether the point is inside the envelope."""
        return (self.code != interpolation.OUTSIDE) & (self.code != interpolation.CLAMPED)


class Gradient(_every_load("power")):  # type: ignore[misc]
    """Derivatives of the fields below, (..., k).

    The last axis is the variable: omega, speed and beta, or omega and the velocity's x, y, z.
    """

    __slots__ = ()


class Deviation(_every_load("power")):  # type: ignore[misc]
    """Standard deviations of the fields below; NaN outside the envelope."""

    __slots__ = ()


class JaxLoads(_every_load("power")):  # type: ignore[misc]
    """Loads from a table in JAX; NaN outside the envelope."""

    __slots__ = ()


_LINES = [
    *(f"{name} : array\n    {load.meaning} [{load.unit}]" for name, load in LOADS.items()),
    "power : array\n    torque times omega [W]",
]
for _kind in (TableLoads, Gradient, Deviation, JaxLoads):
    _parts = [cleandoc(_kind.__doc__ or ""), "", "Attributes", "----------", *_LINES]
    _kind.__doc__ = "\n".join(_parts)


CHUNK = 1024  # points differentiated together; their arrays fit in the processor cache
SLACK = 1e-9  # tolerance for rounding beyond the end of an axis, as a fraction of its largest value
HALF = len(LOADS)  # loads per knot; the same number of slopes in Omega^(-1/2) follows


class LoadTable:
    """Loads of one rotor over an envelope of operating points.

    Create one with ``LoadTable.load`` or ``build_table``.  The envelope is a box in omega [rad/s],
    speed [m/s] and beta [rad]; see ``envelope``.

    Parameters
    ----------
    content : TableContent
        Knots, coefficients, flags and provenance.
    """

    def __init__(self, content: interpolation.TableContent) -> None:
        self.content = content
        ends = (content.omega, content.speed, content.beta[[0, -1]])
        self._box = tuple((float(low), float(high)) for low, high in ends)

    def __reduce__(self) -> tuple[type[Self], tuple[interpolation.TableContent]]:
        return type(self), (self.content,)

    @functools.cached_property
    def _core(self) -> CoreTable:
        """Table of the compiled core."""
        from propmap import core

        content = self.content
        axes = (
            (np.ascontiguousarray(knots), interpolation.interval_polynomials(knots).ravel())
            for knots in (content.advance, content.beta)
        )
        codes = interpolation.cell_codes(content)
        return core.Table(*axes, content.padded(), codes, self._box, content.radius)

    def __repr__(self) -> str:
        box = ", ".join(f"{k} {low:g} to {high:g}" for k, (low, high) in self.envelope.items())
        return f"LoadTable({self.info['propeller'].get('name')}, {box})"

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, propeller: Propeller | None = None) -> Self:
        """Read a table from a .npz file, without executing any code from it.

        Parameters
        ----------
        path : path
            Path of the file.
        propeller : Propeller, optional
            Propeller whose geometry the table must have.

        Raises
        ------
        InputError
            For a missing, damaged, foreign or newer file, and for a table of another propeller.
        """
        content = read_table(path)
        if propeller is not None:
            described = content.info["propeller"]
            if described.get("geometry_sha256") != propeller.fingerprint():
                found = f"the table is for {described.get('name')!r}, expected {propeller.name!r}"
                remedy = "build a table for this propeller"
                raise InputError(f"{found} with the same geometry", remedy, os.fspath(path))
        return cls(content)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the table to the .npz file at ``path`` atomically."""
        write_table(self.content, path)

    def to_netcdf(self, path: str | os.PathLike[str]) -> None:
        """Write the table as NetCDF to ``path`` atomically; requires the extra ``netcdf``.

        The file contains coefficients and cells over omega, advance ratio V/(Omega R) and beta,
        with units and provenance; its attributes contain the range of V.
        """
        write_netcdf(self.content, path)

    @property
    def envelope(self) -> dict[str, tuple[float, float]]:
        """Least and largest omega [rad/s], speed [m/s] and beta [rad]."""
        return dict(zip(("omega", "speed", "beta"), self._box, strict=True))

    @property
    def backward(self) -> bool:
        """Whether the propeller turns backward, with omega < 0."""
        return self._box[0][0] < 0.0

    @property
    def info(self) -> dict[str, Any]:
        """Provenance of the table: propeller, airfoil, air and versions, as plain data."""
        return self.content.info

    @property
    def certificate(self) -> dict[str, Any]:
        """Errors with respect to the model as plain data, see ``propmap.table.Certificate``."""
        return dict(self.info.get("certificate") or {})

    def loads(
        self, omega: ArrayLike, speed: ArrayLike, beta: ArrayLike, *, clamp: bool = False
    ) -> TableLoads:
        """Interpolate the loads at operating points.

        Parameters
        ----------
        omega, speed, beta : array_like
            Omega [rad/s], V [m/s], beta [rad], broadcast; beta and 2 pi - beta are mirror images
            with the same loads.
        clamp : bool
            Whether points outside the envelope have the loads of the nearest point of the envelope
            and the status "clamped", instead of NaN.
        """
        if (
            isinstance(omega, (float, int))
            and isinstance(speed, (float, int))
            and isinstance(beta, (float, int))
        ):
            *values, code = self._core.point(omega, speed, beta, clamp)
            return TableLoads(*values, int(code))
        w, v, b = arrays_of(omega=omega, speed=speed, beta=beta)
        if w.ndim == 0:
            return self.loads(float(w), float(v), float(b), clamp=clamp)
        return self._points(w, v, b, clamp)

    def loads_at_velocity(
        self, omega: ArrayLike, velocity: ArrayLike, *, clamp: bool = False
    ) -> TableLoads:
        """Interpolate the loads for a velocity vector in the rotor frame.

        Parameters
        ----------
        omega : array_like, shape (...)
            Omega [rad/s].
        velocity : array_like, shape (..., 3)
            Velocity of the hub through the air [m/s], z along the thrust; broadcast with ``omega``.
        clamp : bool
            As in ``loads``.
        """
        if isinstance(omega, (float, int)) and np.shape(velocity) == (3,):
            x, y, z = map(float, velocity)
            across = math.hypot(x, y)
            return self.loads(omega, math.hypot(across, z), math.atan2(across, z), clamp=clamp)
        w, x, y, z = arrays_of(omega=omega, **components(velocity))
        across = np.hypot(x, y)
        return self.loads(w, np.hypot(across, z), np.arctan2(across, z), clamp=clamp)

    def std(self, omega: ArrayLike, speed: ArrayLike, beta: ArrayLike) -> Deviation:
        """Interpolate the standard deviations of the model's loads; NaN outside the envelope.

        They include all sources of ``propmap.Loads.std_by_source``, but not the interpolation
        errors of the table; see ``certificate``.

        Parameters
        ----------
        omega, speed, beta : array_like
            As in ``loads``.

        Raises
        ------
        InputError
            If the table has no standard deviations, since its model has no uncertainty.
        """
        content = self.content
        if content.deviations is None:
            found = "the table has no standard deviations"
            remedy = "build it from section constants with an uncertainty: identified or predicted "
            raise InputError(found, remedy + "constants of the catalogue, or the file of a fit")
        w, v, b = arrays_of(omega=omega, speed=speed, beta=beta)
        rate, speeds, folded = self._inside(w, v, b)
        lost = np.isnan(rate)
        advance = speeds / (np.abs(np.where(lost, content.omega[0], rate)) * content.radius)
        at = np.clip(advance, content.advance[0], content.advance[-1])
        ends = interpolation.bilinear(content.advance, content.beta, content.deviations, at, folded)
        share = (np.abs(rate) ** -0.5 - content.roots[0]) / np.diff(content.roots)
        scale = content.scale.reshape(-1, *w.ndim * (1,)) * rate**2
        values = (ends[0] * (1.0 - share) + ends[1] * share) * scale
        return Deviation(*values, values[TORQUE] * np.abs(rate))

    def gradient(self, omega: ArrayLike, speed: ArrayLike, beta: ArrayLike) -> Gradient:
        """Return the derivatives of the loads with respect to omega, speed and beta.

        They are along the last axis, and NaN outside the envelope.  ``omega``, ``speed`` and
        ``beta`` are those of ``loads``.
        """
        w, v, b = arrays_of(omega=omega, speed=speed, beta=beta)
        with np.errstate(invalid="ignore"):
            sign = np.where(np.remainder(b, 2.0 * np.pi) > np.pi, -1.0, 1.0)
        return self._by_chunks(self._polar_gradient, *self._inside(w, v, b), sign)

    def gradient_at_velocity(self, omega: ArrayLike, velocity: ArrayLike) -> Gradient:
        """Return the derivatives of the loads with respect to omega and x, y, z of the velocity.

        They are along the last axis, and NaN outside the envelope.  ``omega`` and ``velocity`` are
        those of ``loads_at_velocity``.  Without in-plane velocity, in-plane loads have no direction
        and the derivatives are the one-sided derivatives for an in-plane velocity along x.
        """
        w, x, y, z = arrays_of(omega=omega, **components(velocity))
        across = np.hypot(x, y)
        points = self._inside(w, np.hypot(across, z), np.arctan2(across, z))
        return self._by_chunks(self._velocity_gradient, *points, x, y)

    def omega_for(
        self, quantity: str, value: ArrayLike, speed: ArrayLike, beta: ArrayLike
    ) -> Inverse:
        """Find the omega at which a load has a given value.

        Parameters
        ----------
        quantity : str
            "thrust" [N], "torque" [N m] or "power" [W].
        value, speed, beta : array_like
            Value of the load, V [m/s] and beta [rad], broadcast.
        """

        wanted, v, b = arrays_of(value=value, speed=speed, beta=beta)
        return solve(self, quantity, wanted, v, b)

    def _points(self, omega: Floats, speed: Floats, beta: Floats, clamp: bool) -> TableLoads:
        points = np.stack([each.ravel() for each in (omega, speed, beta)])
        *rows, code = self._core.loads(points, clamp)
        return TableLoads(*(row.reshape(omega.shape) for row in (*rows, code.astype(np.uint8))))

    def _inside(self, omega: Floats, speed: Floats, beta: Floats) -> Floats:
        """Return omega, speed and beta in 0...pi (3, ...): points outside the envelope by rounding
        only are moved inside; other points outside have omega NaN."""
        points = np.stack([each.ravel() for each in (omega, speed, beta)])
        found: Floats = self._core.bounded(points).reshape(3, *omega.shape)
        return found

    def _by_chunks(self, gradient: Callable[..., Floats], *arrays: Floats) -> Gradient:
        """Return a ``gradient`` (n, L + 1, k) evaluated in chunks, in the shape of the points."""
        shape = arrays[0].shape
        flat = [np.ravel(array) for array in np.broadcast_arrays(*arrays)]
        parts = [
            gradient(*(array[start : start + CHUNK] for array in flat))
            for start in range(0, max(flat[0].size, 1), CHUNK)
        ]
        found = np.concatenate(parts)
        return Gradient(*found.swapaxes(0, 1).reshape(found.shape[1], *shape, found.shape[2]))

    def _polar_gradient(self, omega: Floats, speed: Floats, beta: Floats, sign: Floats) -> Floats:
        """Return d/d omega, d/d speed, d/d beta (n, L + 1, 3); ``sign`` is -1 for mirrored beta."""
        loads, by_omega, by_speed, by_angle = self._derivatives(omega, speed, beta)
        by_beta = by_angle * (sign * speed)[:, None]
        return _with_power(loads, omega, np.stack([by_omega, by_speed, by_beta], axis=-1))

    def _velocity_gradient(
        self, omega: Floats, speed: Floats, beta: Floats, vx: Floats, vy: Floats
    ) -> Floats:
        """Return d/d omega and d/d components of the velocity (n, L + 1, 4)."""
        loads, by_omega, by_speed, by_angle = self._derivatives(omega, speed, beta)
        by_axial, by_inplane = cartesian_slopes(by_speed, by_angle, np.cos(beta), np.sin(beta))
        across = np.hypot(vx, vy)
        moves = across > 0.0
        divisor = np.where(moves, across, 1.0)
        x, y = np.where(moves, vx / divisor, 1.0)[:, None], (vy / divisor)[:, None]
        each = np.stack([by_omega, by_inplane * x, by_inplane * y, by_axial], axis=-1)
        return _with_power(loads, omega, each)

    def _derivatives(
        self, omega: Floats, speed: Floats, beta: Floats
    ) -> tuple[Floats, Floats, Floats, Floats]:
        tip_speed = np.abs(omega) * self.content.radius
        advance, root = speed / tip_speed, np.abs(omega) ** -0.5 - self.content.roots[0]
        found = self._core.slopes(advance, beta)
        return chain_rule(found, omega, advance, tip_speed, root, np.where)


# --- Derivatives of a table's loads, by the chain rule through J, beta and Omega^(-1/2) ----------

HARDLY_MOVING = 1e-7  # advance ratio below which (d/dbeta)/J is replaced by its limit


def chain_rule(
    found: Any, omega: Any, advance: Any, tip_speed: Any, root: Any, where: Callable[..., Any]
) -> tuple[Any, Any, Any, Any]:
    """Return loads, d/d omega, d/d speed, and d/d beta divided by the speed, (..., L).

    ``found`` is the result of the core's ``Table.slopes`` at ``omega`` [rad/s], J and
    |Omega| R [m/s]; ``root`` is |Omega|^(-1/2) minus its value at the least omega.  ``where`` is
    the function of NumPy or JAX."""
    both = found[..., :HALF] + root[..., None, None, None] * found[..., HALF:]
    value, by_beta = both[..., 0, 0, :], both[..., 0, 1, :]
    by_advance, mixed = both[..., 1, 0, :], both[..., 1, 1, :]
    omega, advance = omega[..., None], advance[..., None]
    resting = advance < HARDLY_MOVING
    by_angle = where(resting, mixed, by_beta / where(resting, 1.0, advance))
    square = omega**2
    # dJ/dOmega = -J / Omega; the Reynolds term is linear in Omega^(-1/2).
    by_root = found[..., 0, 0, HALF:] * (-0.5 * abs(omega) ** -0.5 / omega)
    by_omega = square * (2.0 * value / omega - by_advance * (advance / omega) + by_root)
    per_speed = square / tip_speed[..., None]
    return square * value, by_omega, per_speed * by_advance, per_speed * by_angle


def cartesian_slopes(by_speed: Any, by_angle: Any, cosine: Any, sine: Any) -> tuple[Any, Any]:
    """Return d/d axial and d/d in-plane velocity from d/d speed and d/d angle (..., L)."""
    cosine, sine = cosine[..., None], sine[..., None]
    return by_speed * cosine - by_angle * sine, by_speed * sine + by_angle * cosine


def _with_power(loads: Floats, omega: Floats, each: Floats) -> Floats:
    """Append the derivatives of the power to ``each`` (n, L, k), d/d omega first; (n, L + 1, k)."""
    power = each[:, TORQUE] * omega[:, None]
    power[:, 0] += loads[:, TORQUE]
    return np.concatenate([each, power[:, None]], axis=1)


# --- The rotational speed for a given load -------------------------------------------------------

QUANTITIES = ("thrust", "torque", "power")

END_SLACK = 1e-11  # relative difference that counts as rounding at an end of the envelope


class Inverse(NamedTuple):
    """The rotational speeds at which a load has a given value; arrays of one shape.

    Attributes
    ----------
    omega, least : ndarray
        Largest and smallest solution [rad/s]; NaN without a solution.
    solutions : ndarray of int
        Number of solutions inside the envelope.
    status : ndarray of str
        "ok" for one solution, "none" or "several".
    """

    omega: Floats
    least: Floats
    solutions: NDArray[np.int64]
    status: NDArray[np.str_]


def solve(table: LoadTable, quantity: str, value: Floats, speed: Floats, beta: Floats) -> Inverse:
    """Find every omega of the envelope at which a load has a given value; all arrays have one
    shape.  Several solutions occur if the blades windmill at low omega."""
    if quantity not in QUANTITIES:
        raise InputError(f"quantity is {quantity!r}: it must be one of {', '.join(QUANTITIES)}")
    shape = value.shape
    points = zip(*(each.ravel().tolist() for each in (value, speed, beta)), strict=True)
    roots = [_roots(table, quantity, *point) for point in points]
    count = np.array([len(found) for found in roots], np.int64).reshape(shape)
    largest = np.array([found[-1] if found else np.nan for found in roots]).reshape(shape)
    least = np.array([found[0] if found else np.nan for found in roots]).reshape(shape)
    status = np.array(["none", "ok", "several"])[np.minimum(count, 2)]
    return Inverse(largest, least, count, status)


def _roots(table: LoadTable, quantity: str, value: float, speed: float, beta: float) -> list[float]:
    """Return the omegas at which the load is ``value``, in ascending order."""
    # The load is smooth between two omegas at which the advance ratio crosses a knot.
    low, high = table.envelope["omega"]
    with np.errstate(divide="ignore", invalid="ignore"):
        crossed = math.copysign(speed, low) / (table.content.advance * table.content.radius)
    crossed = crossed[(crossed > low) & (crossed < high)]
    ends = np.unique(np.concatenate([[low], crossed, [high]]))
    omega = np.sort(np.concatenate([ends, 0.5 * (ends[:-1] + ends[1:])]))
    field = getattr(table.loads(omega, speed, beta), quantity) - value
    slope = getattr(table.gradient(omega, speed, beta), quantity)[:, 0]
    # An excess within rounding at an end of the envelope counts as a solution.
    near = np.abs(field) <= END_SLACK * np.fmax(np.abs(omega * slope), abs(value))
    near[1:-1] = False
    field = np.where(near, 0.0, field)

    def excess(w: float) -> float:
        return float(getattr(table.loads(w, speed, beta), quantity)) - value

    def rate(w: float) -> float:
        return float(getattr(table.gradient(w, speed, beta), quantity)[0])

    found: list[float] = []
    points = list(zip(omega.tolist(), field.tolist(), slope.tolist(), strict=True))
    for (a, fa, da), (b, fb, db) in itertools.pairwise(points):
        if fa * fb >= 0.0 and da * db < 0.0:
            # The load has an extremum in between, and may have the value on either side of it.
            turn = _bisect(rate, a, b, da)
            middle = excess(turn)
            found += _met(excess, a, fa, turn, middle) + _met(excess, turn, middle, b, fb)
        else:
            found += _met(excess, a, fa, b, fb)
    if points[-1][1] == 0.0:
        found.append(points[-1][0])
    return found


def _met(
    excess: Callable[[float], float], low: float, at_low: float, high: float, at_high: float
) -> list[float]:
    """Return the root in [low, high), if any, of a function that is monotonic there."""
    if at_low == 0.0:
        return [low]
    return [_bisect(excess, low, high, at_low)] if at_low * at_high < 0.0 else []


def _bisect(function: Callable[[float], float], low: float, high: float, start: float) -> float:
    """Return the root of a ``function`` with the sign of ``start`` at low, the opposite at high."""
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
