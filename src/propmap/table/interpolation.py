"""Content of a table, and the interpolation of its coefficients between knots."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.typing import Floats
from propmap.units import SPEED_OF_SOUND

PARITY = np.array([-1.0 if load.inplane else 1.0 for load in LOADS.values()])
"""Parity of the loads across beta = 0 and pi: -1 for in-plane loads, which are odd, otherwise 1."""

VORTEX_RING_BIT, UNRESOLVED_BIT = 1, 2
"""Bits of a cell's flags: momentum theory is not valid, or the table's error exceeds the tolerance,
at a point of the cell."""


@dataclass(frozen=True)
class TableContent:
    """Content of a table's file; raises ``InputError`` for inconsistent parts."""

    advance: Floats  # knots of J = V/(Omega R) (n,) [-]
    beta: Floats  # knots (m,) [rad]; the first and the last one limit the envelope
    omega: Floats  # least and largest of the envelope (2,) [rad/s]; both negative for a propeller
    # that turns backward, where |Omega| replaces Omega in J and Omega^(-1/2)
    speed: Floats  # least and largest of the envelope (2,) [m/s]
    # The loads at both ends of omega in the order of ``LOADS``, forces / (rho pi R^4 Omega^2)
    # and moments / (rho pi R^5 Omega^2) (2, L, n, m) [-]; NaN for no value.  Between the ends they
    # are linear in Omega^(-1/2), like the friction term of eq. (4).
    coefficients: Floats
    cells: NDArray[np.uint8]  # sum of ``VORTEX_RING_BIT`` and ``UNRESOLVED_BIT`` (n - 1, m - 1)
    info: dict[str, Any]  # provenance and the certificate, as plain data for JSON
    deviations: Floats | None = None  # standard deviations of ``coefficients``, if known

    def __post_init__(self) -> None:
        n, m = self.advance.size, self.beta.size
        shapes = {
            "advance": (n,),
            "beta": (m,),
            "omega": (2,),
            "speed": (2,),
            "coefficients": (2, len(LOADS), n, m),
            "cells": (n - 1, m - 1),
        }
        if self.deviations is not None:
            shapes["deviations"] = shapes["coefficients"]
            if ((self.deviations < 0.0) | np.isinf(self.deviations)).any():
                raise InputError("a standard deviation is negative or infinite")
        for name, shape in shapes.items():
            found = getattr(self, name).shape
            if found != shape:
                raise InputError(f"{name} has shape {found}, expected {shape}")
        for name in ("advance", "beta", "omega", "speed"):
            values = getattr(self, name)
            # The interpolation divides by the distances of the knots.
            if not (np.isfinite(values).all() and (np.diff(values) > 1e-9 * abs(values[-1])).all()):
                raise InputError(f"the values of {name} do not increase")
        if min(n, m) < 4:
            raise InputError(f"the table has {n} x {m} knots, expected at least 4 on each axis")
        if self.omega[0] * self.omega[1] <= 0.0 or self.speed[0] < 0.0 or self.advance[0] < 0.0:
            raise InputError("omega must not include 0, and speed and advance must not be negative")
        if self.beta[0] < 0.0 or self.beta[-1] > np.pi:
            raise InputError("beta must be between 0 and pi")
        for name, value in (("radius", self.radius), ("density", self.density)):
            if not (isinstance(value, float) and 0.0 < value < np.inf):
                raise InputError(f"{name} is {value!r}, expected a positive number")
        # The envelope determines the ends of the advance ratio.  A disagreement therefore reveals a
        # value in a wrong unit.
        with np.errstate(over="ignore", divide="ignore"):
            least, most = self.speed / (np.sort(np.abs(self.omega))[::-1] * self.radius)
        if self.advance[0] > least * (1.0 + 1e-6) or not np.isclose(self.advance[-1], most, 1e-6):
            found = f"advance is {self.advance[0]:g} to {self.advance[-1]:g}, but speed, omega and "
            raise InputError(f"{found}radius allow {least:g} to {most:g}")
        size, lost = np.abs(self.coefficients), np.isnan(self.coefficients)
        axial = np.zeros((n, m), bool)
        axial[self.advance == 0.0], axial[:, [0, -1]] = True, on_planes(self.beta)
        across, least = size[:, PARITY < 0.0][..., axial], 1e-6 * np.fmax.reduce(size, axis=None)
        # Largest possible coefficients: twice the dynamic pressure at the tip times the disk area.
        faults = {
            f"a cell has the flags {self.cells.max()}, expected 0 to 3": self.cells > 3,
            "the tip is faster than Mach 1": np.abs(self.omega) * self.radius > SPEED_OF_SOUND,
            "a coefficient is too large": size > 1.0 + np.square(self.advance[:, None]),
            "a knot has some loads, but not all": lost.any(axis=1) != lost.all(axis=1),
            "an in-plane load is not zero in axial flow": across > least,
        }
        for fault, wrong in faults.items():
            if wrong.any():
                raise InputError(fault)

    @property
    def sha256(self) -> str:
        """Hash of the little-endian numbers: axes, envelope, coefficients, cells, deviations."""
        axes = (self.advance, self.beta, self.omega, self.speed)
        digest = hashlib.sha256(np.concatenate(axes).astype("<f8").tobytes())
        digest.update(np.ascontiguousarray(self.coefficients, "<f4").data)
        digest.update(np.ascontiguousarray(self.cells).data)
        if self.deviations is not None:
            digest.update(np.ascontiguousarray(self.deviations, "<f4").data)
        return digest.hexdigest()

    @property
    def radius(self) -> float:
        """Tip radius [m]."""
        return self._entry("propeller", "radius_m")

    @property
    def density(self) -> float:
        """Density of the air [kg/m^3]."""
        return self._entry("air", "density_kg_m3")

    @property
    def scale(self) -> Floats:
        """Load / (coefficient Omega^2), in the order of ``LOADS``; (L,) [N s^2], [N m s^2]."""
        return coefficient_scale(self.density, self.radius)

    def _entry(self, group: str, name: str) -> Any:
        try:
            return self.info[group][name]
        except (KeyError, TypeError):
            raise InputError(f"the table does not contain {group}.{name}") from None

    @property
    def roots(self) -> Floats:
        """Omega^(-1/2) at both ends of the envelope (2,) [s^(1/2)]."""
        return np.abs(self.omega) ** -0.5

    def padded(self) -> Floats:
        """Return loads / Omega^2 at the least omega [N s^2], [N m s^2], then their derivatives
        with respect to Omega^(-1/2), with ghost values on all sides; (n + 2, m + 2, 2 L)."""
        low, high = self.coefficients
        both = np.concatenate([low, (high - low) / np.diff(self.roots)])
        inside = pad(self.advance, both.transpose(1, 2, 0), None, None)
        parity = np.tile(PARITY, 2)
        ends = (parity if on else None for on in on_planes(self.beta))
        across = pad(self.beta, inside.transpose(1, 0, 2), *ends)
        return np.ascontiguousarray(across.transpose(1, 0, 2) * np.tile(self.scale, 2))


def coefficient_scale(density: float, radius: float) -> Floats:
    """Return rho pi R^4 for forces and rho pi R^5 for moments, in the order of ``LOADS``; (L,)."""
    force = density * np.pi * radius**4
    return force * np.array([radius if load.moment else 1.0 for load in LOADS.values()])


# --- Status of a point, and bilinear interpolation between knots ---------------------------------

STATUSES = ("ok", "vortex_ring", "unresolved", "clamped", "no_value", "outside", "reversed")
"""Names of the status codes, from harmless to fatal; if several apply, a point has the last one.
For a propeller that turns backward, "reversed" replaces "ok"."""

OK, VORTEX_RING, UNRESOLVED, CLAMPED, NO_VALUE, OUTSIDE, REVERSED = range(len(STATUSES))


def cell_codes(content: TableContent) -> NDArray[np.uint8]:
    """Return codes (n - 1, m - 1): ``OK`` or ``REVERSED``, ``VORTEX_RING`` or ``UNRESOLVED``."""
    fine = OK if content.omega[0] > 0.0 else REVERSED
    return np.array([fine, VORTEX_RING, UNRESOLVED, UNRESOLVED], np.uint8)[content.cells]


def bilinear(x: Floats, y: Floats, values: Floats, at_x: Floats, at_y: Floats) -> Floats:
    """Interpolate values (..., n, m) at knots x (n,), y (m,) bilinearly at ``at_x`` and ``at_y``,
    which broadcast to the last axes of the result."""
    i, t = locate(x, at_x)
    j, u = locate(y, at_y)
    low = values[..., i, j] * (1.0 - t) + values[..., i + 1, j] * t
    high = values[..., i, j + 1] * (1.0 - t) + values[..., i + 1, j + 1] * t
    return np.asarray(low * (1.0 - u) + high * u)


# -------------------------------------------------------------------------------------------------
# One axis of a table: C1 cubic interpolation between knots at any distances.
#
# Each interval has a cubic Hermite polynomial.  Its slope at a knot is the slope of the parabola
# through the knot and its two neighbors.  The polynomial therefore depends on four values: the ends
# of the interval and the next value on each side.  At an end of the axis, a ghost value replaces
# the missing one.


def interval_polynomials(knots: Floats) -> Floats:
    """Return polynomials (n - 1, 4, 4) between n >= 3 knots.  In interval i, at fraction t of its
    width, the weight of value k of four is the sum over m of coefficients[i, k, m] t^m."""
    wide = with_ghosts(knots)
    before, width, after = wide[1:-2] - wide[:-3], wide[2:-1] - wide[1:-2], wide[3:] - wide[2:-1]
    zero = np.zeros_like(width)
    # Slopes of the parabolas at both ends, times the width, as weights of the four values.
    left = _parabola_slope(before, width)
    right = _parabola_slope(width, after)
    first = width * np.stack([*left, zero])
    second = width * np.stack([zero, *right])
    start = np.stack([zero, zero + 1.0, zero, zero])
    rise = np.stack([zero, zero - 1.0, zero + 1.0, zero])
    powers = [start, first, 3.0 * rise - 2.0 * first - second, first + second - 2.0 * rise]
    return np.ascontiguousarray(np.stack(powers).transpose(2, 1, 0))


def with_ghosts(knots: Floats) -> Floats:
    """Return knots with a ghost knot at each end, the mirror image of the next one; (n + 2,)."""
    return np.concatenate(
        [[2.0 * knots[0] - knots[1]], knots, [2.0 * knots[-1] - knots[-2]]], dtype=np.float64
    )


def on_planes(beta: Floats) -> tuple[bool, bool]:
    """Return whether the first angle is 0 and the last one pi [rad], where loads have parity."""
    return bool(abs(beta[0]) < 1e-9), bool(abs(beta[-1] - np.pi) < 1e-9)


def pad(knots: Floats, values: Floats, low: Floats | None, high: Floats | None) -> Floats:
    """Return values (n, ...) with a ghost value at each end.  On a plane of symmetry, ``low`` or
    ``high`` is the parity, 1 or -1; None extrapolates a parabola through three values."""
    wide = with_ghosts(knots)
    ghosts = []
    for parity, ends, ghost in ((low, slice(0, 3), wide[0]), (high, slice(-1, -4, -1), wide[-1])):
        x, y = knots[ends], values[ends]
        if parity is None:
            ghosts.append(np.tensordot(_parabola(x, ghost), y, 1))
        else:
            ghosts.append(parity * y[1])
    return np.concatenate([ghosts[0][None], values, ghosts[1][None]])


def locate(knots: Floats, x: Floats) -> tuple[NDArray[np.intp], Floats]:
    """Return the interval that contains each x, and the fraction of its width below x."""
    i = np.searchsorted(knots[1:-1], x, side="right")
    return i, (x - knots[i]) / (knots[i + 1] - knots[i])


def interpolate(knots: Floats, padded: Floats, x: Floats) -> Floats:
    """Interpolate padded values (n + 2, ...) at x (m,) along the first axis; (m, ...)."""
    i, t = locate(knots, x)
    weights = np.einsum("akm,am->ak", interval_polynomials(knots)[i], t[:, None] ** np.arange(4))
    rows = padded[i[:, None] + np.arange(4)]
    return np.asarray(np.einsum("ak,ak...->a...", weights, rows))


def _parabola_slope(before: Floats, after: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the weights of three values in the slope at the middle one, for these distances."""
    both = before + after
    return -after / (before * both), (after - before) / (before * after), before / (after * both)


def _parabola(x: Floats, at: float) -> Floats:
    a, b, c = x.tolist()
    return np.array(
        [
            (at - b) * (at - c) / ((a - b) * (a - c)),
            (at - a) * (at - c) / ((b - a) * (b - c)),
            (at - a) * (at - b) / ((c - a) * (c - b)),
        ]
    )


# -------------------------------------------------------------------------------------------------
# Positions of operating points in units of cells: the errors of a table vary on the scale of cells.
#
# A position (n, 3) contains the number of cells below the point, along the advance ratio and along
# beta.  The fraction is the position in the cell of the point.  The third value is the fraction of
# the range of omega that the envelope allows at this advance ratio.


def most_position(content: TableContent) -> Floats:
    """Return the largest position (3,); the smallest one is zero."""
    return np.array([content.advance.size - 1.0, content.beta.size - 1.0, 1.0])


def points_at(content: TableContent, position: Floats) -> tuple[Floats, Floats, Floats]:
    """Return omega, speed and beta (n,) at positions (n, 3)."""
    advance, beta = (
        np.interp(position[:, axis], np.arange(knots.size), knots)
        for axis, knots in enumerate((content.advance, content.beta))
    )
    least, most = _omegas(content, advance)
    omega = least + position[:, 2] * (most - least)
    speed = np.clip(advance * content.radius * np.abs(omega), *content.speed)
    return omega, speed, beta


def positions_of(content: TableContent, omega: Floats, advance: Floats, beta: Floats) -> Floats:
    """Return the positions (n, 3) of points (n,) in the envelope."""
    along, across = (
        np.add(*locate(knots, values))
        for knots, values in ((content.advance, advance), (content.beta, beta))
    )
    least, most = _omegas(content, advance)
    share = np.divide(omega - least, most - least, out=np.zeros_like(omega), where=most != least)
    return np.clip(np.stack([along, across, share], axis=1), 0.0, most_position(content))


def _omegas(content: TableContent, advance: Floats) -> tuple[Floats, Floats]:
    """Return the omegas (n,) at the ends of the envelope for these advance ratios."""
    turning, per_omega = np.abs(content.omega), advance * content.radius
    moves = per_omega > 0.0
    bounds = [
        np.divide(speed, per_omega, out=np.full_like(advance, end), where=moves)
        for speed, end in zip(content.speed, np.sort(turning), strict=True)
    ]
    slowest, fastest = np.sign(content.omega[0]) * np.clip(bounds, turning.min(), turning.max())
    return slowest, fastest
