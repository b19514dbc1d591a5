"""What does not agree, second: rotor drag."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from propmap.papers.gill_dandrea_2017.level_circles import ASSUMED, hover_failure
from propmap.papers.gill_dandrea_2017.numbers import Numbers
from propmap.papers.gill_dandrea_2017.pages.level_circle_pictures import TITLES
from propmap.papers.gill_dandrea_2017.paper import HOVER_FAILS, RIBNER
from propmap.papers.gill_dandrea_2017.rotor_drag import (
    INCIDENCE,
    LIGHTLY_LOADED,
    Consequence,
    SmallIncidence,
)
from propmap.report.page import Points, Section, Table, Text, Verdict, number
from propmap.report.part import Part, files_of, picture
from propmap.report.sheet import csv_of_rows
from propmap.report.style import COLOURS, HOVER, MEASURED, MODEL, new_figure, style
from propmap.vehicle.flight_log import GRAVITY

RPM = 30.0 / np.pi
SHADE: dict[str, Any] = {"color": COLOURS[4], "alpha": 0.35, "linewidth": 0.0}
IN_FLIGHT = (5.0, 10.0, 14.5)
"""[m/s] at which the consequences are tabulated."""


def rotor_drag(numbers: Numbers) -> Part:
    """Theory, published fit and fin side by side, and what follows."""
    small = numbers.small_incidence
    shown = picture(
        small_figure(small),
        "rotor-drag",
        f"Force in the disk plane at {np.degrees(INCIDENCE):.0f}° incidence and a tip speed of "
        "70 m/s. Lines: this theory with the set identified from thrust and torque of the 8x6E "
        "(2019), for all propellers. Shaded: Ribner's fin analogy, with the side area from the "
        "chord line's pitch (lower edge) to the zero-lift line's (upper edge); paler where the "
        "disk is heavily loaded, for which it was not made. Points: the published fit of 2019, "
        "which is at hand for the 8x6E alone. Dashed: the hover model, which has no rotor drag.",
        "Rotor drag against speed for five propellers.",
    )
    light = [
        value for one in small for value in (one.theory / _middle(one))[one.inflow < LIGHTLY_LOADED]
    ]
    heavy = [
        value
        for one in small
        for value in (one.theory / _middle(one))[one.inflow >= LIGHTLY_LOADED]
    ]
    by_angle = numbers.ratios
    low, high = by_angle[0].ratio, by_angle[-1].ratio
    section = Section(
        "rotor-drag",
        "What does not agree: rotor drag",
        (
            Verdict(
                "bad",
                "Sources differ by a factor of two",
                f"The published fit of 2019 has {low:.1f} times this theory's rotor drag at "
                f"15° incidence and {high:.1f} times edgewise, though the same parameters match "
                "its thrust, torque and rolling moment. Ribner's fin analogy, verified on "
                "propellers in tunnels in the 1940s, sides with the theory where the disk is "
                f"lightly loaded (theory {min(light):.2f} to {max(light):.2f} times the fin). "
                "Nothing is tuned here.",
            ),
            shown,
            small_table(small),
            ratio_table(numbers),
            Text(
                "The fin: a propeller in yaw acts like a fin with the projected side area of "
                "the blades, N_b/2 ∫ c sin θ dy averaged over a turn, an effective aspect ratio "
                "of 8 (lift slope 2π·8/10), and a dynamic pressure raised by f(a) = (1+a)"
                "[(1+a)+(1+2a)²]/[1+(1+2a)²], a being the inflow over the flight speed by momentum "
                "theory from the thrust at zero incidence. Left out: spinner, nacelle, "
                f"compressibility, and the blades' profile drag. {RIBNER}."
            ),
            Text(
                "It is a check for cruise: forces of the order of the incidence, a well below 1. "
                f"In slow flight with a heavily loaded disk (a above {LIGHTLY_LOADED}) the theory "
                f"exceeds it by {min(heavy):.1f} to {max(heavy):.1f} times, and neither the fin "
                "nor the small-angle theory behind it was made for that. There the published fit "
                "is further away still."
            ),
            _consequence_table(numbers.consequences),
            Points(_what_follows(numbers)),
        ),
    )
    files = files_of(shown) | {
        "rotor-drag.csv": _small_csv(small),
        "rotor-drag-by-angle.csv": csv_of_rows(
            ("beta_deg", "points", "published_over_theory", "lowest", "highest"),
            [(r.beta, r.points, r.ratio, r.lowest, r.highest) for r in by_angle],
        ),
        "rotor-drag-in-flight.csv": _flight_csv(numbers.consequences),
    }
    return Part(section, files)


def small_figure(small: list[SmallIncidence]) -> Figure:
    """A panel per propeller."""
    with style():
        figure = new_figure(9.6, 6.0)
        axes = figure.subplots(2, 3, sharex=True).ravel()
        for ax, one in zip(axes, small, strict=False):
            light = one.inflow < LIGHTLY_LOADED
            # The two shades meet at the first lightly loaded speed.
            edge = one.speed >= one.speed[np.argmax(light)]
            for where, alpha in ((edge, 0.6), (one.speed <= one.speed[np.argmax(light)], 0.25)):
                ax.fill_between(
                    one.speed, one.fin_low, one.fin_high, where=where, **(SHADE | {"alpha": alpha})
                )
            ax.plot(one.speed, one.theory, color=COLOURS[0], **MODEL)
            ax.axhline(0.0, **HOVER)
            if one.published is not None:
                ax.plot(one.speed, one.published, color=COLOURS[1], marker="o", **MEASURED)
            ax.set_title(f"{one.propeller}, {one.omega * RPM:.0f} rpm", fontsize=9.0)
            ax.set_ylabel("rotor drag D [N]")
            ax.set_xlim(0.0, 14.5)
            ax.set_xticks(range(0, 15, 2))
        for ax in axes[2:5]:
            ax.set_xlabel("speed V [m/s]")
            ax.tick_params(labelbottom=True)
        axes[5].axis("off")
        handles: list[Any] = [
            Line2D([], [], color=COLOURS[0], label="this theory", **MODEL),
            Patch(label="fin analogy, lightly loaded disk", **(SHADE | {"alpha": 0.6})),
            Patch(label="fin analogy, heavily loaded disk", **(SHADE | {"alpha": 0.25})),
            Line2D([], [], color=COLOURS[1], marker="o", label="published fit, 2019", **MEASURED),
            Line2D([], [], label="hover model", **HOVER),
        ]
        axes[5].legend(handles=handles, loc="center", fontsize=9.0)
    return figure


def small_table(small: list[SmallIncidence]) -> Table:
    """Forces at three speeds per propeller."""
    rows = []
    for one in small:
        for speed in (6.0, 10.0, 14.0):
            k = int(np.argmin(np.abs(one.speed - speed)))
            published = None if one.published is None else float(one.published[k])
            rows.append(
                (
                    one.propeller,
                    f"{one.speed[k]:.0f}",
                    number(float(one.inflow[k]), 2),
                    number(1e3 * float(one.theory[k])),
                    number(1e3 * float(one.fin_low[k])),
                    number(1e3 * float(one.fin_high[k])),
                    number(None if published is None else 1e3 * published),
                    number(float((one.theory / _middle(one))[k])),
                    number(None if published is None else published / float(one.theory[k])),
                )
            )
    columns = (
        ("propeller", ""),
        ("speed", "m/s"),
        ("inflow a", "-"),
        ("theory", "mN"),
        ("fin, chord line", "mN"),
        ("fin, zero-lift line", "mN"),
        ("2019 fit", "mN"),
        ("theory / fin", "-"),
        ("2019 fit / theory", "-"),
    )
    return Table(
        f"Rotor drag at {np.degrees(INCIDENCE):.0f}° incidence.",
        columns,
        tuple(rows),
        "theory / fin: with the mean of both side areas.",
    )


def ratio_table(numbers: Numbers) -> Table:
    """Published over theoretical drag by angle."""
    rows = tuple(
        (f"{r.beta:.0f}", str(r.points), number(r.ratio), number(r.lowest), number(r.highest))
        for r in numbers.ratios
    )
    columns = (
        ("β", "deg"), ("points", "-"), ("rms over rms", "-"), ("smallest", "-"), ("largest", "-")
    )  # fmt: skip
    return Table("APC 8x6E: the 2019 fit's rotor drag over this theory's, by angle.", columns, rows)


def _middle(one: SmallIncidence) -> Any:
    return 0.5 * (one.fin_low + one.fin_high)


def _at(one: Consequence, speed: float) -> int:
    return int(np.argmin(np.abs(one.theory.speed - speed)))


def _consequence_table(consequences: list[Consequence]) -> Table:
    rows = []
    for one in consequences:
        for speed in IN_FLIGHT:
            k = _at(one, speed)
            pair = (one.theory, one.published)
            power = [c.torque[k] * c.rotor_speed[k] for c in pair]
            rows.append(
                (
                    TITLES[one.name],
                    f"{one.theory.speed[k]:.1f}",
                    *(f"{np.degrees(c.pitch[k]):.1f}" for c in pair),
                    *(f"{c.rotor_speed[k] * RPM:.0f}" for c in pair),
                    *(number(p) for p in power),
                )
            )
    factor = consequences[0].factor
    columns = (
        ("propeller", ""),
        ("speed", "m/s"),
        ("pitch, theory's drag", "deg"),
        (f"{factor:.1f} times", "deg"),
        ("rotor speed", "1/min"),
        (f"{factor:.1f} times", "1/min"),
        ("shaft power", "W"),
        (f"{factor:.1f} times", "W"),
    )
    return Table(
        "What it means in flight: the quadrotor of figure 6 with the theory's rotor drag and with "
        f"{factor:.1f} times as much.",
        columns,
        tuple(rows),
        "Shaft power of all four rotors; their torque is left as the theory has it.",
    )


def _what_follows(numbers: Numbers) -> tuple[str, ...]:
    changes = []
    for one in numbers.consequences:
        found = hover_failure(one.published, ASSUMED.mass).sign_changes
        if found is not None:
            changes.append(f"{found:.1f} m/s ({TITLES[one.name]}; paper {HOVER_FAILS[one.name]:g})")
    factor = numbers.consequences[0].factor
    return (
        "Thrust, torque and rolling moment do not depend on it: use them as they are.",
        f"Take rotor drag as known within a factor of {factor:.1f}: the theory's value is the "
        "lower end. What hangs on it is the lean in fast flight, braking, and the top speed.",
        "If you can, measure it: the lean in steady level flight at two speeds fixes the sum of "
        "frame and rotor drag. propmap fit flight --free …,drag_factor fits the factor, and says "
        "when the data cannot tell it from the drag of the frame.",
        f"With {factor:.1f} times the theory's rotor drag, and {ASSUMED.drag_area:g} m² of frame, "
        "the sign of the hover model's error in figure 6 would change at "
        + (" and ".join(changes) or "no speed flown")
        + ". This is a hint, not evidence: more frame drag does the same.",
    )


def _small_csv(small: list[SmallIncidence]) -> str:
    heads = (
        "propeller", "rpm", "incidence_deg", "speed_mps", "inflow_over_speed", "theory_N",
        "fin_chord_line_N", "fin_zero_lift_line_N", "published_fit_2019_N",
    )  # fmt: skip
    rows = []
    for one in small:
        nothing = np.full_like(one.speed, np.nan)
        published = nothing if one.published is None else one.published
        columns = (one.speed, one.inflow, one.theory, one.fin_low, one.fin_high, published)
        rows += [
            (one.propeller, one.omega * RPM, float(np.degrees(INCIDENCE)), *row)
            for row in np.stack(columns, axis=1).tolist()
        ]
    return csv_of_rows(heads, rows)


def _flight_csv(consequences: list[Consequence]) -> str:
    heads = (
        "set", "drag_factor", "speed_mps", "pitch_deg", "rotor_speed_rpm", "thrust_N", "drag_N",
        "torque_Nm", "hover_force_error_share_of_weight",
    )  # fmt: skip
    rows = []
    for one in consequences:
        for factor, c in ((1.0, one.theory), (one.factor, one.published)):
            share = c.hover_error / (ASSUMED.mass * GRAVITY)
            columns = (
                c.speed, np.degrees(c.pitch), c.rotor_speed * RPM, c.thrust, c.drag, c.torque, share
            )  # fmt: skip
            rows += [(one.name, factor, *row) for row in np.stack(columns, axis=1).tolist()]
    return csv_of_rows(heads, rows)
