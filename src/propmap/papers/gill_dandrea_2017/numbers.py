"""Everything that the page shows, computed once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from propmap.model.airfoil import Airfoil
from propmap.papers.gill_dandrea_2017.cost import Times, measured_times
from propmap.papers.gill_dandrea_2017.identified import AXIAL, OBLIQUE, TunnelFits, tunnel_fits
from propmap.papers.gill_dandrea_2017.level_circles import SetFlown, fly
from propmap.papers.gill_dandrea_2017.rotor_drag import (
    Consequence,
    Ratio,
    SmallIncidence,
    consequence,
    ratios,
    small_incidence,
)
from propmap.papers.gill_dandrea_2017.tunnel import (
    MULTIROTOR,
    Compared,
    LoadError,
    compared,
    errors,
)
from propmap.papers.gill_dandrea_2017.tunnel_curves import (
    AxialCurve,
    ObliqueCurves,
    ThrustCurve,
    axial_curves,
    oblique_curves,
    thrust_curves,
)

FLOWN = ("paper-soft", "paper-stiff")
"""The sets of Table I that the paper flew."""


@dataclass(frozen=True, eq=False)
class Numbers:
    """Results by part; see the modules that compute them."""

    flown: dict[str, SetFlown]
    fits: TunnelFits
    tunnel: dict[str, Compared]
    errors: list[LoadError]
    axial_curves: list[AxialCurve]
    oblique_curves: list[ObliqueCurves]
    thrust_curves: list[ThrustCurve]
    small_incidence: list[SmallIncidence]
    ratios: list[Ratio]
    consequences: list[Consequence]
    times: Times


def compute() -> Numbers:
    """All numbers; about two minutes on two cores, most of it compilation."""
    # Flight and tunnel need different programs: compiled side by side, they take half the time.
    with ThreadPoolExecutor(2) as pool:
        flights = pool.submit(lambda: {name: fly(name) for name in FLOWN})
        fits = tunnel_fits()
        found = compared(fits)
        oblique = fits.oblique.law
        lines = _lines(found, fits)
        small, by_angle = small_incidence(oblique), ratios(oblique)
        flown = flights.result()
    factor = by_angle[0].ratio
    return Numbers(
        flown=flown,
        fits=fits,
        tunnel=found,
        errors=errors(found),
        axial_curves=lines[0],
        oblique_curves=lines[1],
        thrust_curves=lines[2],
        small_incidence=small,
        ratios=by_angle,
        consequences=[consequence(name, factor) for name in FLOWN],
        times=measured_times(flown["paper-soft"].twin, fits.axial),
    )


def _lines(
    found: dict[str, Compared], fits: TunnelFits
) -> tuple[list[AxialCurve], list[ObliqueCurves], list[ThrustCurve]]:
    axial, oblique = found[AXIAL], found[OBLIQUE]
    printed = dict(list(axial.laws.items())[:1])
    laws = {**printed, fits.axial_four.label: fits.axial_four.law, fits.axial.label: fits.axial.law}
    own: dict[str, Airfoil] = {**printed, fits.oblique.label: fits.oblique.law}
    return (
        axial_curves(axial.data, laws),
        oblique_curves(oblique, own),
        thrust_curves(found[MULTIROTOR]),
    )
