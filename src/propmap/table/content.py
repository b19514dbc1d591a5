"""What a table holds: axes, coefficients, flags, and where they come from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.table.axis import on_planes, pad
from propmap.typing import Floats

PARITY = np.array([-1.0 if load.inplane else 1.0 for load in LOADS.values()])
"""How the loads behave across beta = 0 and pi: along and about the axis they are even, across
it they are odd."""

VORTEX_RING, UNRESOLVED = 1, 2
"""Bits of a cell's flags: momentum theory does not hold somewhere in it; the table's error
exceeds the tolerance somewhere in it."""


@dataclass(frozen=True)
class TableContent:
    """A table as it is filed.

    Attributes
    ----------
    advance : ndarray, shape (n,)
        Knots of J = V/(Omega R) [-].
    beta : ndarray, shape (m,)
        Knots [rad]; the first and the last are the envelope's.
    omega, speed : ndarray, shape (2,)
        Least and largest of the envelope [rad/s], [m/s].
    coefficients : ndarray, shape (2, L, n, m)
        At both ends of omega, the loads in the order of ``LOADS`` over rho pi R^4 Omega^2
        (forces) and rho pi R^5 Omega^2 (moments) [-]; NaN for no value.  Between the ends they
        are linear in Omega^(-1/2), as the friction term of eq. (4) is.
    cells : ndarray of uint8, shape (n - 1, m - 1)
        ``VORTEX_RING`` and ``UNRESOLVED`` added up.
    info : dict
        Provenance and the certificate, as plain data for JSON.
    deviations : ndarray, shape (2, L, n, m), or None
        Standard deviations of the model's loads, like ``coefficients`` [-]; None where nothing is
        known of them.

    Raises
    ------
    InputError
        Where these do not fit together.
    """

    advance: Floats
    beta: Floats
    omega: Floats
    speed: Floats
    coefficients: Floats
    cells: NDArray[np.uint8]
    info: dict[str, Any]
    deviations: Floats | None = None

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
            if (self.deviations < 0.0).any():
                raise InputError("a standard deviation is negative")
        for name, shape in shapes.items():
            found = getattr(self, name).shape
            if found != shape:
                raise InputError(f"{name} has shape {found}, expected {shape}")
        for name in ("advance", "beta", "omega", "speed"):
            values = getattr(self, name)
            if not (np.isfinite(values).all() and (np.diff(values) > 0.0).all()):
                raise InputError(f"the values of {name} do not rise")
        if min(n, m) < 4:
            raise InputError(f"the table has {n} x {m} knots, expected 4 at least on each axis")
        if self.omega[0] <= 0.0 or self.speed[0] < 0.0 or self.advance[0] < 0.0:
            raise InputError("omega must be positive, speed and advance not negative")
        if self.beta[0] < 0.0 or self.beta[-1] > np.pi:
            raise InputError("beta must lie between 0 and pi")
        if np.isinf(self.coefficients).any():
            raise InputError("a coefficient is infinite")
        for name, value in (("radius", self.radius), ("density", self.density)):
            if isinstance(value, bool) or not (isinstance(value, float) and 0.0 < value < np.inf):
                raise InputError(f"{name} is {value!r}, expected a positive number")

    @property
    def radius(self) -> float:
        """Of the tip [m]."""
        return _entry(self.info, "propeller", "radius_m")

    @property
    def density(self) -> float:
        """Of the air [kg/m^3]."""
        return _entry(self.info, "air", "density_kg_m3")

    @property
    def scale(self) -> Floats:
        """Loads per coefficient and Omega^2, in the order of ``LOADS``; (L,) [N s^2], [N m s^2]."""
        return coefficient_scale(self.density, self.radius)

    def padded(self) -> Floats:
        """Loads over Omega^2 (n + 2, m + 2, 2 L) with the ghost values that interpolation needs.

        The last axis: the loads at the least omega [N s^2], [N m s^2], then their slopes with
        Omega^(-1/2).
        """
        low, high = self.coefficients
        roots = self.omega**-0.5
        both = np.concatenate([low, (high - low) / (roots[1] - roots[0])])
        inside = pad(self.advance, both.transpose(1, 2, 0), None, None)
        parity = np.tile(PARITY, 2)
        ends = (parity if on else None for on in on_planes(self.beta))
        across = pad(self.beta, inside.transpose(1, 0, 2), *ends)
        return np.ascontiguousarray(across.transpose(1, 0, 2) * np.tile(self.scale, 2))


def coefficient_scale(density: float, radius: float) -> Floats:
    """rho pi R^4 of forces and rho pi R^5 of moments, in the order of ``LOADS``; (L,)."""
    force = density * np.pi * radius**4
    return force * np.array([radius if load.moment else 1.0 for load in LOADS.values()])


def _entry(info: dict[str, Any], group: str, name: str) -> Any:
    try:
        return info[group][name]
    except (KeyError, TypeError):
        raise InputError(f"the table does not say {group}.{name}") from None
