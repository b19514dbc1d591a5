"""Parameters drawn from what a fit knows of them, within their bounds."""

from __future__ import annotations

import numpy as np

from propmap.fit.fit_record import FitRecord
from propmap.fit.parameters import ROTOR
from propmap.typing import Floats

DRAWS = 200
"""Sets of parameters that make a band."""

TRIED, ROUNDS = 20_000, 50
"""Draws at a time, and how often, until enough of them are within the bounds."""

SEED = 2017


def drawn_changes(fit: FitRecord) -> tuple[tuple[str, ...], Floats]:
    """Parameters of section and mount drawn from the normal distribution with the fit's covariance.

    All parameters are drawn together; draws with any of them outside its bounds are thrown away.
    Parameters of infinite variance keep their value.

    Returns
    -------
    tuple of str
        Names of P of these parameters.
    ndarray, shape (``DRAWS``, P)
        By how much the draws differ from the fit; (0, P) where almost no draw is within the bounds.
    """
    known = [k for k in range(len(fit.parameters)) if np.isfinite(fit.covariance[k, k])]
    chosen = [fit.parameters[k] for k in known]
    section = [k for k, p in enumerate(chosen) if p.name in ROTOR]
    names = tuple(chosen[k].name for k in section)
    covariance = fit.covariance[np.ix_(known, known)]
    if not section or not np.isfinite(covariance).all():
        return names, np.empty((0, len(section)))
    middle, lower, upper = np.array([(p.value, p.lower, p.upper) for p in chosen]).T
    # A value at its bound is within it, whatever rounding made of it.
    slack = 1e-9 * (upper - lower)
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(size, size))
    root = size[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    rng = np.random.default_rng(SEED)
    kept: list[Floats] = []
    for _ in range(ROUNDS):
        change = rng.standard_normal((TRIED, len(known))) @ root.T
        found = middle + change
        kept.append(change[((found >= lower - slack) & (found <= upper + slack)).all(axis=1)])
        if sum(map(len, kept)) >= DRAWS:
            return names, np.concatenate(kept)[:DRAWS, section]
    return names, np.empty((0, len(section)))


def held(fit: FitRecord) -> list[str]:
    """Names of these free parameters that keep their value in every draw."""
    return [
        p.name
        for k, p in enumerate(fit.parameters)
        if p.name in ROTOR and not np.isfinite(fit.covariance[k, k])
    ]
