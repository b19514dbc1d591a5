"""Table I: the parameter sets, the blades, and what identification gives."""

from __future__ import annotations

import numpy as np

from propmap.catalogue.lookup import propeller
from propmap.fit.fitted import Fitted
from propmap.fit.parameters import PAPER_FOUR
from propmap.fit.residuals import rms
from propmap.model.airfoil import parameter_set
from propmap.model.propeller import Propeller
from propmap.papers.gill_dandrea_2017.blades import TUNNEL_PROPELLER, blade
from propmap.papers.gill_dandrea_2017.level_circles import BLADE, FORCE_ERROR
from propmap.papers.gill_dandrea_2017.numbers import Numbers
from propmap.papers.gill_dandrea_2017.paper import RADIUS, TABLE_1
from propmap.report.page import Section, Table, Text, number
from propmap.report.part import Part
from propmap.report.sheet import csv_of_rows

ANGLES = ("alpha_0", "zero_lift_angle")
PARAMETERS = (*PAPER_FOUR, "zero_lift_angle")
SYMBOLS = {
    "c_l1": ("c_l1", "1/rad"),
    "c_l2": ("c_l2", "-"),
    "c_d": ("c_d", "-"),
    "alpha_0": ("alpha_0", "deg"),
    "zero_lift_angle": ("zero-lift angle", "deg"),
}
HEADS = ("c_l1_per_rad", "c_l2", "c_d", "alpha_0_deg", "zero_lift_angle_deg")


def table_1(numbers: Numbers) -> Part:
    """Three tables: as printed, the blades, and identified here."""
    printed, sets = _printed()
    blades, shapes = _blades()
    identified, found = _identified(numbers)
    section = Section(
        "table-1",
        "Table I: parameter sets",
        (
            Text(
                "The paper gives one set of four section parameters per propeller, each found by "
                "identification. They are bundled with propmap as printed."
            ),
            printed,
            Text(
                "The paper's blades are not at hand. The tunnel propeller is the APC 8x6 thin "
                "electric: its largest chord and twist are those of Table I's envelope. For the "
                "two flown propellers the blade of another 8x4.5 stands in, scaled to 10 cm."
            ),
            blades,
            Text(
                "Identification on data that anyone can get. The tunnel fits use thrust and "
                "torque; the flights are simulated with the printed set as the truth and an "
                f"unknown vertical force of {100 * FORCE_ERROR:.0f} % of the weight in each."
            ),
            identified,
        ),
    )
    files = {
        "table-1-sets.csv": csv_of_rows(
            ("set", *HEADS[:4], "radius_m", "blades"), [tuple(row) for row in sets]
        ),
        "table-1-blades.csv": shapes,
        "table-1-identified.csv": found,
    }
    return Part(section, files)


def _printed() -> tuple[Table, list[tuple[object, ...]]]:
    rows, plain = [], []
    for name, title in TABLE_1.items():
        law = parameter_set(name)
        values = [_shown(p, getattr(law, p)) for p in PAPER_FOUR]
        rows.append((title, name, *(number(v) for v in values), f"{100 * RADIUS:.0f}", "2"))
        plain.append((name, *values, RADIUS, 2))
    columns = [("propeller", ""), ("set in propmap", "")]
    columns += [SYMBOLS[p] for p in PAPER_FOUR] + [("radius", "cm"), ("blades", "-")]
    return Table("As printed in the paper.", tuple(columns), tuple(rows)), plain


def _blades() -> tuple[Table, str]:
    used = (
        (propeller(TUNNEL_PROPELLER), "the tunnel's APC 8x6"),
        (blade(BLADE, RADIUS), "both flown propellers"),
    )
    rows = [((b.name, stands), _shape(b)) for b, stands in used]
    columns = (
        ("blade", ""),
        ("used for", ""),
        ("radius", "mm"),
        ("chord, largest", "mm"),
        ("chord at 0.75 R", "mm"),
        ("twist, largest", "deg"),
        ("twist at 0.75 R", "deg"),
        ("twist at the tip", "deg"),
        ("solidity", "-"),
    )
    cells = tuple((*names, *(number(v) for v in values)) for names, values in rows)
    heads = (
        "blade", "used_for", "radius_mm", "largest_chord_mm", "chord_at_075R_mm",
        "largest_twist_deg", "twist_at_075R_deg", "twist_at_tip_deg", "solidity",
    )  # fmt: skip
    text = csv_of_rows(heads, [(*names, *values) for names, values in rows])
    note = "Geometry: APC Propellers, performance data files, September 2022."
    return Table("Blades used here, two each.", columns, cells, note), text


def _shape(b: Propeller) -> list[float]:
    at = 0.75 * b.radius
    chord, twist = (float(np.interp(at, b.station, v)) for v in (b.chord, b.twist))
    area = b.blades * float(np.trapezoid(b.chord, b.station))
    return [
        1e3 * b.radius,
        1e3 * float(b.chord.max()),
        1e3 * chord,
        float(np.degrees(b.twist.max())),
        float(np.degrees(twist)),
        float(np.degrees(b.twist[-1])),
        area / (np.pi * b.radius**2),
    ]


def _identified(numbers: Numbers) -> tuple[Table, str]:
    fits = numbers.fits
    cases: list[tuple[str, str, Fitted]] = [
        (one.label, one.data, one.fitted) for one in (fits.axial_four, fits.axial, fits.oblique)
    ]
    for name, flown in numbers.flown.items():
        title = TABLE_1[name].split(":")[0]
        cases.append((f"{title}, level flights", "simulated flights", flown.twin.fitted))
    rows, plain = [], []
    for label, data, fitted in cases:
        cells: list[str] = [label, str(len(set(fitted.rows.point.tolist())))]
        for k, parameter in enumerate(PARAMETERS):
            if parameter not in fitted.choice.free:
                cells.append("0, held" if parameter == "zero_lift_angle" else "held")
                continue
            i = fitted.choice.free.index(parameter)
            sure = fitted.uncertainty
            low, value, high = (
                _shown(parameter, float(v[i])) for v in (sure.low, fitted.x, sure.high)
            )
            if sure.identified[i]:
                cells.append(f"{number(value)} ± {number(0.5 * (high - low), 2)}")
            else:
                cells.append(f"{number(round(value, 4))}*")
            plain.append((label, data, HEADS[k], value, low, high, sure.verdicts[i]))
        share = rms(fitted.minimum.residual)
        cells.append(number(100.0 * share))
        rows.append(tuple(cells))
    columns = [("fitted", ""), ("points", "-")]
    columns += [SYMBOLS[p] for p in PARAMETERS] + [("error left", "%")]
    note = (
        "± is half the 95 % interval. *: the data do not determine this parameter by itself; the "
        "CSV has the intervals and the reason. Error left: rms residual, in the tunnel as a "
        "share of the rms measured coefficient, in flight of the weight."
    )
    text = csv_of_rows(("fit", "data", "parameter", "value", "low_95", "high_95", "verdict"), plain)
    return Table("Identified by this command.", tuple(columns), tuple(rows), note), text


def _shown(parameter: str, value: float) -> float:
    return float(np.degrees(value)) if parameter in ANGLES else value
