"""What does not agree, second: rotor drag."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from propmap.papers.gill_dandrea_2017.drag_sources import Source
from propmap.papers.gill_dandrea_2017.identified import OBLIQUE, OBLIQUE_LABEL, OTHER_FORM
from propmap.papers.gill_dandrea_2017.level_circles import ASSUMED
from propmap.papers.gill_dandrea_2017.numbers import Numbers
from propmap.papers.gill_dandrea_2017.paper import FLOWN
from propmap.papers.gill_dandrea_2017.plate import PlateFits
from propmap.papers.gill_dandrea_2017.rotor_drag import (
    INCIDENCE,
    LIGHTLY_LOADED,
    Consequence,
    Ratio,
    SmallIncidence,
)
from propmap.papers.gill_dandrea_2017.tunnel import RECOMMENDED_LABEL
from propmap.report.html import (
    BAND,
    COLOURS,
    HOVER,
    MEASURED,
    MODEL,
    csv_of_columns,
    csv_of_rows,
    key,
    legend_in_last,
    new_figure,
    number,
    style,
)
from propmap.units import GRAVITY, RPM

LIGHT: dict[str, Any] = {"color": COLOURS[4], "alpha": 0.6, "linewidth": 0.0}
HEAVY: dict[str, Any] = {**LIGHT, "alpha": 0.25}
"""Shades of the fin analogy on a lightly and on a heavily loaded disk."""

SHOWN = (6.0, 10.0, 14.0)
MODELS = {OBLIQUE_LABEL: "the paper's inflow", RECOMMENDED_LABEL: "recommended inflow"}
DATA = {OBLIQUE: "polynomials", OTHER_FORM: "model of 2019"}
"""In words."""

IN_FLIGHT = (5.0, 10.0, 14.5)
"""[m/s] that are tabulated."""


@style()
def small_figure(small: list[SmallIncidence]) -> Figure:
    """Rotor drag over speed, a panel per propeller."""
    theory: dict[str, Any] = {"color": COLOURS[0], **MODEL}
    published: dict[str, Any] = {"color": COLOURS[1], "marker": "o", **MEASURED}
    figure = new_figure(9.6, 6.0)
    axes = figure.subplots(2, 3, sharex=True).ravel()
    for ax, one in zip(axes, small, strict=False):
        # The two shades meet at the first lightly loaded speed.
        edge = one.speed[np.argmax(one.inflow < LIGHTLY_LOADED)]
        for where, shade in ((one.speed >= edge, LIGHT), (one.speed <= edge, HEAVY)):
            ax.fill_between(one.speed, one.fin_low, one.fin_high, where=where, **shade)
        ax.plot(one.speed, one.theory, **theory)
        ax.axhline(0.0, **HOVER)
        if one.published is not None and one.other is not None:
            ax.fill_between(one.speed, one.published, one.other, color=COLOURS[1], **BAND)
            ax.plot(one.speed, one.published, **published)
        ax.set_title(f"{one.propeller}, {one.omega / RPM:.0f} rpm", fontsize=9.0)
        ax.set_ylabel("rotor drag D [N]")
        ax.set_xlim(0.0, 14.5)
        ax.set_xticks(range(0, 15, 2))
    handles = [
        key("this theory", **theory),
        Patch(label="fin analogy, lightly loaded disk", **LIGHT),
        Patch(label="fin analogy, heavily loaded disk", **HEAVY),
        key("polynomials of 2019, to its model", **published),
        key("hover model", **HOVER),
    ]
    legend_in_last(axes, handles, "speed V [m/s]")
    return figure


def theory_over_fin(small: list[SmallIncidence], *, light: bool) -> list[float]:
    """Ratios at all speeds with a lightly, or with a heavily loaded disk [-]."""
    return [
        float(value)
        for one in small
        for value in one.theory_over_fin[(one.inflow < LIGHTLY_LOADED) == light]
    ]


def small_rows(small: list[SmallIncidence]) -> list[tuple[str, ...]]:
    """Propeller, speed, inflow, forces [mN] and their ratios; three rows per propeller."""
    rows = []
    for one in small:
        published = np.full_like(one.speed, np.nan) if one.published is None else one.published
        for k in (int(np.argmin(np.abs(one.speed - speed))) for speed in SHOWN):
            forces = (one.theory, one.fin_low, one.fin_high, published)
            rows.append(
                (
                    one.propeller,
                    f"{one.speed[k]:.0f}",
                    number(one.inflow[k], 2),
                    *(number(1e3 * force[k]) for force in forces),
                    number(one.theory_over_fin[k]),
                    number(published[k] / one.theory[k]),
                )
            )
    return rows


def ratio_rows(ratios: list[Ratio]) -> list[tuple[Any, ...]]:
    """Angle, points, published over theoretical drag; a row per angle."""
    return [
        (f"{r.beta:.0f}", r.points, r.ratio, r.lowest, r.highest, r.other, r.recommended)
        for r in ratios
    ]


def source_rows(sources: list[Source]) -> list[tuple[str, ...]]:
    """Source, H'/mu at incidence and edgewise, H/(T mu), and the first two over the theory's."""
    theory = sources[0]
    return [
        (
            s.label,
            *(number(value, 2) for value in (s.incidence, s.edgewise, s.edgewise_by_thrust)),
            number(s.incidence / theory.incidence, 3),
            number(s.edgewise / theory.edgewise, 3),
        )
        for s in sources
    ]


def plate_rows(plates: list[PlateFits]) -> list[tuple[str, ...]]:
    """Theory, drag fitted, slipstream; factor alone, plate alone and both with the error left."""
    return [
        (
            MODELS[fit.model],
            DATA[fit.data],
            f"{fit.slipstream:g}",
            number(fit.factor.factor),
            f"{100 * fit.factor.error:.1f}",
            f"{1e4 * fit.plate.area:.0f}",
            f"{100 * fit.plate.error:.1f}",
            f"{number(fit.both.factor)}, {1e4 * fit.both.area:.0f}",
            f"{100 * fit.both.error:.1f}",
        )
        for fit in plates
    ]


def plate_words(plates: list[PlateFits]) -> str:
    """How a factor alone and a plate alone compare over these fits, in a sentence."""

    def span(errors: list[float]) -> str:
        return f"{100 * min(errors):.1f} to {100 * max(errors):.1f} %"

    factor, plate = ([getattr(fit, kind).error for fit in plates] for kind in ("factor", "plate"))
    better = sum(p < f for p, f in zip(plate, factor, strict=True))
    return (
        f"This propeller alone does not tell a factor from a plate: the former leaves "
        f"{span(factor)}, the latter {span(plate)}, and the plate is the better one in {better} of "
        f"{len(plates)} cases."
    )


def flight_rows(consequences: list[Consequence]) -> list[tuple[str, ...]]:
    """Propeller, speed, and pairs of pitch, rotor speed and shaft power."""
    rows = []
    for one in consequences:
        pair = (one.theory, one.published)
        for k in (int(np.argmin(np.abs(one.theory.speed - speed))) for speed in IN_FLIGHT):
            rows.append(
                (
                    FLOWN[one.name],
                    f"{one.theory.speed[k]:.1f}",
                    *(f"{np.degrees(c.pitch[k]):.1f}" for c in pair),
                    *(f"{c.rotor_speed[k] / RPM:.0f}" for c in pair),
                    *(number(c.torque[k] * c.rotor_speed[k]) for c in pair),
                )
            )
    return rows


def sheets(numbers: Numbers) -> dict[str, str]:
    """The CSV files."""
    return {
        "rotor-drag": csv_of_columns(
            {
                "propeller": one.propeller,
                "rpm": one.omega / RPM,
                "incidence_deg": np.degrees(INCIDENCE),
                "speed_mps": one.speed,
                "inflow_over_speed": one.inflow,
                "theory_N": one.theory,
                "fin_chord_line_N": one.fin_low,
                "fin_zero_lift_line_N": one.fin_high,
                "polynomials_2019_N": one.published,
                "model_2019_N": one.other,
            }
            for one in numbers.small_incidence
        ),
        "rotor-drag-by-angle": csv_of_rows(
            "beta_deg points polynomials_over_theory lowest highest model_over_theory "
            "polynomials_over_recommended",
            [
                (r.beta, r.points, r.ratio, r.lowest, r.highest, r.other, r.recommended)
                for r in numbers.ratios
            ],
        ),
        "rotor-drag-sources": csv_of_rows(
            "source incidence_H_over_mu edgewise_H_over_mu edgewise_H_over_T_mu",
            [
                (s.label, s.incidence, s.edgewise, s.edgewise_by_thrust)
                for s in numbers.drag_sources
            ],
        ),
        "rotor-drag-plate": csv_of_rows(
            "model data slipstream_factor factor_alone factor_rms_over_rms_measured plate_alone_m2 "
            "plate_rms_over_rms_measured both_factor both_plate_m2 both_rms_over_rms_measured",
            [
                (
                    fit.model,
                    fit.data,
                    fit.slipstream,
                    fit.factor.factor,
                    fit.factor.error,
                    fit.plate.area,
                    fit.plate.error,
                    fit.both.factor,
                    fit.both.area,
                    fit.both.error,
                )
                for fit in numbers.plates
            ],
        ),
        "rotor-drag-in-flight": csv_of_columns(
            {
                "set": one.name,
                "drag_factor": factor,
                "speed_mps": c.speed,
                "pitch_deg": np.degrees(c.pitch),
                "rotor_speed_rpm": c.rotor_speed / RPM,
                "thrust_N": c.thrust,
                "drag_N": c.drag,
                "torque_Nm": c.torque,
                "hover_force_error_share_of_weight": c.hover_error / (ASSUMED.mass * GRAVITY),
            }
            for one in numbers.consequences
            for factor, c in ((1.0, one.theory), (one.factor, one.published))
        ),
    }
