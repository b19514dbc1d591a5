"""Derivatives of the loads by differences, for few points in a process that compiles nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from propmap.engine.accuracy import Accuracy
from propmap.engine.evaluation import Prepared, evaluate_flow, flow_at
from propmap.loads import LOADS
from propmap.results import LoadGradients
from propmap.solve.moved_case import moved_rotor, with_terms
from propmap.typing import Floats

STEP = 1e-3
"""Step to either side over the scale of a parameter; the error of the curvature is far below a per
cent of the derivative."""

APART = 0.2
"""Difference of the two sides' quotients, over the larger, from which the smaller is taken.  At
isolated points the loads jump, by some 1e-4 of their size, where a panel of the blade is split
elsewhere.  The quotient of the side on which they do is wrong by any factor, the other is not."""


def load_differences(
    rotor: Prepared,
    setting: Accuracy,
    names: tuple[str, ...],
    scales: Sequence[float],
    omega: Floats,
    v_axial: Floats,
    v_inplane: Floats,
) -> LoadGradients:
    """Loads at N operating points and their derivatives by P parameters, as ``load_gradients``.

    Each parameter takes two more evaluations with the same nodes.

    Parameters
    ----------
    rotor, setting : Prepared, Accuracy
        As for ``evaluation.evaluate``.
    names : tuple of str
        Of ``load_slopes.moving``, but the flow.
    scales : sequence of float
        By how much each may differ, in its unit, above 0.
    omega, v_axial, v_inplane : ndarray, shape (N,)
        [rad/s], [m/s]; v_inplane >= 0.
    """
    arrays = with_terms(rotor.arrays, names)

    def loads(name: str | None, step: float) -> Floats:
        changed: Any = np.float64(step)
        here = arrays if name is None else moved_rotor(arrays, {name: changed})
        one = replace(rotor, arrays=here, on_device=here, compiled=False)
        flow = flow_at(one, setting, omega, v_axial, v_inplane)
        return np.stack(evaluate_flow(one, setting, flow, alike=True).loads)

    here = loads(None, 0.0)
    slopes = np.zeros((len(LOADS), len(names), omega.size))
    for k, (name, scale) in enumerate(zip(names, scales, strict=True)):
        ahead, behind = (
            (loads(name, sign * STEP * scale) - here) / (sign * STEP * scale)
            for sign in (1.0, -1.0)
        )
        size, other = np.abs(ahead), np.abs(behind)
        smooth = np.abs(ahead - behind) <= APART * np.maximum(size, other)
        least = np.where(size < other, ahead, behind)
        slopes[:, k] = np.where(smooth, 0.5 * (ahead + behind), least)
    return LoadGradients(here, slopes)
