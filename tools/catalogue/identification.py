"""Section constants of one propeller, by least squares over its rows with a prior.

The coordinates are those of ``propmap.catalogue.expected.PopulationPrior``: the P constants, some
as logarithms.
"""

from __future__ import annotations

import warnings
from typing import Any, NamedTuple

import numpy as np

from propmap.catalogue.expected import (
    POPULATION,
    PopulationPrior,
    constants_of,
    slopes_of,
)
from propmap.catalogue.identified import LIFT_LAW, PARAMETERS
from propmap.fit.least_squares import INDEPENDENT, INDEPENDENT_AT_REST
from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil
from propmap.model.model import Model
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.typing import Floats
from tools.catalogue.database import MeasuredPropeller

FIRST_ERRORS = (0.003, 0.002)
"""Errors of C_T and C_P [-] that the first fit assumes.  The second fit assumes the residuals of
the first."""

LEAST_ERRORS, MOST_ERRORS = (0.0015, 0.001), (0.004, 0.003)
"""Limits of the errors that the second fit assumes.  If the model fits badly, the upper limit keeps
the prior from making the fit worse.  The covariance uses the residuals without the upper limit."""

LOWER = np.array(
    [
        np.log(2.0),
        np.log(0.8),
        np.log(0.2),
        np.log(0.12),
        -0.2,
        np.log(0.002),
        -0.09,
        -0.3,
        -1.2,
        -0.2,
    ]
)
UPPER = np.array(
    [np.log(12.0), np.log(4.0), np.log(9.0), np.log(0.8), 0.1, np.log(0.2), 0.09, 0.6, 0.4, 0.25]
)
"""Bounds of the coordinates."""

EVALUATIONS = (16, 10)
"""Maximum numbers of model evaluations of the first and of the second fit."""


def airfoil_of(constants: Floats) -> Airfoil:
    """Return the section law with ``constants`` (P,) in the order of ``PARAMETERS``."""
    values: Any = dict(zip(PARAMETERS, map(float, constants), strict=True))
    return Airfoil(**values, lift_law=LIFT_LAW)


class AxialTest(NamedTuple):
    """A propeller and its n measured rows, at rest and in axial flow."""

    propeller: Propeller
    tested: MeasuredPropeller

    @property
    def measured(self) -> Floats:
        """Measured C_T and C_P [-], (2, n)."""
        return np.stack([self.tested.thrust, self.tested.power])

    def modeled(self, constants: Floats) -> tuple[Floats, Floats]:
        """Return computed C_T and C_P [-], (2, n), and their derivatives (2, P, n).

        The derivatives are with respect to ``constants`` (P,).  Rows without a solution for the
        inflow are NaN.
        """
        model = Model(self.propeller, airfoil_of(constants))
        turns, diameter = self.tested.rpm / 60.0, 2.0 * self.propeller.radius
        flow = (2.0 * np.pi * turns, self.tested.advance * turns * diameter)
        found = Rotor(model).gradients(PARAMETERS, *flow, 0.0)
        force = model.air.density * turns**2 * diameter**4
        size = np.stack([force, force * diameter / (2.0 * np.pi)])  # P = 2 pi n tau
        rows = [list(LOADS).index(name) for name in ("thrust", "torque")]
        return found.loads[rows] / size, found.slopes[rows] / size[:, None]


class Identification(NamedTuple):
    """The constants of one propeller, (P,) in the order of ``PARAMETERS``."""

    constants: Floats
    covariance: Floats  # (P, P), from the curvature of the sum of squares
    held: Floats  # (P,): posterior over prior deviation of a coordinate; 1 if data do not affect it
    thrust_rms: float  # of the errors of C_T over all rows [-]
    power_rms: float  # of the errors of C_P over all rows [-]
    static_thrust_rms: float  # NaN without static rows
    static_power_rms: float
    residual: Floats  # (2, n): model minus measurement [-]; NaN without a solution for the inflow


def whitening(prior: PopulationPrior) -> Floats:
    """Return the matrix W (P, P) that standardizes a ``prior``.

    The components of W (place - mean) are independent with variance 1.
    """
    return np.linalg.inv(np.linalg.cholesky(prior.correlation)) / prior.deviation


class _Penalised:
    """Sum of squares of a test and its prior.  The model is evaluated once per place."""

    def __init__(self, test: AxialTest, prior: PopulationPrior) -> None:
        self.test, self.prior, self.whitening = test, prior, whitening(prior)
        still = test.tested.advance == 0.0
        counts = np.where(still, INDEPENDENT_AT_REST, INDEPENDENT)
        rows = np.where(still, still.sum(), (~still).sum())
        self.weight = np.sqrt(np.minimum(counts / rows, 1.0))
        self._found: dict[bytes, tuple[Floats, Floats]] = {}

    def weigh(self, errors: Floats) -> None:
        """Set the assumed ``errors`` (2,) of C_T and C_P [-]."""
        self.scale = self.weight / errors[:, None]

    def errors(self, place: Floats) -> tuple[Floats, Floats]:
        """Return errors (2, n) [-] at coordinates ``place`` (P,), and derivatives (2, n, P).

        Rows without a solution for the inflow have the error NaN and derivatives 0.
        """
        key = place.tobytes()
        if key not in self._found:
            value, slope = self.test.modeled(constants_of(place))
            lost = ~np.isfinite(value) | ~np.isfinite(slope).all(axis=1)
            error = np.where(lost, np.nan, value - self.test.measured)
            slope = np.where(lost[:, None], 0.0, slope)
            self._found[key] = error, np.einsum("lcn,cp->lnp", slope, slopes_of(place))
        return self._found[key]

    def residuals(self, place: Floats) -> Floats:
        """Return the weighted residuals (2 n + P,) of rows and prior at coordinates (P,)."""
        rows = self.scale * np.nan_to_num(self.errors(place)[0])
        return np.concatenate([np.ravel(rows), self.whitening @ (place - self.prior.mean)])

    def slopes(self, place: Floats) -> Floats:
        """Return the derivatives (2 n + P, P) of ``residuals``."""
        rows = self.scale[..., None] * self.errors(place)[1]
        return np.concatenate([np.reshape(rows, (-1, place.size)), self.whitening])

    def covariance(self, place: Floats) -> Floats:
        """Return the covariance (P, P) of the coordinates from the curvature at ``place`` (P,)."""
        slopes = self.slopes(place)
        return np.asarray(np.linalg.inv(slopes.T @ slopes), float)

    def minimum(self, start: Floats, evaluations: int) -> Floats:
        """Return the coordinates (P,) of the minimum found from ``start`` (P,)."""
        from scipy.optimize import least_squares

        with warnings.catch_warnings():
            # At a bound, SciPy divides by a distance of zero, without harm to the result.
            warnings.simplefilter("ignore", RuntimeWarning)
            found = least_squares(
                self.residuals,
                np.clip(start, LOWER + 1e-6, UPPER - 1e-6),
                self.slopes,
                bounds=(LOWER, UPPER),
                x_scale=self.prior.deviation,
                ftol=1e-5,
                xtol=1e-5,
                max_nfev=evaluations,
            )
        return np.asarray(found.x)


def identify(test: AxialTest, prior: PopulationPrior = POPULATION) -> Identification:
    """Identify the constants of a propeller by two least-squares fits to C_T, C_P and prior."""
    penalised = _Penalised(test, prior)
    penalised.weigh(np.array(FIRST_ERRORS))
    place = penalised.minimum(prior.mean, EVALUATIONS[0])
    left = np.sqrt(np.nanmean(penalised.errors(place)[0] ** 2, axis=1))
    penalised.weigh(np.clip(left, LEAST_ERRORS, MOST_ERRORS))
    place = penalised.minimum(place, EVALUATIONS[1])
    error = penalised.errors(place)[0]
    left = np.sqrt(np.nanmean(error**2, axis=1))
    penalised.weigh(np.maximum(left, LEAST_ERRORS))
    covariance = penalised.covariance(place)
    to_constants = slopes_of(place)
    still = test.tested.advance == 0.0

    def rms(errors: Floats) -> float:
        return float(np.sqrt(np.nanmean(errors**2))) if errors.size else np.nan

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


def updated(at_rest: AxialTest, prior: PopulationPrior, errors: Floats) -> PopulationPrior:
    """Return the prior updated by static rows, to predict the loads in axial flow.

    ``errors`` (2,) are standard deviations of C_T and C_P [-] about the model, such as
    ``Population.errors``.  The residuals of static rows are no measure of the errors in axial flow.
    """
    penalised = _Penalised(at_rest, prior)
    penalised.weigh(errors)
    place = penalised.minimum(prior.mean, EVALUATIONS[0])
    return PopulationPrior.of(place, penalised.covariance(place))
