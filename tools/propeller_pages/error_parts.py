"""What the errors of a fit are made of: rest, whole runs, the course over J, scatter."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from propmap.typing import Floats
from tools.catalogue.database import MeasuredPropeller


class ErrorParts(NamedTuple):
    """Shares of the sum of squared errors [-]; together 1.

    Attributes
    ----------
    rest : float
        Of the rows at rest.
    runs : float
        Of the runs' means in axial flow: what is off by as much over a whole run.
    course : float
        Of straight lines over J about those means, one for each run.
    scatter : float
        Of what is left.
    """

    rest: float
    runs: float
    course: float
    scatter: float


def error_parts(tested: MeasuredPropeller, error: Floats) -> ErrorParts:
    """The parts of the errors (n,) of one coefficient; those that are NaN do not count.

    Parameters
    ----------
    tested : MeasuredPropeller
        The rows.
    error : ndarray, shape (n,)
        Model less measurement [-].
    """
    seen = np.isfinite(error)
    still = tested.advance == 0.0
    runs = course = 0.0
    for run in np.unique(tested.run[seen & ~still]):
        mine = seen & ~still & (tested.run == run)
        mean, along = error[mine].mean(), tested.advance[mine] - tested.advance[mine].mean()
        runs += mine.sum() * mean**2
        if along.any():
            course += (along @ error[mine]) ** 2 / (along @ along)
    rest = np.sum(error[seen & still] ** 2)
    rest, runs, course = (part / np.sum(error[seen] ** 2) for part in (rest, runs, course))
    return ErrorParts(float(rest), float(runs), float(course), float(1.0 - rest - runs - course))
