"""Figure 6: level circles of a tethered quadrotor."""

from __future__ import annotations

import numpy as np

from propmap.papers.gill_dandrea_2017.level_circles import (
    ASSUMED,
    FORCE_ERROR,
    Case,
    HoverFailure,
    SetFlown,
    hover_failure,
    static_inflow,
)
from propmap.papers.gill_dandrea_2017.numbers import Numbers
from propmap.papers.gill_dandrea_2017.pages.level_circle_pictures import (
    TITLES,
    cases_figure,
    loads_figure,
)
from propmap.papers.gill_dandrea_2017.paper import FASTEST, HOVER_FAILS, SIGN_CHANGES
from propmap.report.page import Section, Table, Text, Verdict, number
from propmap.report.part import Part, files_of, picture
from propmap.report.sheet import csv_of_rows


def figure_6(numbers: Numbers) -> Part:
    """Loads, force error and pitch against speed; where the hover model fails."""
    flown = numbers.flown
    loads = picture(
        loads_figure(flown),
        "figure-6-level-circles",
        f"Level circles on a 1.7 m tether, {ASSUMED.mass:g} kg, frame drag area "
        f"{ASSUMED.drag_area:g} m². Lines: this model with the sets of Table I. Dashed: the hover "
        "model at the same rotor speeds. Points: the set identified from 20 simulated flights, "
        f"bars: the unknown force of {100 * FORCE_ERROR:.0f} % of the weight in each.",
        "Six panels against flight speed for a soft and a stiff propeller.",
    )
    cases = picture(
        cases_figure(flown),
        "figure-6-hover-failure",
        "Vertical force by the hover model less the weight, for several assumed masses and "
        "drag areas of the frame; the dotted line marks the speed that the paper gives.",
        "The hover model's force error against flight speed, one panel per propeller.",
    )
    section = Section(
        "figure-6",
        "Figure 6: where the hover model fails in flight",
        (
            Verdict("caution", "In part", _verdict(flown)),
            Text(
                "The paper flew level circles on a tether and measured. Those logs are not at "
                "hand, so the flights here are computed: this model with the printed set is the "
                "truth. "
                "This shows what a hover model misses if the theory is right; it cannot show "
                "that the theory is right. The paper's mass and frame drag are not known here "
                "either, and the result depends on them, so several are shown."
            ),
            loads,
            cases,
            failure_table(flown),
            Text(
                "Why: in slow flight the rotors meet fresh air and carry more than at rest, so at "
                "the speed they need the hover model predicts too little. In fast flight the "
                "vehicle leans into its drag, air comes through the disks from above, the rotors "
                "must turn faster, and the hover model predicts too much. Without any drag of the "
                "frame the second effect never wins. Speeds scale with the static inflow, so "
                "a heavier vehicle fails later."
            ),
        ),
    )
    files = files_of(loads, cases) | {
        "figure-6-level-circles.csv": _circles_csv(flown),
        "figure-6-identification.csv": _twin_csv(flown),
        "figure-6-hover-failure.csv": _errors_csv(flown),
        "figure-6-failure-speeds.csv": _failures_csv(flown),
    }
    return Part(section, files)


def failures(one: SetFlown) -> dict[Case, HoverFailure]:
    """Of every case."""
    return {case: hover_failure(found, case.mass) for case, found in one.circles.items()}


def failure_table(flown: dict[str, SetFlown]) -> Table:
    """Speeds at which the hover model fails, by case."""
    rows = []
    for name, one in flown.items():
        for case, failure in failures(one).items():
            low, high = failure.exceeds
            change = failure.sign_changes
            rows.append(
                (
                    TITLES[name],
                    number(case.mass),
                    number(case.drag_area),
                    number(static_inflow(case)),
                    _speed(low),
                    _speed(high),
                    _speed(change),
                    number(HOVER_FAILS[name]),
                )
            )
    columns = (
        ("propeller", ""),
        ("mass", "kg"),
        ("drag area", "m²"),
        ("static inflow", "m/s"),
        ("off by 5 %", "m/s"),
        ("off by 10 %", "m/s"),
        ("turns from too little to too much", "m/s"),
        ("paper: fails", "m/s"),
    )
    return Table(
        "Flight speeds from which the hover model's vertical force is off by so much of the "
        "weight, and at which its sign changes.",
        columns,
        tuple(rows),
        f"“never”: not up to {FASTEST:g} m/s. The paper's change of sign is at "
        f"{SIGN_CHANGES:g} m/s.",
    )


def _speed(value: float | None) -> str:
    return "never" if value is None else f"{value:.1f}"


def _verdict(flown: dict[str, SetFlown]) -> str:
    every = {name: failures(one) for name, one in flown.items()}
    changes = {
        name: [f.sign_changes for f in found.values() if f.sign_changes is not None]
        for name, found in every.items()
    }
    first = [f.exceeds[0] for found in every.values() for f in found.values() if f.exceeds[0]]
    earlier = all(
        (soft.sign_changes or np.inf) <= (stiff.sign_changes or np.inf)
        for soft, stiff in zip(
            every["paper-soft"].values(), every["paper-stiff"].values(), strict=True
        )
    )
    order = (
        "the soft propeller before the stiff one, as in the paper"
        if earlier
        else ("in no fixed order of soft and stiff, unlike in the paper")
    )
    text = (
        "The paper's pattern comes out: the hover model predicts too little vertical force in "
        f"slow flight and too much in fast flight, {order}. The speeds do not follow from what "
        "the paper gives: where the sign changes at all, it does so between "
    )
    text += " and ".join(
        f"{min(v):.1f} and {max(v):.1f} m/s ({TITLES[name]})" for name, v in changes.items() if v
    )
    return text + (
        " over the cases below, against the paper's 7 and 9 m/s; without frame drag, or with a "
        f"heavier vehicle, not up to {FASTEST:g} m/s. And the hover model is off by 5 % of the "
        f"weight already from {min(first):.1f} to {max(first):.1f} m/s."
    )


def _circles_csv(flown: dict[str, SetFlown]) -> str:
    heads = (
        "set", "speed_mps", "rotor_speed_rpm", "pitch_deg", "thrust_N", "drag_N", "torque_Nm",
        "hover_thrust_N", "hover_torque_Nm", "hover_force_error_N",
    )  # fmt: skip
    rows = []
    for name, one in flown.items():
        c = one.circles[ASSUMED]
        columns = (
            c.speed, c.rotor_speed * 30.0 / np.pi, np.degrees(c.pitch), c.thrust, c.drag, c.torque,
            c.hover_thrust, c.hover_torque, c.hover_error,
        )  # fmt: skip
        rows += [(name, *row) for row in np.stack(columns, axis=1).tolist()]
    return csv_of_rows(heads, rows)


def _errors_csv(flown: dict[str, SetFlown]) -> str:
    heads = ("set", "mass_kg", "drag_area_m2", "speed_mps", "hover_force_error_N")
    rows = [
        (name, case.mass, case.drag_area, *row)
        for name, one in flown.items()
        for case, c in one.circles.items()
        for row in np.stack([c.speed, c.hover_error], axis=1).tolist()
    ]
    return csv_of_rows(heads, rows)


def _twin_csv(flown: dict[str, SetFlown]) -> str:
    rows = [
        (name, *row)
        for name, one in flown.items()
        for row in np.stack([one.twin.speed, one.twin.error, one.twin.hover_error], 1).tolist()
    ]
    return csv_of_rows(("set", "speed_mps", "force_error_N", "hover_force_error_N"), rows)


def _failures_csv(flown: dict[str, SetFlown]) -> str:
    heads = (
        "set", "mass_kg", "drag_area_m2", "static_inflow_mps", "off_by_5_percent_mps",
        "off_by_10_percent_mps", "sign_changes_mps", "paper_fails_mps",
    )  # fmt: skip
    rows = [
        (name, c.mass, c.drag_area, static_inflow(c), *f.exceeds, f.sign_changes, HOVER_FAILS[name])
        for name, one in flown.items()
        for c, f in failures(one).items()
    ]
    return csv_of_rows(heads, rows)
