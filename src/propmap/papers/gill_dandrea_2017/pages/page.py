"""The whole page and the files beside it."""

from __future__ import annotations

import numpy as np

from propmap.catalogue.lookup import measurement
from propmap.papers.gill_dandrea_2017 import drag_sources, level_circles, paper, tunnel
from propmap.papers.gill_dandrea_2017 import rotor_drag as drag
from propmap.papers.gill_dandrea_2017.cost import Times
from propmap.papers.gill_dandrea_2017.identified import AXIAL, OBLIQUE, OTHER_FORM
from propmap.papers.gill_dandrea_2017.numbers import Numbers
from propmap.papers.gill_dandrea_2017.pages import figure_6, figure_7, rotor_drag, table_1
from propmap.papers.gill_dandrea_2017.tunnel_curves import OBLIQUE_OMEGA
from propmap.report.html import csv_of_rows, number, report_files
from propmap.units import RPM

FILES_OF_DATA = {
    AXIAL: "figure-7-axial",
    OBLIQUE: "figure-7-oblique",
    tunnel.MULTIROTOR: "figure-7-8x4.5mr",
}


def pages(numbers: Numbers) -> dict[str, str | bytes]:
    """All files by name: the page, and a CSV and an SVG for what it shows."""
    flown, found, lines = numbers.flown, numbers.compared, numbers.axial_curves
    figures = {
        "figure-6-level-circles": figure_6.loads_figure(flown),
        "figure-6-hover-failure": figure_6.cases_figure(flown),
        "figure-7-axial": figure_7.axial_figure(found[AXIAL], lines),
        "figure-7-oblique": figure_7.oblique_figure(found[OBLIQUE], numbers.oblique_curves),
        "figure-7-8x4.5mr": figure_7.multirotor_figure(
            found[tunnel.MULTIROTOR], numbers.thrust_curves
        ),
        "camber": figure_7.camber_figure(found[AXIAL], lines),
        "rotor-drag": rotor_drag.small_figure(numbers.small_incidence),
    }
    sheets = {
        **table_1.sheets(numbers),
        **figure_6.sheets(flown),
        **figure_7.sheets(FILES_OF_DATA, found, numbers.errors),
        "camber": figure_7.camber_sheet(found[AXIAL], lines),
        **rotor_drag.sheets(numbers),
        "times": _times_sheet(numbers.times),
    }
    return report_files(
        "papers/gill_dandrea_2017/pages/page.html.j2",
        figures,
        sheets,
        numbers=numbers,
        paper=paper,
        circles=level_circles,
        tunnel=tunnel,
        drag=drag,
        sources=drag_sources,
        plate_words=rotor_drag.plate_words,
        table_1=table_1,
        figure_6=figure_6,
        rotor_drag=rotor_drag,
        **figure_6.summary(flown),
        oblique_rpm=OBLIQUE_OMEGA / RPM,
        error_tables={
            f"{title}, {found[name].data.omega.size} points": figure_7.error_rows(
                [e for e in numbers.errors if e.data_set == name]
            )
            for name, title in tunnel.DATA_SETS.items()
        },
        worst=lambda *wanted: _shares(numbers, "worst_share", *wanted),
        typical=lambda *wanted: _shares(numbers, "rms_share", *wanted),
        camber=[figure_7.rms_errors(found[AXIAL], curve) for curve in lines.values()],
        zero_lift=[
            np.degrees(one.law.zero_lift_angle)
            for one in (numbers.fits.axial, numbers.fits.oblique)
        ],
        incidence=np.degrees(drag.INCIDENCE),
        seconds=_seconds,
        data={
            **{title: measurement(name) for name, title in tunnel.DATA_SETS.items()},
            "2019 campaign, oblique (its blade-element model)": measurement(OTHER_FORM),
        },
        software={"NumPy": np.__version__},
    )


def _shares(numbers: Numbers, share: str, data: str, label: str, *loads: str) -> float:
    """Largest share [%] in a data set among models with this in their label, and these loads."""
    return 100.0 * max(
        getattr(e, share)
        for e in numbers.errors
        if e.data_set == data and label in e.model and e.load in loads
    )


def _times_sheet(times: Times) -> str:
    return csv_of_rows(
        "what time_s paper_from_s paper_to_s",
        (
            ("one_point", times.one_point, paper.ONE_POINT, paper.ONE_POINT),
            ("per_point_of_256", times.per_point, None, None),
            ("level_flight_identification", times.level, *paper.IDENTIFICATION),
            ("tunnel_identification", times.tunnel, None, None),
        ),
    )


def _seconds(value: float) -> str:
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if value >= size:
            return f"{number(value / size, 2)} {unit}"
    return f"{number(value * 1e9, 2)} ns"
