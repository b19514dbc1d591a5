"""Parameters drawn from what a fit knows of them, within their bounds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from propmap.identify.fit_record import FitRecord
from propmap.identify.parameters import SECTION

Floats = NDArray[np.float64]

DRAWS = 64
"""Sets of parameters that make a band."""

TRIED, ROUNDS = 20_000, 25
"""Draws at a time, and how often, until enough of them are within the bounds."""

SEED = 2017


def draw_parameters(fit: FitRecord) -> list[dict[str, float]]:
    """Values of the section's free parameters by name, ``DRAWS`` times; none where it cannot be.

    They are drawn from the normal distribution with the fit's covariance about the fitted
    values; draws with a parameter outside its bounds are thrown away.  Parameters of infinite
    variance keep their value.  Empty where no parameter has a finite variance, or where almost
    nothing of the distribution is within the bounds.
    """
    known = [
        k
        for k, p in enumerate(fit.parameters)
        if p.name in SECTION and np.isfinite(fit.covariance[k, k])
    ]
    covariance = fit.covariance[np.ix_(known, known)]
    if not known or not np.isfinite(covariance).all():
        return []
    chosen = [fit.parameters[k] for k in known]
    middle, lower, upper = (
        np.array([getattr(p, name) for p in chosen]) for name in ("value", "lower", "upper")
    )
    size = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    values, vectors = np.linalg.eigh(covariance / np.outer(size, size))
    root = size[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    rng = np.random.default_rng(SEED)
    kept = np.empty((0, len(known)))
    for _ in range(ROUNDS):
        found = middle + rng.standard_normal((TRIED, len(known))) @ root.T
        inside = ((found >= lower) & (found <= upper)).all(axis=1)
        kept = np.concatenate([kept, found[inside]])
        if len(kept) >= DRAWS:
            names = [p.name for p in chosen]
            return [dict(zip(names, row, strict=True)) for row in kept[:DRAWS].tolist()]
    return []


def held(fit: FitRecord) -> list[str]:
    """Names of the section's free parameters that keep their value in every draw."""
    return [
        p.name
        for k, p in enumerate(fit.parameters)
        if p.name in SECTION and not np.isfinite(fit.covariance[k, k])
    ]
