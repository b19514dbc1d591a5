"""Derivatives of the loads by differences, for few points in a process that compiles nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from propmap.arrays.types import Floats
from propmap.engine.accuracy import Accuracy
from propmap.engine.evaluation import Prepared, evaluate_flow, flow_at
from propmap.engine.gradients import LoadGradients
from propmap.loads import LOADS
from propmap.solve.moved_case import moved_rotor, with_terms

STEP = 0.05
"""Step to either side over the scale of a parameter.  At isolated points the loads jump, by some
1e-4 of their size, where the panels' edges jump: with a step much smaller than what the parameter
may differ by, such a jump would be most of the difference.  That of the curvature is far below a
per cent of the derivative."""


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
        ahead, behind = (loads(name, sign * STEP * scale) for sign in (1.0, -1.0))
        slopes[:, k] = (ahead - behind) / (2.0 * STEP * scale)
    return LoadGradients(here, slopes)
