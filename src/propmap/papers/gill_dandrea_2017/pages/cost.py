"""Cost: one map call, one identification."""

from __future__ import annotations

from propmap.papers.gill_dandrea_2017.cost import Times
from propmap.papers.gill_dandrea_2017.paper import COST
from propmap.report.page import Section, Table, Text, number
from propmap.report.part import Part
from propmap.report.sheet import csv_of_rows

HOUR = 3600.0


def cost(times: Times) -> Part:
    """Times of this run beside the paper's."""
    low, high = (t / HOUR for t in COST.identification)
    paper = f"{low:.0f} to {high:.0f} h"
    rows = (
        ("one operating point, one call", _seconds(times.one_point), f"{COST.one_point:.0f} s"),
        ("one of 256 operating points in a call", _seconds(times.per_point), ""),
        ("identification, 20 level flights of four rotors", _seconds(times.level), paper),
        ("identification, 107 tunnel rows", _seconds(times.tunnel), ""),
        ("the same, compilation included", _seconds(times.tunnel_first), ""),
    )
    table = Table(
        "Times of this run; all other numbers of this page repeat exactly, these do not.",
        (("what", ""), ("here", ""), ("paper", "")),
        rows,
        f"{times.machine}, {times.cores} cores. Compiled programs are kept between runs, so that "
        "a second run is faster. Identifications include their several starts.",
    )
    text = (
        "A call costs about "
        f"{number(COST.one_point / times.one_point, 2)} times less than in the paper, an "
        f"identification {number(COST.identification[0] / times.level, 2)} times less or better; "
        "part of that is the machine, a decade younger."
    )
    section = Section("times", "Cost: times, which differ from run to run", (Text(text), table))
    sheet = csv_of_rows(
        ("what", "time_s", "paper_from_s", "paper_to_s"),
        (
            ("one_point", times.one_point, COST.one_point, COST.one_point),
            ("per_point_of_256", times.per_point, None, None),
            ("level_flight_identification", times.level, *COST.identification),
            ("tunnel_identification", times.tunnel, None, None),
            ("tunnel_identification_first", times.tunnel_first, None, None),
        ),
    )
    return Part(section, {"times.csv": sheet})


def _seconds(value: float) -> str:
    for size, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if value >= size:
            return f"{number(value / size, 2)} {unit}"
    return f"{number(value * 1e9, 2)} ns"
