"""Section constants of one propeller: penalised least squares, of its rows and of the prior."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from propmap.catalogue.expected import POPULATION, PopulationPrior, constants_of, slopes_of
from propmap.fit.least_squares import INDEPENDENT
from propmap.fit.population.coefficients import AxialTest
from propmap.typing import Floats

AT_REST = 2.0
"""The same of rows at rest alone: level and slope of one curve over the rotational speed."""

FIRST_ERRORS = (0.003, 0.002)
"""Errors of C_T and C_P [-] that a first fit assumes; the second takes those that it left."""

LEAST_ERRORS, MOST_ERRORS = (0.0015, 0.001), (0.004, 0.003)
"""Least and largest errors that the second fit assumes: where the model fails, its prior should not
make it fail the more.  The covariance is with all errors that were left."""

LOWER = np.array([np.log(2.0), np.log(0.2), np.log(0.12), -0.2, np.log(0.002), -0.09, -0.2])
UPPER = np.array([np.log(12.0), np.log(9.0), np.log(0.8), 0.1, np.log(0.2), 0.09, 0.25])
"""Bounds of the coordinates."""

EVALUATIONS = (16, 10)
"""Evaluations of the model by the first fit and by the second, at most."""


@dataclass(frozen=True, eq=False)
class Identification:
    """The constants of one propeller.

    Attributes
    ----------
    constants : ndarray, shape (7,)
        In the order of ``PARAMETERS``.
    covariance : ndarray, shape (7, 7)
        Theirs, by the curvature of the penalised sum of squares.
    held : ndarray, shape (7,)
        Posterior over prior standard deviation of each coordinate [-]: near 1 the data say nothing.
    thrust_rms, power_rms : float
        Root mean squares of C_T's and C_P's errors over all rows [-].
    static_thrust_rms, static_power_rms : float
        The same of rows at rest; NaN where there are none.
    residual : ndarray, shape (2, n)
        Model minus measurement [-]; NaN where no inflow was found.
    """

    constants: Floats
    covariance: Floats
    held: Floats
    thrust_rms: float
    power_rms: float
    static_thrust_rms: float
    static_power_rms: float
    residual: Floats


class _Modelled:
    """What the model says of a test at coordinates, evaluated once for each.

    Parameters
    ----------
    test : AxialTest
        What was measured.
    """

    def __init__(self, test: AxialTest) -> None:
        self.test = test
        self._found: dict[bytes, tuple[Floats, Floats]] = {}

    def at(self, place: Floats) -> tuple[Floats, Floats]:
        """Errors [-] and their derivatives; NaN and 0 where no inflow was found.

        Parameters
        ----------
        place : ndarray, shape (7,)
            Coordinates.

        Returns
        -------
        tuple of ndarray
            (2, n) and (2, n, 7).
        """
        key = place.tobytes()
        if key not in self._found:
            value, slope = self.test.modelled(constants_of(place))
            lost = ~np.isfinite(value) | ~np.isfinite(slope).all(axis=1)
            error = np.where(lost, np.nan, value - self.test.measured)
            by_place = np.einsum(
                "lcn,cp->lnp", np.where(lost[:, None], 0.0, slope), slopes_of(place)
            )
            self._found[key] = error, by_place
        return self._found[key]


class _Penalised:
    """Residuals and their derivatives at coordinates."""

    def __init__(
        self,
        modelled: _Modelled,
        prior: PopulationPrior,
        errors: Floats,
        independent: float = INDEPENDENT,
    ) -> None:
        self.modelled, self.prior = modelled, prior
        self.whitening = prior.whitening
        rows = modelled.test.measured.shape[1]
        weight = np.sqrt(min(independent / rows, 1.0))
        self.scale = (weight / errors)[:, None]

    def at(self, place: Floats) -> tuple[Floats, Floats, Floats]:
        """Errors (2, n) [-], weighed residuals (2 n + 7,) and their derivatives (2 n + 7, 7)."""
        error, by_place = self.modelled.at(place)
        apart = self.whitening @ (place - self.prior.mean)
        rows = [np.ravel(self.scale * np.nan_to_num(error)), apart]
        columns = [
            np.reshape(self.scale[..., None] * by_place, (-1, place.size)),
            self.whitening,
        ]
        return error, np.concatenate(rows), np.concatenate(columns)

    def minimum(self, start: Floats, evaluations: int) -> Floats:
        """Coordinates of the least sum of squares, searched from ``start``."""
        from scipy.optimize import least_squares

        with warnings.catch_warnings():
            # At a bound SciPy divides by a zero distance and goes on.
            warnings.simplefilter("ignore", RuntimeWarning)
            found = least_squares(
                lambda place: self.at(place)[1],
                np.clip(start, LOWER + 1e-6, UPPER - 1e-6),
                lambda place: self.at(place)[2],
                bounds=(LOWER, UPPER),
                x_scale=self.prior.deviation,
                ftol=1e-5,
                xtol=1e-5,
                max_nfev=evaluations,
            )
        return np.asarray(found.x)


def identify(test: AxialTest, prior: PopulationPrior = POPULATION) -> Identification:
    """The constants of a propeller by a penalised least-squares fit to C_T and C_P.

    Parameters
    ----------
    test : AxialTest
        What was measured.
    prior : PopulationPrior
        What is known beforehand.
    """
    modelled = _Modelled(test)
    first = _Penalised(modelled, prior, np.array(FIRST_ERRORS))
    place = first.minimum(prior.mean, EVALUATIONS[0])
    left = np.sqrt(np.nanmean(first.at(place)[0] ** 2, axis=1))
    second = _Penalised(modelled, prior, np.clip(left, LEAST_ERRORS, MOST_ERRORS))
    place = second.minimum(place, EVALUATIONS[1])
    error = second.at(place)[0]
    left = np.maximum(np.sqrt(np.nanmean(error**2, axis=1)), LEAST_ERRORS)
    slopes = _Penalised(modelled, prior, left).at(place)[2]
    covariance = np.linalg.inv(slopes.T @ slopes)
    to_constants = slopes_of(place)
    still = test.tested.advance == 0.0

    def rms(of: Floats) -> float:
        return float(np.sqrt(np.nanmean(of**2))) if of.size else np.nan

    return Identification(
        constants=constants_of(place),
        covariance=to_constants @ covariance @ to_constants.T,
        held=np.sqrt(np.diag(covariance)) / prior.deviation,
        thrust_rms=rms(error[0]),
        power_rms=rms(error[1]),
        static_thrust_rms=rms(error[0, still]),
        static_power_rms=rms(error[1, still]),
        residual=error,
    )


def updated(test: AxialTest, prior: PopulationPrior, errors: Floats) -> PopulationPrior:
    """The ``prior`` after a static test, for loads in flight.

    Parameters
    ----------
    test : AxialTest
        Rows at rest; they count as ``AT_REST`` independent ones of each load.
    prior : PopulationPrior
        Before it.
    errors : ndarray, shape (2,)
        Standard deviations of C_T and C_P [-] about the model, such as ``Population.errors``: those
        that rows at rest leave say nothing of flight.
    """
    penalised = _Penalised(_Modelled(test), prior, errors, AT_REST)
    place = penalised.minimum(prior.mean, EVALUATIONS[0])
    slopes = penalised.at(place)[2]
    return PopulationPrior.of(place, np.asarray(np.linalg.inv(slopes.T @ slopes), float))
