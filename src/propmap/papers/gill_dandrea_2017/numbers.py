"""Everything that the page shows, computed once."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from propmap.arrays.types import Floats
from propmap.papers.gill_dandrea_2017.cost import Times, measured_times
from propmap.papers.gill_dandrea_2017.identified import AXIAL, OBLIQUE, TunnelFits, tunnel_fits
from propmap.papers.gill_dandrea_2017.level_circles import SetFlown, fly
from propmap.papers.gill_dandrea_2017.paper import FLOWN
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
    Coefficients,
    ThrustCurve,
    axial_curves,
    oblique_curves,
    thrust_curves,
)


@dataclass(frozen=True, eq=False)
class Numbers:
    """Results by part; see the functions that compute them."""

    flown: dict[str, SetFlown]
    fits: TunnelFits
    tunnel: dict[str, Compared]
    errors: list[LoadError]
    axial_curves: dict[str, Coefficients]
    oblique_curves: tuple[Floats, dict[str, dict[str, Floats]]]
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
        label, law = next(iter(found[AXIAL].laws.items()))
        four, axial, oblique = (
            {one.label: one.law} for one in (fits.axial_four, fits.axial, fits.oblique)
        )
        lines = axial_curves(found[AXIAL], {label: law} | four | axial)
        sweeps = oblique_curves(found[OBLIQUE], {label: law} | oblique)
        thrusts = thrust_curves(found[MULTIROTOR])
        small, by_angle = small_incidence(fits.oblique.law), ratios(fits.oblique.law)
        flown = flights.result()
    return Numbers(
        flown=flown,
        fits=fits,
        tunnel=found,
        errors=errors(found),
        axial_curves=lines,
        oblique_curves=sweeps,
        thrust_curves=thrusts,
        small_incidence=small,
        ratios=by_angle,
        consequences=[consequence(name, by_angle[0].ratio) for name in FLOWN],
        times=measured_times(flown["paper-soft"].twin.fitted, fits.axial.fitted),
    )
