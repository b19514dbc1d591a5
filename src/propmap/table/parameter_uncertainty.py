"""How uncertain a table's loads are because the section law's parameters are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from propmap.table.certificate import by_load
from propmap.table.comparison import quasi_random, static_loads
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.model.section_covariance import SectionCovariance
    from propmap.rotor import Rotor
    from propmap.table.model import Model
    from propmap.table.query import LoadTable

POINTS = 1024
"""Of the envelope; a power of two."""

SEED = 20_170


def parameter_uncertainty(
    table: LoadTable, model: Model, covariance: SectionCovariance
) -> dict[str, Any]:
    """What the covariance means for the loads, over the envelope; plain data.

    Standard deviations, to first order, as shares of the static loads as in the certificate:
    "median" and "percentile_95" over so many "points", by load.  "not_counted": parameters of
    which the data said nothing.  Beside these the table's own errors matter or they do not.
    """
    model.stage = "uncertainty of the parameters"
    known = covariance.determined
    omega, speed, beta = quasi_random(table, POINTS, SEED)
    shares = load_deviations(model.rotor, known, omega, speed, beta) / static_loads(model, omega)
    shares = shares[np.isfinite(shares).all(axis=1)]
    median, high = np.percentile(shares, [50.0, 95.0], axis=0)
    return {
        "parameters": list(known.names),
        "not_counted": list(covariance.unknown),
        "points": len(shares),
        "median": by_load(median),
        "percentile_95": by_load(high),
    }


def load_deviations(
    rotor: Rotor, covariance: SectionCovariance, omega: Floats, speed: Floats, beta: Floats
) -> Floats:
    """Standard deviations (n, L) [N], [N], [N m], [N m] of the loads at n operating points.

    sqrt(g' S g), with g the derivatives by the parameters and S their covariance.
    """
    found = rotor.gradients(
        covariance.names, omega, speed * np.cos(beta), np.abs(speed * np.sin(beta))
    )
    variance = np.einsum("lpn,pq,lqn->nl", found.slopes, covariance.matrix, found.slopes)
    return np.asarray(np.sqrt(np.maximum(variance, 0.0)))
