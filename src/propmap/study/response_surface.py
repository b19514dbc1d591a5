"""A quadratic through a study's results, and how well it foretells designs that it has not seen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from propmap.errors import InputError
from propmap.typing import Floats


@dataclass(frozen=True, eq=False)
class ResponseSurface:
    """A second-order polynomial of what varies.

    Attributes
    ----------
    names : tuple of str
        What varies.
    low, high : ndarray, shape (k,)
        Least and largest of each.
    coefficients : ndarray
        Of the terms in the order of ``_terms``.
    left_out_rms : float
        Root mean square error at designs left out of the fit one at a time, in the quantity's unit.
    """

    names: tuple[str, ...]
    low: Floats
    high: Floats
    coefficients: Floats
    left_out_rms: float

    def __call__(self, rows: Mapping[str, Floats]) -> Floats:
        """Values (n,) at designs; ``rows`` has values (n,) of each of ``names``."""
        return np.asarray(_terms(self._unit(rows)) @ self.coefficients)

    def middle(self) -> dict[str, float]:
        """The middle of the range of each of ``names``."""
        return dict(zip(self.names, (0.5 * (self.low + self.high)).tolist(), strict=True))

    def _unit(self, rows: Mapping[str, Floats]) -> Floats:
        """What varies (n, k), each from -1 to 1."""
        values = np.stack([np.asarray(rows[name], np.float64) for name in self.names], axis=1)
        return np.asarray(2.0 * (values - self.low) / (self.high - self.low) - 1.0)


def response_surface(rows: Mapping[str, Floats], values: Floats) -> ResponseSurface:
    """Fit a quadratic by least squares.

    Parameters
    ----------
    rows : mapping of str to ndarray, shape (n,)
        What varies.
    values : ndarray, shape (n,)
        The quantity; designs where it is NaN are left out.

    Raises
    ------
    InputError
        For fewer designs than the quadratic has coefficients.
    """
    good = np.isfinite(values)
    used = {n: np.asarray(v)[good] for n, v in rows.items() if np.ptp(v[good] if good.any() else v)}
    names = tuple(used)
    low, high = (
        np.array([edge(used[name]) for name in names], np.float64) for edge in (np.min, np.max)
    )
    unfitted = ResponseSurface(names, low, high, np.empty(0), np.nan)
    terms = _terms(unfitted._unit(used)) if names else np.ones((int(good.sum()), 1))
    count = terms.shape[1]
    if good.sum() <= count:
        raise InputError(
            f"a quadratic of {len(names)} variables has {count} coefficients, and {good.sum()} "
            "designs have values",
            "ask for more designs",
        )
    # Where a variable has two levels its square says nothing; the least coefficients are taken.
    inverse = np.linalg.pinv(terms)
    coefficients = inverse @ values[good]
    # A residual over 1 - leverage is that of the fit without the point.
    leverage = np.minimum(np.einsum("ij,ji->i", terms, inverse), 1.0 - 1e-9)
    error = (values[good] - terms @ coefficients) / (1.0 - leverage)
    return ResponseSurface(names, low, high, coefficients, float(np.sqrt(np.mean(error**2))))


def _terms(unit: Floats) -> Floats:
    """1, each variable, and each product of two of them, (n, t)."""
    count, k = unit.shape
    products = [unit[:, i] * unit[:, j] for i in range(k) for j in range(i, k)]
    return np.column_stack([np.ones(count), unit, *products])
