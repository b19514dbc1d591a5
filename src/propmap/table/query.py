"""``LoadTable``: loads from a table, with NumPy alone."""

from __future__ import annotations

import math
import os
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.errors import InputError
from propmap.table.arguments import broadcast, fold, split_velocity
from propmap.table.content import TableContent
from propmap.table.deviations import bilinear
from propmap.table.gradient import polar_gradient, velocity_gradient
from propmap.table.lookup import CLAMPED, NO_VALUE, OUTSIDE, WIDTH, Lookup
from propmap.table.results import TORQUE, Deviation, Gradient, TableLoads
from propmap.table.table_file import read_table, write_table
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.model.propeller import Propeller
    from propmap.table.inverse import Inverse

CHUNK = 1024
"""Points that are interpolated together, so that what they gather stays in the cache."""

SLACK = 1e-9
"""Share of an axis by which a point may lie beyond its end for rounding: 10000 rpm is not the
same number however it is converted."""


HALF = WIDTH // 2

_NOWHERE = TableLoads(*(HALF + 1) * [math.nan], OUTSIDE)


class LoadTable:
    """Loads of one rotor over an envelope of operating points.

    Make one with ``LoadTable.load`` or ``build_table``.  The envelope is a box in omega [rad/s],
    speed [m/s] and beta [rad]; see ``envelope``.

    Parameters
    ----------
    content : TableContent
        What the table holds.
    """

    def __init__(self, content: TableContent) -> None:
        self.content = content
        self._lookup = Lookup(content)
        ends = (content.omega, content.speed, content.beta[[0, -1]])
        self._box = tuple((float(low), float(high)) for low, high in ends)
        self._slack = tuple(SLACK * (high - low) for low, high in self._box)
        self._radius = content.radius
        self._root = float(content.omega[0]) ** -0.5

    def __repr__(self) -> str:
        box = ", ".join(f"{k} {low:g} to {high:g}" for k, (low, high) in self.envelope.items())
        return f"LoadTable({self.info['propeller'].get('name')}, {box})"

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, propeller: Propeller | None = None) -> Self:
        """Read a table from a .npz file; nothing in it is executed.

        Parameters
        ----------
        path : path
            Of the file.
        propeller : Propeller, optional
            The geometry that the table must have been built from.

        Raises
        ------
        InputError
            For a missing, damaged or foreign file, one of a later format, and a table of another
            propeller.
        """
        content = read_table(path)
        if propeller is not None:
            described = content.info["propeller"]
            if described.get("geometry_sha256") != propeller.fingerprint():
                raise InputError(
                    f"the table is of {described.get('name')!r}, expected {propeller.name!r} with "
                    "the same geometry",
                    "build a table for this propeller",
                    os.fspath(path),
                )
        return cls(content)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the table to the .npz file at ``path``, whole or not at all."""
        write_table(self.content, path)

    @property
    def envelope(self) -> dict[str, tuple[float, float]]:
        """Least and largest omega [rad/s], speed [m/s] and beta [rad]."""
        return dict(zip(("omega", "speed", "beta"), self._box, strict=True))

    @property
    def info(self) -> dict[str, Any]:
        """Where the table comes from: propeller, airfoil, air, versions; plain data."""
        return self.content.info

    @property
    def certificate(self) -> dict[str, Any]:
        """The table's errors against the model, see ``propmap.table.Certificate``; plain data."""
        return dict(self.info.get("certificate") or {})

    def loads(
        self, omega: ArrayLike, speed: ArrayLike, beta: ArrayLike, *, clamp: bool = False
    ) -> TableLoads:
        """Loads at operating points.

        Parameters
        ----------
        omega, speed, beta : array_like
            Omega [rad/s], V [m/s], beta [rad], broadcast; beta and 2 pi - beta are mirror images
            with the same loads.
        clamp : bool
            Whether a point outside the envelope gets the loads at the nearest omega, speed and
            beta of it, with the status "clamped", in place of NaN.
        """
        if (
            isinstance(omega, (float, int))
            and isinstance(speed, (float, int))
            and isinstance(beta, (float, int))
        ):
            return self._point(omega, speed, beta, clamp)
        w, v, b = broadcast(omega=omega, speed=speed, beta=beta)
        if w.ndim == 0:
            return self._point(float(w), float(v), float(b), clamp)
        return self._points(w, v, b, clamp)

    def loads_at_velocity(
        self, omega: ArrayLike, velocity: ArrayLike, *, clamp: bool = False
    ) -> TableLoads:
        """Loads for a velocity vector in the rotor frame.

        Parameters
        ----------
        omega : array_like, shape (...)
            Omega [rad/s].
        velocity : array_like, shape (..., 3)
            Of the hub through the air [m/s], z along the thrust; broadcast with ``omega``.
        clamp : bool
            As in ``loads``.
        """
        if isinstance(omega, (float, int)) and np.shape(velocity) == (3,):
            x, y, z = map(float, velocity)
            across = math.hypot(x, y)
            return self._point(omega, math.hypot(across, z), math.atan2(across, z), clamp)
        w, x, y, z = split_velocity(omega, velocity)
        across = np.hypot(x, y)
        return self.loads(w, np.hypot(across, z), np.arctan2(across, z), clamp=clamp)

    def std(self, omega: ArrayLike, speed: ArrayLike, beta: ArrayLike) -> Deviation:
        """Standard deviations of the model's loads; NaN outside the envelope.

        Those of the constants and of the blade, of the model itself and of another tunnel, see
        ``propmap.Loads.std_by_source``; the table's own errors, see ``certificate``, come on top.

        Parameters
        ----------
        omega, speed, beta : array_like
            As in ``loads``.

        Raises
        ------
        InputError
            Where the table does not say them: its model says nothing of its errors.
        """
        content = self.content
        if content.deviations is None:
            raise InputError(
                "the table says nothing of its model's errors",
                "build it of constants identified or expected by name, or of a fit's file",
            )
        w, v, b = broadcast(omega=omega, speed=speed, beta=beta)
        rate, speeds, folded, _ = self._bounded(w, v, fold(b)[0], clamp=False)
        lost = np.isnan(rate)
        advance = speeds / (np.where(lost, content.omega[0], rate) * content.radius)
        at = np.clip(advance, content.advance[0], content.advance[-1])
        ends = bilinear(content.advance, content.beta, content.deviations, at, folded)
        roots = content.omega**-0.5
        share = (rate**-0.5 - roots[0]) / (roots[1] - roots[0])
        scale = content.scale.reshape(-1, *w.ndim * (1,)) * rate**2
        values = (ends[0] * (1.0 - share) + ends[1] * share) * scale
        return Deviation(*values, values[TORQUE] * rate)

    def gradient(self, omega: ArrayLike, speed: ArrayLike, beta: ArrayLike) -> Gradient:
        """Derivatives by ``omega``, ``speed`` and ``beta``, as the last axis (3,); NaN outside.

        Arguments are those of ``loads``.
        """
        w, v, b = broadcast(omega=omega, speed=speed, beta=beta)
        folded, sign = fold(b)
        w, v, folded, _ = self._bounded(w, v, folded, clamp=False)
        return self._by_chunks(polar_gradient, w, v, folded, sign)

    def gradient_at_velocity(self, omega: ArrayLike, velocity: ArrayLike) -> Gradient:
        """Derivatives by ``omega`` and x, y, z of ``velocity``, as the last axis (4,); NaN outside.

        Arguments are those of ``loads_at_velocity``.  Without in-plane velocity, where loads by
        it point nowhere, the derivatives are those for one that begins to grow along x.
        """
        w, x, y, z = split_velocity(omega, velocity)
        across = np.hypot(x, y)
        speed, beta = np.hypot(across, z), np.arctan2(across, z)
        w, speed, beta, _ = self._bounded(w, speed, beta, clamp=False)
        return self._by_chunks(velocity_gradient, w, speed, beta, x, y)

    def omega_for(
        self, quantity: str, value: ArrayLike, speed: ArrayLike, beta: ArrayLike
    ) -> Inverse:
        """Find the omega at which a load has a value.

        Parameters
        ----------
        quantity : str
            "thrust" [N], "torque" [N m] or "power" [W].
        value, speed, beta : array_like
            Its value, V [m/s] and beta [rad], broadcast.
        """
        from propmap.table.inverse import solve

        wanted, v, b = broadcast(value=value, speed=speed, beta=beta)
        return solve(self, quantity, wanted, v, fold(b)[0])

    def _point(self, omega: float, speed: float, beta: float, clamp: bool) -> TableLoads:
        (w0, w1), (v0, v1), (b0, b1) = self._box
        if not 0.0 <= beta <= math.pi and math.isfinite(beta):
            beta = abs(math.remainder(beta, 2.0 * math.pi))
        clamped = False
        if not (w0 <= omega <= w1 and v0 <= speed <= v1 and b0 <= beta <= b1):
            w, v, b = min(max(omega, w0), w1), min(max(speed, v0), v1), min(max(beta, b0), b1)
            dw, dv, db = self._slack
            beyond = not (abs(w - omega) <= dw and abs(v - speed) <= dv and abs(b - beta) <= db)
            if beyond and not (clamp and omega == omega and speed == speed and beta == beta):
                return _NOWHERE
            omega, speed, beta, clamped = w, v, b, beyond
        square = omega * omega
        friction = square * (omega**-0.5 - self._root)
        loads, code = self._lookup.point(speed / (omega * self._radius), beta, square, friction)
        if loads[0] != loads[0]:
            code = NO_VALUE
        elif clamped:
            code = CLAMPED
        return TableLoads(*loads, loads[TORQUE] * omega, code)

    def _points(self, omega: Floats, speed: Floats, beta: Floats, clamp: bool) -> TableLoads:
        shape = omega.shape
        folded, _ = fold(beta.ravel())
        w, v, b, outside = self._bounded(omega.ravel(), speed.ravel(), folded, clamp=clamp)
        loads = np.empty((HALF, w.size))
        code = np.empty(w.size, np.uint8)
        for start in range(0, w.size, CHUNK):
            cut = slice(start, start + CHUNK)
            rate = w[cut]
            values, code[cut] = self._lookup.points(v[cut] / (rate * self._radius), b[cut])
            values[:, HALF:] *= (rate**-0.5 - self._root)[:, None]
            total = values[:, :HALF] + values[:, HALF:]
            total *= (rate * rate)[:, None]
            loads[:, cut] = total.T
        code[outside] = CLAMPED
        code[np.isnan(loads[0])] = NO_VALUE
        code[np.isnan(w)] = OUTSIDE
        fields = (*loads, loads[TORQUE] * w, code)
        return TableLoads(*(field.reshape(shape) for field in fields))

    def _bounded(
        self, omega: Floats, speed: Floats, beta: Floats, *, clamp: bool
    ) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
        """The points inside the envelope, and which were not; NaN there unless ``clamp``."""
        given = (omega, speed, beta)
        held = [
            np.array(np.clip(x, low, high)) for x, (low, high) in zip(given, self._box, strict=True)
        ]
        # Written so that NaN counts as outside.
        within = [
            np.abs(x - y) <= slack for x, y, slack in zip(given, held, self._slack, strict=True)
        ]
        outside = ~(within[0] & within[1] & within[2])
        if outside.any():
            lost = outside & np.isnan(omega + speed + beta) if clamp else outside
            for x, value in zip(held, (np.nan, self._box[1][0], self._box[2][0]), strict=True):
                x[lost] = value
        return held[0], held[1], held[2], outside

    def _by_chunks(self, gradient: Any, *arrays: Floats) -> Gradient:
        shape = arrays[0].shape
        flat = [np.ravel(array) for array in np.broadcast_arrays(*arrays)]
        parts = [
            gradient(self.content, self._lookup, *(array[start : start + CHUNK] for array in flat))
            for start in range(0, max(flat[0].size, 1), CHUNK)
        ]
        found = np.concatenate(parts)
        return Gradient(*found.swapaxes(0, 1).reshape(found.shape[1], *shape, found.shape[2]))
