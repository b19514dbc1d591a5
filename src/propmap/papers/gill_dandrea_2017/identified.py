"""Section parameters of the APC 8x6E, identified from the public tunnel data."""

from __future__ import annotations

from dataclasses import dataclass

from propmap.catalogue.lookup import measurement
from propmap.fit.fit import Fitted, Settings, fit
from propmap.fit.parameters import Choice
from propmap.fit.tunnel import TunnelData, first_guess, section_with, tunnel_rows
from propmap.model.airfoil import PAPER_FOUR, Airfoil
from propmap.model.model import Model
from propmap.papers.gill_dandrea_2017.blades import TUNNEL_PROPELLER, blade

AXIAL, OBLIQUE, OTHER_FORM = "uiuc-8x6e", "gill-dandrea-2019-8x6e", "gill-dandrea-2019-8x6e-fit"
"""UIUC's rows; the polynomials of the 2019 campaign, one fitted to each load's measurements; the
blade-element model that the same paper fitted to all of them."""

OBLIQUE_LABEL = "with camber, 2019"
FITTED_LOADS = ("thrust", "torque")
"""Rotor drag is left out of every fit: it is the load in dispute."""

FIVE = (*PAPER_FOUR, "zero_lift_angle")
STARTS = 4


@dataclass(frozen=True)
class Identified:
    """One identification: what it was fitted to, how it went, and the law that came out."""

    label: str
    data: str
    fitted: Fitted
    law: Airfoil


@dataclass(frozen=True)
class TunnelFits:
    """The paper's four parameters fitted to the UIUC rows; and, with a zero-lift angle as a fifth,
    the fits to the UIUC rows and to the polynomials of 2019."""

    axial_four: Identified
    axial: Identified
    oblique: Identified


def tunnel_fits() -> TunnelFits:
    """All three, to thrust and torque, from the paper's first guess and three random ones."""
    return TunnelFits(
        axial_four=_identify("four parameters, UIUC", AXIAL, PAPER_FOUR),
        axial=_identify("with camber, UIUC", AXIAL, FIVE),
        oblique=_identify(OBLIQUE_LABEL, OBLIQUE, FIVE),
    )


def _identify(label: str, data: str, free: tuple[str, ...]) -> Identified:
    m, choice = measurement(data), Choice(free)
    given = TunnelData(m.name, m.omega, m.speed, m.beta, m.loads)
    model = Model(blade(TUNNEL_PROPELLER), first_guess())
    rows = tunnel_rows(model, given, choice, loads=FITTED_LOADS)
    fitted = fit(rows, choice, Settings(starts=STARTS, folds=0))
    law = section_with(model.airfoil, fitted.values)
    return Identified(label, data, fitted, law.with_parameters(name=label, source=data))
