"""Errors of a fit to several flights, flight by flight."""

from __future__ import annotations

import numpy as np

from propmap.fit.fitted import Fitted
from propmap.fit.residuals import FlightErrors, rms_known
from propmap.vehicle.flight_log import FlightLog


def by_flight(fitted: Fitted, log: FlightLog) -> dict[str, dict[str, FlightErrors]]:
    """Errors by load and by flight.

    Parameters
    ----------
    fitted : Fitted
        A fit of rows made of the samples of ``log``.
    log : FlightLog
        The samples.

    Returns
    -------
    dict of str to dict of str to FlightErrors
        By the name of the load and that of the flight; of one flight alone, nothing.
    """
    if len(log.flights) < 2:
        return {}
    rows = fitted.rows
    flight = log.flight[rows.point]

    def of(load: int, number: int) -> FlightErrors:
        mine = rows.of_load(load) & (flight == number) & np.isfinite(fitted.residual)
        off = fitted.residual[mine]
        bias = float(off.mean()) if off.size else float("nan")
        return FlightErrors(off.size, rms_known(off), bias, rms_known(fitted.left_out[mine]))

    return {
        load: {name: of(k, number) for number, name in enumerate(log.flights)}
        for k, load in enumerate(rows.names)
    }
