"""Everything that the page shows, computed once."""

from __future__ import annotations

from dataclasses import dataclass

from propmap.papers.gill_dandrea_2017 import (
    drag_sources,
    plate,
    rotor_drag,
    tunnel,
    tunnel_curves,
)
from propmap.papers.gill_dandrea_2017.cost import Times, measured_times
from propmap.papers.gill_dandrea_2017.identified import (
    AXIAL,
    OBLIQUE,
    OBLIQUE_LABEL,
    TunnelFits,
    tunnel_fits,
)
from propmap.papers.gill_dandrea_2017.level_circles import SetFlown, fly
from propmap.papers.gill_dandrea_2017.paper import FLOWN
from propmap.typing import Floats


@dataclass(frozen=True, eq=False)
class Numbers:
    """Results by part; see the functions that compute them."""

    flown: dict[str, SetFlown]
    fits: TunnelFits
    compared: dict[str, tunnel.Compared]
    errors: list[tunnel.LoadError]
    axial_curves: dict[str, tunnel_curves.Coefficients]
    oblique_curves: tuple[Floats, dict[str, dict[str, Floats]]]
    thrust_curves: list[tunnel_curves.ThrustCurve]
    small_incidence: list[rotor_drag.SmallIncidence]
    ratios: list[rotor_drag.Ratio]
    drag_sources: list[drag_sources.Source]
    plates: list[plate.PlateFits]
    consequences: list[rotor_drag.Consequence]
    times: Times


def compute() -> Numbers:
    """All numbers."""
    flown = {name: fly(name) for name in FLOWN}
    fits = tunnel_fits()
    found = tunnel.compared(fits)
    printed = dict(list(found[AXIAL].laws.items())[:1])
    axial = printed | {one.label: one.law for one in (fits.axial_four, fits.axial)}
    slanted = found[OBLIQUE].laws
    oblique = printed | {
        label: slanted[label] for label in (OBLIQUE_LABEL, tunnel.RECOMMENDED_LABEL)
    }
    lines = tunnel_curves.axial_curves(found[AXIAL], axial)
    sweeps = tunnel_curves.oblique_curves(found[OBLIQUE], oblique)
    thrusts = tunnel_curves.thrust_curves(found[tunnel.MULTIROTOR])
    small = rotor_drag.small_incidence(fits.oblique.law)
    ratios = rotor_drag.ratios(found[OBLIQUE])
    return Numbers(
        flown=flown,
        fits=fits,
        compared=found,
        errors=tunnel.errors(found),
        axial_curves=lines,
        oblique_curves=sweeps,
        thrust_curves=thrusts,
        small_incidence=small,
        ratios=ratios,
        drag_sources=drag_sources.sources(found[OBLIQUE]),
        plates=plate.plate_fits(found[OBLIQUE]),
        consequences=[rotor_drag.consequence(name, ratios[0].ratio) for name in FLOWN],
        times=measured_times(flown["paper-soft"].twin.fitted, fits.axial.fitted),
    )
