"""Run the command of `make reproduce`, and write its main tables as Markdown.

Usage: python -m tools.docs_reproduce FOLDER

The page and its files go to FOLDER/site/reproduce.  The documentation build copies them next to
its own pages.  The tables that pages include go to FOLDER.
"""

from __future__ import annotations

import csv
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from papers.gill_dandrea_2017.rotor_drag import DATA as FORMS
from papers.gill_dandrea_2017.rotor_drag import MODELS as INFLOWS
from propmap.io.csv import replacing

ROOT = Path(__file__).resolve().parent.parent
Rows = list[dict[str, str]]

SETS = {"paper-soft": "soft", "paper-stiff": "stiff"}
DATA = {
    "uiuc-8x6e": "8x6E, axial (UIUC)",
    "gill-dandrea-2019-8x6e": "8x6E, oblique (2019 polynomials)",
    "davoudi-8x4.5mr-thrust": "8x4.5MR, thrust",
}
LOADS = {
    "thrust": "thrust",
    "torque": "torque",
    "drag": "rotor drag",
    "roll_moment": "roll moment",
    "pitch_moment": "pitch moment",
}


def folder_of_page(folder: Path) -> Path:
    """Return the folder of the command's page."""
    return folder / "site" / "reproduce"


def start(folder: Path) -> subprocess.Popen[bytes]:
    """Start the command; it takes about two minutes."""
    site = folder_of_page(folder)
    site.parent.mkdir(parents=True, exist_ok=True)
    command = [sys.executable, "-m", "papers.gill_dandrea_2017", "-o", str(site.resolve())]
    return subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def finish(process: subprocess.Popen[bytes], folder: Path) -> None:
    """Wait for the command, and write the tables from its files."""
    _, errors_said = process.communicate()
    if process.returncode:
        raise RuntimeError(f"make reproduce failed: {errors_said.decode(errors='replace')}")
    site = folder_of_page(folder)
    tables = {
        "reproduce-identified": identified(read(site / "table-1-identified.csv")),
        "reproduce-failures": failures(read(site / "figure-6-failure-speeds.csv")),
        "reproduce-errors": errors(read(site / "figure-7-errors.csv")),
        "reproduce-rotor-drag": rotor_drag(read(site / "rotor-drag-by-angle.csv")),
        "reproduce-drag-sources": drag_sources(read(site / "rotor-drag-sources.csv")),
        "reproduce-drag-plate": drag_plate(read(site / "rotor-drag-plate.csv")),
    }
    for name, text in tables.items():
        with replacing(folder / f"{name}.md") as part:
            part.write_text(text + "\n", encoding="utf-8")


def read(path: Path) -> Rows:
    """Return the rows of one CSV file of the command."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def identified(found: Rows) -> str:
    """Tabulate the identified values with their 95 % intervals, one row per fit."""
    parameters = {
        "c_l1_per_rad": "c_l1 [1/rad]",
        "c_l2": "c_l2",
        "c_d": "c_d",
        "alpha_0_deg": "alpha_0 [deg]",
        "zero_lift_angle_deg": "zero-lift angle [deg]",
    }
    rows = []
    for fit in dict.fromkeys(row["fit"] for row in found):
        mine = {row["parameter"]: row for row in found if row["fit"] == fit}
        cells = [_interval(mine[name]) if name in mine else "fixed" for name in parameters]
        rows.append([fit, *cells])
    return _table(["fit", *parameters.values()], rows)


def failures(found: Rows) -> str:
    """Tabulate the failures of the hover model, one row per propeller, mass and frame drag."""
    heads = [
        "propeller", "mass [kg]", "frame drag area [m²]", "error of 5 % [m/s]",
        "error of 10 % [m/s]", "change of sign [m/s]", "failure in the paper [m/s]",
    ]  # fmt: skip
    names = (
        "mass_kg", "drag_area_m2", "off_by_5_percent_mps", "off_by_10_percent_mps",
        "sign_changes_mps", "paper_fails_mps",
    )  # fmt: skip
    rows = [[SETS[row["set"]], *(_number(row[name], 3) for name in names)] for row in found]
    return _table(heads, rows)


def errors(found: Rows) -> str:
    """Tabulate the errors, one row per data set, load and model."""
    rows = [
        [
            DATA[row["data_set"]],
            LOADS[row["load"]],
            row["model"],
            _percent(row["rms_over_rms_measured"]),
            _percent(row["worst_over_largest_measured"]),
        ]
        for row in found
    ]
    for below, above in reversed(list(zip(rows[1:], [list(row) for row in rows], strict=False))):
        if below[:2] == above[:2]:
            below[1] = ""
        if below[0] == above[0]:
            below[0] = ""
    return _table(["data", "load", "model", "rms error", "worst error"], rows)


def rotor_drag(found: Rows) -> str:
    """Tabulate the drag of 2019 relative to the theory, one row per angle."""
    names = (
        "beta_deg", "polynomials_over_theory", "lowest", "highest",
        "polynomials_over_recommended", "model_over_theory",
    )  # fmt: skip
    heads = [
        "β [deg]", "polynomials / theory, rms", "lowest", "highest",
        "polynomials / recommended model, rms", "campaign's model / theory, rms",
    ]  # fmt: skip
    return _table(heads, [[_number(row[name], 3) for name in names] for row in found])


def drag_sources(found: Rows) -> str:
    """Tabulate the nondimensional drag, one row per source."""
    names = ("incidence_H_over_mu", "edgewise_H_over_mu", "edgewise_H_over_T_mu")
    theory = float(found[0][names[0]])
    rows = [
        [
            row["source"],
            *(_number(row[name], 3) for name in names),
            _number(str(float(row[names[0]]) / theory), 3),
        ]
        for row in found
    ]
    heads = ["source", "H'/μ, 15°", "H'/μ, edgewise", "H/(T μ), edgewise", "15°, over theory"]
    return _table(heads, rows)


def drag_plate(found: Rows) -> str:
    """Tabulate the fits of the excess drag with their rms errors in brackets, one row per fit."""
    rows = [
        [
            INFLOWS[row["model"]],
            FORMS[row["data"]],
            _number(row["slipstream_factor"], 2),
            f"{_number(row['factor_alone'], 3)} ({_percent(row['factor_rms_over_rms_measured'])})",
            f"{_area(row['plate_alone_m2'])} ({_percent(row['plate_rms_over_rms_measured'])})",
            f"{_number(row['both_factor'], 3)}, {_area(row['both_plate_m2'])} "
            f"({_percent(row['both_rms_over_rms_measured'])})",
        ]
        for row in found
    ]
    heads = ["theory", "drag of", "k", "factor alone", "plate alone [cm²]", "factor + plate [cm²]"]
    return _table(heads, rows)


def _area(square_metres: str) -> str:
    return f"{1e4 * float(square_metres):.0f}"


def _interval(row: dict[str, str]) -> str:
    value, low, high = (_number(row[name], 3) for name in ("value", "low_95", "high_95"))
    mark = "" if row["verdict"].startswith("identified") else "\\*"
    return f"{value}{mark} ({low} to {high})"


def _number(text: str, digits: int) -> str:
    if not text:
        return "none"
    value = float(text)
    return f"{0.0 if abs(value) < 1e-4 else value:.{digits}g}".replace("-", "\N{MINUS SIGN}")


def _percent(text: str) -> str:
    share = 100.0 * float(text)
    return (f"{share:.0f}" if share >= 9.95 else f"{share:.2g}") + "\N{NO-BREAK SPACE}%"


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


if __name__ == "__main__":
    target = Path(sys.argv[1])
    finish(start(target), target)
