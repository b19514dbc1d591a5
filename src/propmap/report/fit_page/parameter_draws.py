"""Parameters drawn from what a fit knows of them, within their bounds."""

from __future__ import annotations

import numpy as np

from propmap.arrays.types import Floats
from propmap.fit.fit_record import FitRecord, FreeParameter
from propmap.fit.parameters import SECTION

DRAWS = 200
"""Sets of parameters that make a band."""

TRIED, ROUNDS = 20_000, 50
"""Draws at a time, and how often, until enough of them are within the bounds."""

SEED = 2017


def drawn_changes(fit: FitRecord) -> tuple[tuple[str, ...], Floats]:
    """Names of P section parameters, and by how much draws differ from the fit (``DRAWS``, P).

    All parameters are drawn together from the normal distribution with the fit's covariance
    about the fitted values; draws with any of them outside its bounds are thrown away.
    Parameters of infinite variance keep their value.  Without any draw, (0, P), where almost
    nothing of the distribution is within the bounds.
    """
    known = [k for k in range(len(fit.parameters)) if np.isfinite(fit.covariance[k, k])]
    chosen = [fit.parameters[k] for k in known]
    section = [k for k, p in enumerate(chosen) if p.name in SECTION]
    names = tuple(chosen[k].name for k in section)
    covariance = fit.covariance[np.ix_(known, known)]
    none = np.empty((0, len(section)))
    if not section or not np.isfinite(covariance).all():
        return names, none
    middle, lower, upper = (_column(chosen, name) for name in ("value", "lower", "upper"))
    # A value at its bound is within it, whatever rounding made of it.
    slack = 1e-9 * (upper - lower)
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(size, size))
    root = size[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    rng = np.random.default_rng(SEED)
    kept = [np.empty((0, len(known)))]
    for _ in range(ROUNDS):
        change = rng.standard_normal((TRIED, len(known))) @ root.T
        found = middle + change
        kept.append(change[((found >= lower - slack) & (found <= upper + slack)).all(axis=1)])
        if sum(map(len, kept)) >= DRAWS:
            return names, np.concatenate(kept)[:DRAWS, section]
    return names, none


def held(fit: FitRecord) -> list[str]:
    """Names of the section's free parameters that keep their value in every draw."""
    return [
        p.name
        for k, p in enumerate(fit.parameters)
        if p.name in SECTION and not np.isfinite(fit.covariance[k, k])
    ]


def _column(chosen: list[FreeParameter], name: str) -> Floats:
    return np.array([getattr(p, name) for p in chosen])
