"""What the rotor drag of 2019 has beyond the theory's: a factor, or a plate in the slipstream."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.fit.least_squares import rms
from propmap.papers.gill_dandrea_2017.blades import blade
from propmap.papers.gill_dandrea_2017.identified import OBLIQUE, OBLIQUE_LABEL, OTHER_FORM
from propmap.papers.gill_dandrea_2017.tunnel import OTHER_LABEL, RECOMMENDED_LABEL, Compared
from propmap.typing import Floats

SLIPSTREAM = (1.0, 2.0)
"""Inflow of the slipstream at the plate over that of the disk [-]: at the disk, far behind it."""

STEPS = 100
"""Of the search for the inflow, which halves its error or better each time."""


@dataclass(frozen=True)
class Excess:
    """Drag as ``factor`` [-] times the theory's and that of a plate of ``area`` [m^2]; ``error`` is
    the root mean square of what is left over that of the drag fitted [-]."""

    factor: float
    area: float
    error: float


@dataclass(frozen=True)
class PlateFits:
    """Three explanations of one drag.

    Attributes
    ----------
    model, data : str
        Labels of the theory and of the drag fitted.
    slipstream : float
        See ``SLIPSTREAM``.
    factor, plate, both : Excess
        Least squares with a factor alone, with the theory's drag and a plate, and with both, none
        of them negative.
    """

    model: str
    data: str
    slipstream: float
    factor: Excess
    plate: Excess
    both: Excess


def plate_fits(one: Compared) -> list[PlateFits]:
    """Both forms of the oblique campaign's drag, by the paper's and by the recommended inflow."""
    data = one.data
    drags = {OBLIQUE: data.loads["drag"], OTHER_FORM: one.predicted[OTHER_LABEL]["drag"]}
    moving = data.speed * np.sin(data.beta) > 0.0
    found = []
    for model in (OBLIQUE_LABEL, RECOMMENDED_LABEL):
        loads = one.predicted[model]
        for slipstream in SLIPSTREAM:
            pressure = dynamic_pressure(one, loads["thrust"], slipstream)[moving]
            found += [
                PlateFits(
                    model, name, slipstream, *fits(loads["drag"][moving], pressure, d[moving])
                )
                for name, d in drags.items()
            ]
    return found


def dynamic_pressure(one: Compared, thrust: Floats, slipstream: float) -> Floats:
    """Force along the disk on a plate, by its drag area [N/m^2].

    1/2 rho V_in sqrt(V_in^2 + (V_ax + k v_i)^2), with the inflow v_i by momentum theory.

    Parameters
    ----------
    one : Compared
        With n operating points.
    thrust : ndarray, shape (n,)
        [N].
    slipstream : float
        k [-].
    """
    data, area = one.data, np.pi * blade(one.data.propeller).radius ** 2
    inplane, axial = data.speed * np.sin(data.beta), data.speed * np.cos(data.beta)
    inflow = momentum_inflow(thrust / (2.0 * data.air_density * area), inplane, axial)
    along = np.hypot(inplane, axial + slipstream * inflow)
    return np.asarray(0.5 * data.air_density * inplane * along)


def momentum_inflow(product: Floats, inplane: Floats, axial: Floats) -> Floats:
    """v_i (n,) [m/s] with v_i sqrt(V_in^2 + (V_ax + v_i)^2) = T/(2 rho A), Glauert's.

    Parameters
    ----------
    product : ndarray, shape (n,)
        T/(2 rho A) [m^2/s^2].
    inplane, axial : ndarray, shape (n,)
        V_in and V_ax >= 0 [m/s].
    """
    inflow = np.sqrt(np.maximum(product, 0.0))
    for _ in range(STEPS):
        through = np.hypot(inplane, axial + inflow)
        step = np.divide(product, through, out=np.zeros_like(product), where=through > 0.0)
        inflow = 0.5 * (inflow + step)
    return inflow


def fits(theory: Floats, pressure: Floats, drag: Floats) -> tuple[Excess, Excess, Excess]:
    """A factor alone, a plate alone, and both, to a drag; all arrays (n,).

    Parameters
    ----------
    theory, drag : ndarray, shape (n,)
        [N].
    pressure : ndarray, shape (n,)
        Force on a plate of 1 m^2 [N/m^2].
    """
    from scipy.optimize import nnls

    def excess(factor: float, area: float) -> Excess:
        left = drag - factor * theory - area * pressure
        return Excess(factor, area, rms(left) / rms(drag))

    alone = float(theory @ drag / (theory @ theory))
    area = max(0.0, float(pressure @ (drag - theory) / (pressure @ pressure)))
    # Columns of like size, since the areas are small numbers.
    sizes = np.array([rms(theory), rms(pressure)])
    both, _ = nnls(np.stack([theory, pressure], axis=1) / sizes, drag)
    return excess(alone, 0.0), excess(1.0, area), excess(*(both / sizes).tolist())
