"""Figure 6: level circles of a tethered quadrotor."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from propmap.papers.gill_dandrea_2017.level_circles import (
    ASSUMED,
    CASES,
    FORCE_ERROR,
    SetFlown,
    static_inflow,
)
from propmap.papers.gill_dandrea_2017.paper import FASTEST, FLOWN, HOVER_FAILS
from propmap.report.html import (
    COLOURS,
    DASHED,
    MEASURED,
    MODEL,
    csv_of_columns,
    csv_of_rows,
    key,
    legend_below,
    legend_in_last,
    marked,
    new_figure,
    number,
    share_of_weight,
    style,
)
from propmap.units import GRAVITY, RPM

WEIGHT = ASSUMED.mass * GRAVITY
FACES = (COLOURS[0], "white")
"""Of the markers, full and hollow, told apart in print without colour."""

LABELS = (
    "collective thrust ΣT [N]",
    "collective rotor drag ΣD [N]",
    "collective torque [mN m]",
    "vertical force error [N]",
    "pitch angle, nose down [deg]",
)


@style()
def loads_figure(flown: dict[str, SetFlown]) -> Figure:
    """The paper's five panels, and a legend in the sixth."""
    figure = new_figure(9.6, 6.2)
    axes = figure.subplots(2, 3, sharex=True).ravel()
    handles, big = [], {**MEASURED, "clip_on": True}
    for k, (name, one) in enumerate(flown.items()):
        c, look = one.circles[ASSUMED], {"color": COLOURS[k]}
        lines = (
            (c.thrust, c.hover_thrust),
            (c.drag, 0.0 * c.drag),
            (1e3 * c.torque, 1e3 * c.hover_torque),
            (None, c.hover_error),
            (np.degrees(c.pitch), None),
        )
        for ax, (model, hover) in zip(axes, lines, strict=False):
            if model is not None:
                ax.plot(c.speed, model, **look, **MODEL)
            if hover is not None:
                ax.plot(c.speed, hover, **look, **DASHED)
        found: dict[str, Any] = {**marked(k), "linestyle": "none", "markerfacecolor": FACES[k]}
        axes[3].errorbar(
            one.twin.speed, one.twin.error, FORCE_ERROR * WEIGHT, markersize=3.5, elinewidth=0.8,
            **found,
        )  # fmt: skip
        handles += [
            key(f"{FLOWN[name]}: this model", **look, **MODEL),
            key(f"{FLOWN[name]}: hover model", **look, **DASHED),
            key(f"{FLOWN[name]}: identified,\nsimulated flights", **(big | found)),
        ]
    for ax, label in zip(axes, LABELS, strict=False):
        ax.set_ylabel(label)
        ax.margins(x=0.02)
    axes[3].axhline(0.0, color="0.6", linewidth=0.8)
    share_of_weight(axes[3], WEIGHT)
    legend_in_last(axes, handles, "flight speed V [m/s]")
    return figure


@style()
def cases_figure(flown: dict[str, SetFlown]) -> Figure:
    """The hover model's error in every case, a panel per set."""
    figure = new_figure(9.2, 4.2)
    axes = figure.subplots(1, 2, sharey=True)
    for ax, (name, one) in zip(axes, flown.items(), strict=True):
        ax.axhline(0.0, color="0.6", linewidth=0.8)
        ax.axvline(HOVER_FAILS[name], color="0.3", linewidth=1.0, linestyle=":")
        for k, case in enumerate(sorted(CASES, key=lambda case: (case.mass, case.drag_area))):
            found = one.circles[case]
            share = 100.0 * found.hover_error / (case.mass * GRAVITY)
            ax.plot(
                found.speed, share, markersize=3.5, markevery=(2 + k, 6),
                label=f"{case.mass:g} kg, {case.drag_area:g} m²", **marked(k), **DASHED,
            )  # fmt: skip
        ax.set_title(f"{FLOWN[name]} propeller", fontsize=9.0)
        ax.set_xlabel("flight speed V [m/s]")
        ax.set_xlim(0.0, FASTEST)
    axes[0].set_ylim(-35.0, 60.0)
    axes[0].set_ylabel("vertical force error\nof the hover model [% of the weight]")
    handles = axes[0].get_legend_handles_labels()[0]
    legend_below(figure, handles, handlelength=3.2, columnspacing=1.2)
    return figure


def failure_rows(flown: dict[str, SetFlown]) -> list[tuple[str, ...]]:
    """Propeller, case, static inflow, speeds at which the hover model fails; a row per case."""
    return [
        (
            FLOWN[name],
            *(number(v) for v in (case.mass, case.drag_area, static_inflow(case))),
            *("never" if v is None else f"{v:.1f}" for v in (*found.exceeds, found.sign_changes)),
            number(HOVER_FAILS[name]),
        )
        for name, one in flown.items()
        for case, found in one.failures.items()
    ]


def summary(flown: dict[str, SetFlown]) -> dict[str, Any]:
    """For the words of the page.

    ``changes``: speeds of the change of sign by set, for the cases that have one; ``early``: speeds
    from which the error exceeds 5 % of the weight; ``in_order``: whether the sign changes for the
    soft propeller before the stiff one in every case.
    """
    cases = [list(one.failures.values()) for one in flown.values()]
    pairs = [[f.sign_changes or math.inf for f in pair] for pair in zip(*cases, strict=True)]
    return {
        "changes": {
            name: [f.sign_changes for f in found if f.sign_changes is not None]
            for name, found in zip(flown, cases, strict=True)
        },
        "early": [f.exceeds[0] for found in cases for f in found if f.exceeds[0]],
        "in_order": all(soft <= stiff for soft, stiff in pairs),
    }


def sheets(flown: dict[str, SetFlown]) -> dict[str, str]:
    """The CSV files."""
    assumed = {name: one.circles[ASSUMED] for name, one in flown.items()}
    return {
        "figure-6-level-circles": csv_of_columns(
            {
                "set": name,
                "speed_mps": c.speed,
                "rotor_speed_rpm": c.rotor_speed / RPM,
                "pitch_deg": np.degrees(c.pitch),
                "thrust_N": c.thrust,
                "drag_N": c.drag,
                "torque_Nm": c.torque,
                "hover_thrust_N": c.hover_thrust,
                "hover_torque_Nm": c.hover_torque,
                "hover_force_error_N": c.hover_error,
            }
            for name, c in assumed.items()
        ),
        "figure-6-identification": csv_of_columns(
            {
                "set": name,
                "speed_mps": one.twin.speed,
                "force_error_N": one.twin.error,
                "hover_force_error_N": one.twin.hover_error,
            }
            for name, one in flown.items()
        ),
        "figure-6-hover-failure": csv_of_columns(
            {
                "set": name,
                "mass_kg": case.mass,
                "drag_area_m2": case.drag_area,
                "speed_mps": c.speed,
                "hover_force_error_N": c.hover_error,
            }
            for name, one in flown.items()
            for case, c in one.circles.items()
        ),
        "figure-6-failure-speeds": csv_of_rows(
            "set mass_kg drag_area_m2 static_inflow_mps off_by_5_percent_mps "
            "off_by_10_percent_mps sign_changes_mps paper_fails_mps",
            [
                (
                    name,
                    case.mass,
                    case.drag_area,
                    static_inflow(case),
                    *found.exceeds,
                    found.sign_changes,
                    HOVER_FAILS[name],
                )
                for name, one in flown.items()
                for case, found in one.failures.items()
            ],
        ),
    }
