"""The numbers, figures and tables of the page, and its files."""

from __future__ import annotations

import os
import platform
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from papers.gill_dandrea_2017 import level_circles, paper, rotor_drag, table_1, tunnel
from papers.gill_dandrea_2017.tunnel import AXIAL, MULTIROTOR, OBLIQUE, OTHER_FORM
from propmap.catalogue.lookup import measurement
from propmap.fit.fit import Fitted, fit
from propmap.model.airfoil import parameter_set
from propmap.model.model import Model
from propmap.report.html import csv_of_rows, file_names, number, report_files
from propmap.rotor import Rotor
from propmap.units import RPM

FIGURES = (
    "figure-6-level-circles",
    "figure-6-hover-failure",
    "figure-7-axial",
    "figure-7-oblique",
    "figure-7-8x4.5mr",
    "camber",
    "rotor-drag",
)
TABLES = (
    "table-1-sets",
    "table-1-blades",
    "table-1-identified",
    "figure-6-identification",
    "figure-6-failure-speeds",
    "figure-7-errors",
    "rotor-drag-by-angle",
    "rotor-drag-sources",
    "rotor-drag-plate",
    "rotor-drag-in-flight",
    "times",
)
FILES = file_names(FIGURES, TABLES)

POINT = (6000.0 * RPM, 10.0, np.radians(60.0))
"""Operating point of the timed call: [rad/s], [m/s], [rad]."""

REPEATS = 21
BATCH = 256


class Times(NamedTuple):
    """Computation times [s], which depend on the machine and differ from run to run."""

    one_point: float  # median over calls with one operating point
    per_point: float  # median over calls with a batch, divided by its size
    level: float  # identification from 20 level flights
    tunnel: float  # identification from the tunnel data
    machine: str
    cores: int


class Numbers(NamedTuple):
    """All results of the page; the functions that compute them describe them."""

    flown: dict[str, level_circles.SetFlown]
    tunnel: tunnel.Tunnel
    drag: rotor_drag.RotorDrag
    times: Times


def compute() -> Numbers:
    """Compute all numbers."""
    flown = {name: level_circles.fly(name) for name in paper.FLOWN}
    tested = tunnel.compute()
    drag = rotor_drag.compute(tested.compared[OBLIQUE])
    times = measured_times(flown["paper-soft"].twin.fitted, tested.fits.axial.fitted)
    return Numbers(flown, tested, drag, times)


def measured_times(level: Fitted, tunnel: Fitted) -> Times:
    """Time load calls, and repeat these identifications one at a time to time them."""
    rotor = Rotor(Model(paper.blade(paper.TUNNEL_PROPELLER), parameter_set("paper-apc")))
    batch = [np.full(BATCH, value) for value in POINT]
    again = [fit(one.rows, one.choice, one.settings).seconds for one in (level, tunnel)]
    return Times(
        one_point=_median(lambda: rotor.loads(*POINT)),
        per_point=_median(lambda: rotor.loads(*batch)) / BATCH,
        level=again[0],
        tunnel=again[1],
        machine=f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        cores=os.cpu_count() or 1,
    )


def _median(call: Callable[[], object]) -> float:
    call()
    seconds = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - begin)
    return statistics.median(seconds)


def pages(numbers: Numbers) -> dict[str, str | bytes]:
    """Return all files by name: the page, the CSV files and the SVG files."""
    flown, tested, drag = numbers.flown, numbers.tunnel, numbers.drag
    found, lines = tested.compared, tested.axial_curves

    def largest(share: str, data: str, label: str, *loads: str) -> float:
        """Return the largest ``share`` [%] of the loads among the models with this label part."""
        return 100.0 * max(
            getattr(e, share)
            for e in tested.errors
            if e.data_set == data and label in e.model and e.load in loads
        )

    figures = {
        "figure-6-level-circles": level_circles.loads_figure(flown),
        "figure-6-hover-failure": level_circles.cases_figure(flown),
        "figure-7-axial": tunnel.axial_figure(found[AXIAL], lines),
        "figure-7-oblique": tunnel.oblique_figure(found[OBLIQUE], tested.oblique_curves),
        "figure-7-8x4.5mr": tunnel.multirotor_figure(found[MULTIROTOR], tested.thrust_curves),
        "camber": tunnel.camber_figure(found[AXIAL], lines),
        "rotor-drag": rotor_drag.small_figure(drag.small_incidence),
    }
    sheets = {
        **table_1.sheets(tested.fits, flown),
        **level_circles.sheets(flown),
        **tunnel.sheets(found, tested.errors),
        "camber": tunnel.camber_sheet(found[AXIAL], lines),
        **rotor_drag.sheets(drag),
        "times": _times_sheet(numbers.times),
    }
    return report_files(
        "page.html.j2",
        figures,
        sheets,
        folder=Path(__file__).parent,
        numbers=numbers,
        paper=paper,
        circles=level_circles,
        tunnel=tunnel,
        drag=rotor_drag,
        table_1=table_1,
        **level_circles.summary(flown),
        oblique_rpm=tunnel.OBLIQUE_OMEGA / RPM,
        error_tables={
            f"{title}, {found[name].data.omega.size} points": tunnel.error_rows(
                [e for e in tested.errors if e.data_set == name]
            )
            for name, title in tunnel.DATA_SETS.items()
        },
        worst=lambda *wanted: largest("worst_share", *wanted),
        typical=lambda *wanted: largest("rms_share", *wanted),
        camber=[tunnel.rms_errors(found[AXIAL], curve) for curve in lines.values()],
        zero_lift=[
            np.degrees(one.law.zero_lift_angle) for one in (tested.fits.axial, tested.fits.oblique)
        ],
        incidence=np.degrees(rotor_drag.INCIDENCE),
        seconds=_seconds,
        data={
            **{title: measurement(name) for name, title in tunnel.DATA_SETS.items()},
            "2019 campaign, oblique (its blade-element model)": measurement(OTHER_FORM),
        },
        software={"NumPy": np.__version__},
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
