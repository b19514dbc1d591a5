"""The paper's statements and what came out, in one table."""

from __future__ import annotations

from propmap.papers.gill_dandrea_2017.identified import AXIAL, OBLIQUE
from propmap.papers.gill_dandrea_2017.level_circles import ASSUMED
from propmap.papers.gill_dandrea_2017.numbers import Numbers
from propmap.papers.gill_dandrea_2017.pages.figure_6 import failures
from propmap.papers.gill_dandrea_2017.pages.level_circle_pictures import TITLES
from propmap.papers.gill_dandrea_2017.paper import (
    HOVER_FAILS,
    HOVER_TUNNEL_ERROR,
    SIGN_CHANGES,
    TUNNEL_ERROR,
)
from propmap.papers.gill_dandrea_2017.tunnel import HOVER_LABEL
from propmap.report.page import Table


def at_a_glance(numbers: Numbers) -> Table:
    """A line per statement; what depends on assumptions is given as a range."""
    rows = []
    for name, flown in numbers.flown.items():
        found = failures(flown)
        changes = [f.sign_changes for f in found.values() if f.sign_changes is not None]
        own = found[ASSUMED]
        rows.append(
            (
                f"hover model fails in flight, {TITLES[name]} propeller",
                f"{HOVER_FAILS[name]:g} m/s",
                f"off by 5 % of the weight at {_speed(own.exceeds[0])}, by 10 % at "
                f"{_speed(own.exceeds[1])}",
            )
        )
        rows.append(
            (
                f"its error changes sign, {TITLES[name]} propeller",
                f"{SIGN_CHANGES:g} m/s",
                f"{_speed(own.sign_changes)}; {min(changes):.1f} to {max(changes):.1f} m/s over "
                f"the masses and frames tried, in {len(found) - len(changes)} of {len(found)} not "
                "at all",
            )
        )
    rows += [
        (
            "this model in the tunnel, worst error",
            f"{100 * TUNNEL_ERROR:.0f} %",
            f"thrust and torque {_worst(numbers, OBLIQUE, '2019'):.0f} % (oblique) and "
            f"{_worst(numbers, AXIAL, 'UIUC'):.0f} % (axial) of full scale, identified with "
            f"camber; {_worst(numbers, OBLIQUE, 'Table I'):.0f} % and "
            f"{_worst(numbers, AXIAL, 'Table I'):.0f} % with Table I as printed",
        ),
        (
            "the hover model in the tunnel, worst error",
            f"{100 * HOVER_TUNNEL_ERROR:.0f} %",
            f"{100 * max(e.worst_share for e in numbers.errors if e.model == HOVER_LABEL):.0f} % "
            "of full scale",
        ),
        (
            "rotor drag",
            "agrees with the theory",
            f"the 2019 fit has {numbers.ratios[0].ratio:.1f} to {numbers.ratios[-1].ratio:.1f} "
            "times the theory's; the fin analogy of 1945 is near the theory",
        ),
    ]
    columns = (("statement", ""), ("paper", ""), ("here", ""))
    return Table("At a glance.", columns, tuple(rows))


def _speed(value: float | None) -> str:
    return "no speed flown" if value is None else f"{value:.1f} m/s"


def _worst(numbers: Numbers, data: str, label: str) -> float:
    mine = (e for e in numbers.errors if e.data_set == data and label in e.model)
    return 100.0 * max(e.worst_share for e in mine if e.load in ("thrust", "torque"))
