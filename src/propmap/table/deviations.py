"""Standard deviations of a table's loads, from the model at some of the knots."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from propmap.loads import LOADS
from propmap.table.axis import locate
from propmap.table.content import TableContent
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.rotor import Rotor

MOST_KNOTS = 20
"""Along each axis: standard deviations vary more slowly than loads, and matter less exactly."""


def deviation_coefficients(rotor: Rotor, content: TableContent) -> Floats:
    """Standard deviations of the loads at the knots, as ``TableContent.deviations``.

    Parameters
    ----------
    rotor : Rotor
        Whose model says how well it is known.
    content : TableContent
        The table of its loads.
    """
    rows, columns = _some(content.advance.size), _some(content.beta.size)
    advance, beta = content.advance[rows], content.beta[columns]
    omega, j, b = np.meshgrid(content.omega, advance, beta, indexing="ij")
    found = rotor.loads(omega.ravel(), (j * omega * content.radius).ravel(), b.ravel()).std
    values = np.stack([getattr(found, name) for name in LOADS])
    coarse = (values / content.scale[:, None] / omega.ravel() ** 2).reshape(-1, *omega.shape)
    between = bilinear(advance, beta, coarse, content.advance[:, None], content.beta)
    return np.asarray(between.transpose(1, 0, 2, 3))


def bilinear(x: Floats, y: Floats, values: Floats, at_x: Floats, at_y: Floats) -> Floats:
    """Values (..., n, m) at knots x (n,), y (m,), linear between them; (..., *shape).

    ``at_x`` and ``at_y`` broadcast to ``shape`` and lie within the knots.
    """
    i, t = locate(x, at_x)
    j, u = locate(y, at_y)
    low = values[..., i, j] * (1.0 - t) + values[..., i + 1, j] * t
    high = values[..., i, j + 1] * (1.0 - t) + values[..., i + 1, j + 1] * t
    return np.asarray(low * (1.0 - u) + high * u)


def _some(count: int) -> NDArray[np.intp]:
    return np.unique(np.linspace(0, count - 1, min(count, MOST_KNOTS)).round().astype(np.intp))
