"""The whole page and the files beside it."""

from __future__ import annotations

from collections.abc import Mapping

import jax
import numpy as np

import propmap
from propmap.catalogue.measurements import measurement
from propmap.papers.gill_dandrea_2017.files import PAGE
from propmap.papers.gill_dandrea_2017.numbers import Numbers
from propmap.papers.gill_dandrea_2017.pages.at_a_glance import at_a_glance
from propmap.papers.gill_dandrea_2017.pages.camber import camber
from propmap.papers.gill_dandrea_2017.pages.cost import cost
from propmap.papers.gill_dandrea_2017.pages.figure_6 import figure_6
from propmap.papers.gill_dandrea_2017.pages.figure_7 import figure_7
from propmap.papers.gill_dandrea_2017.pages.rotor_drag import rotor_drag
from propmap.papers.gill_dandrea_2017.pages.table_1 import table_1
from propmap.papers.gill_dandrea_2017.paper import CITATION, RIBNER
from propmap.papers.gill_dandrea_2017.tunnel import DATA_SETS
from propmap.report.page import Page, Points, Text, page_html


def pages(numbers: Numbers) -> Mapping[str, str | bytes]:
    """All files by name: the page, and a CSV and an SVG for what it shows."""
    parts = [
        table_1(numbers),
        figure_6(numbers),
        figure_7(numbers),
        camber(numbers),
        rotor_drag(numbers),
        cost(numbers.times),
    ]
    page = Page(
        title="Propeller thrust and drag in forward flight, reproduced",
        subtitle=f"By propmap {propmap.__version__}, command: propmap reproduce",
        lead=(*_lead(), at_a_glance(numbers)),
        sections=[part.section for part in parts],
        facts=_facts(),
    )
    files: dict[str, str | bytes] = {PAGE: page_html(page)}
    for part in parts:
        files |= part.files
    return files


def _lead() -> tuple[Text | Points, ...]:
    return (
        Text(
            "What the paper of Gill and D'Andrea (2017) shows, computed again from its own "
            "ingredients and public data: this model in solid lines, the hover model (thrust and "
            "torque from the rotational speed alone, no drag) dashed, measurements as points."
        ),
        Points(
            (
                "Every figure lies beside this page as SVG, the numbers of figures and tables as "
                "CSV. Two runs give the same numbers; only the times at the end differ.",
                "Where this model disagrees with a measurement, it is shown and said.",
            )
        ),
    )


def _facts() -> tuple[tuple[str, str], ...]:
    data = tuple(
        (title, f"{measurement(name).citation}. {measurement(name).note}")
        for name, title in DATA_SETS.items()
    )
    return (
        ("Paper", CITATION),
        *data,
        ("Blade geometry", "Landing Products (APC Propellers), performance data, September 2022"),
        ("Fin analogy", RIBNER),
        ("Software", f"propmap {propmap.__version__}, JAX {jax.__version__}, NumPy "
                     f"{np.__version__}"),
    )  # fmt: skip
