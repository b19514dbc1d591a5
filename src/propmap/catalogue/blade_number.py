"""What static thrust of propellers with two, three and four blades says of those not measured.

Nearly all measured blades are of propellers with two. On a stand, five-inch propellers of
multirotors' makers with three and four have less thrust than these blades would: theirs are
narrower, and many blades take more from each other than the theory has it. Both are put into the
chord. There are four propellers, each on 12 or 13 motors; the density of the air was not recorded
and is taken to be 1.20 kg/m^3, and the rotational speed is that of the motors' current. Beside them
count propellers of the UIUC Propeller Database whose one blade was tested on hubs for two, three
and four. ``python -m tools.chord_by_blades`` finds the numbers below.
"""

from __future__ import annotations

import numpy as np

from propmap.typing import Floats

CITATION = "P. Cao, J. Strawson, github StrawsonDesign/motor_propeller_testing @7031418 (MIT)"

CHORD_OF_MORE = 0.711
"""Chord of blades on a propeller with more than two, over that of the mean blade; the logarithm is
known to 0.03.  Three and four are not told apart."""

LEFT_OUT_ERROR = 0.10
"""Errors of static thrust of the stand's propellers, each left out, are less."""

DEVIATION = 0.099
"""Standard deviation of the logarithm of static thrust about this: the root mean square of these
errors, widened by Student's t, as there are four."""

AT_REST = np.array([0.39, 0.55, -0.02, 0.41, -1.39, 0.0, 1.34, 0.18])
"""Derivatives of the logarithm of static thrust by the coordinates of ``PopulationPrior``, mean
over the stand's propellers."""


def chord_factor(blades: int) -> float:
    """Give the chord of blades of which a propeller has so many, over that of the mean blade."""
    return 1.0 if blades <= 2 else CHORD_OF_MORE


def left_at_rest(covariance: Floats, deviation: float = DEVIATION) -> float:
    """Say what share of the variance of static thrust, by a ``covariance`` (P, P) of the
    coordinates, is left where its logarithm is known to the ``deviation``."""
    return float(deviation**2 / (AT_REST @ covariance @ AT_REST))


def known_at_rest(covariance: Floats, left: float) -> Floats:
    """Narrow a ``covariance`` (P, P) of the coordinates until the share ``left`` of the variance of
    static thrust is left.

    What does not change static thrust, drag above all, stays as little known as it is.
    """
    along = covariance @ AT_REST
    return covariance - (1.0 - left) * np.outer(along, along) / (AT_REST @ along)
