"""`propmap report`: a page on a fit or a table, its files, and one-line errors."""

from __future__ import annotations

import base64
import csv
import io
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.fit.comparison import INSIDE
from propmap.model.airfoil import parameter_set
from propmap.report.html import PAGE, REPORT_FILES
from propmap.table import LoadTable

from .conftest import Run
from .fit_inputs import fit_record
from .invented_tables import certificate, invented, without_figures

pytestmark = pytest.mark.usefixtures("pictures_as_they_fall")


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def page_of(folder: Path) -> str:
    """Return the page without its pictures, which must all be files of the folder."""
    html = (folder / PAGE).read_text(encoding="utf-8")
    inside = {base64.b64decode(t) for t in re.findall(r"svg\+xml;base64,([^\"]+)\"", html)}
    assert inside == {path.read_bytes() for path in folder.glob("*.svg")}
    assert not [a for a in re.findall(r'(?:src|href)="([^"]*)"', html) if a.startswith("http")]
    text = re.sub(r"base64,[^\"]+", "", html).replace("\N{NO-BREAK SPACE}", " ")
    assert "nan" not in re.findall(r"\w+", text.lower())
    # A CSV goes with every figure.
    assert {p.stem for p in folder.glob("*.svg")} <= {p.stem for p in folder.glob("*.csv")}
    assert {p.name for p in folder.iterdir()} <= REPORT_FILES
    return text


@pytest.mark.slow
def test_a_tunnel_fit(run: Run, tmp_path: Path, tunnel_fit: Path, tunnel_csv: Path) -> None:
    folder = tmp_path / "out"
    done = run("report", tunnel_fit, "-o", "out", "--data", tunnel_csv)
    assert (done.code, done.err) == (0, "") and done.out.startswith(f"wrote out/{PAGE} and ")
    text, told = page_of(folder).replace("&#39;", "'"), fit_record(tunnel_fit)
    assert "no cross-validation" in text.lower()
    assert "Fitted data, which do not test the fit independently: tunnel.csv" in text
    # The data contain no drag, so a typical installation is assumed.
    assert "The rotor drag is that of the installed rotor: 1.9 (+- 0.6) times" in text
    by_speed = told["residuals"]["thrust"]["by_speed"]
    thrust = [row for row in rows_of(folder / "fit-errors.csv") if row["load"] == "thrust"]
    assert [row["speed_band"] for row in thrust] == list(by_speed)
    for row in thrust:
        assert float(row["rms_in_unit"]) == pytest.approx(
            by_speed[row["speed_band"]]["rms"], rel=1e-4
        )
    # Its curves are those of the fitted rotor.
    rotor = propmap.Rotor(propmap.Model(propmap.propeller("apc-8x6e"), parameter_set(tunnel_fit)))
    rows = rows_of(folder / "fit-loads.csv")
    for row in rows[::7]:
        rpm, speed, beta = (float(row[n]) for n in ("rpm", "speed_mps", "beta_deg"))
        found = float(rotor.loads(rpm * np.pi / 30.0, speed, np.radians(beta)).thrust)
        assert float(row["thrust_N"]) == pytest.approx(found, rel=1e-4)
    # The data are axial: nothing edgewise is covered, and of axial flow not the fastest.
    assert {row["covered"] for row in rows if row["beta_deg"] == "90"} == {"0"}
    axial = [row["covered"] for row in rows if row["beta_deg"] == "0"]
    assert axial[0] == "1" and axial[-1] == "0" and axial == sorted(axial, reverse=True)
    # The data are checked as by `propmap check`.
    out = run("check", tunnel_fit, tunnel_csv, "--format", "csv").out
    wanted_rows = [r for r in csv.DictReader(io.StringIO(out)) if r["band"] not in ("all", INSIDE)]
    for row, want in zip(rows_of(folder / "fit-check.csv"), wanted_rows, strict=True):
        assert row["speed_band"] == want["band"]
        assert float(row["rms_in_unit"]) == pytest.approx(float(want["rms"]), rel=1e-4)
    # The folder is replaced.
    assert run("report", tunnel_fit, "-o", "out").code == 0
    assert not (folder / "fit-check.csv").exists()
    Path("new.csv").write_text(tunnel_csv.read_text() + "5000,6,0,1.5,0.03\n")
    assert run("report", tunnel_fit, "-o", "out", "--data", "new.csv").code == 0
    assert "which test the fit: new.csv" in page_of(folder)


def certified(**changed: object) -> LoadTable:
    """The invented table with a certificate, some cells marked."""
    content = invented().content
    cells = content.cells.copy()
    cells[:, -1] = 1
    cells[1:3, 2:4] = 2
    told = {**certificate(unresolved_cells=4), "holds": True, **changed}
    return LoadTable(replace(content, cells=cells, info={**content.info, "certificate": told}))


def test_a_table(run: Run, tmp_path: Path) -> None:
    table = certified()
    table.save("map.npz")
    done = run("report", "map.npz", "-o", "out")
    assert (done.code, done.err) == (0, "")
    text = page_of(tmp_path / "out")
    assert "Accuracy against the model: certified" in text
    assert "at most 0.21 % of the static loads" in text and "errors reach 3.1 %" in text
    assert "Accuracy against measurements: not in this file" in text
    assert "search for the largest errors used 26000 more points" in text
    for row in rows_of(tmp_path / "out" / "table-certificate.csv"):
        place = [float(row[name]) for name in ("at_rpm", "at_speed_mps", "at_beta_deg")]
        assert place == pytest.approx([6000.0, 7.25, 45.0])
    cells = rows_of(tmp_path / "out" / "table-cells.csv")
    statuses = [row["status"] for row in cells]
    assert statuses.count("unresolved") == 4
    assert statuses.count("vortex_ring") == table.content.advance.size - 1
    for row in rows_of(tmp_path / "out" / "table-loads.csv")[::50]:
        omega, speed, beta = (float(row[n]) for n in ("rpm", "speed_mps", "beta_deg"))
        found = table.loads(omega * np.pi / 30.0, speed, np.radians(beta))
        assert float(row["thrust_N"]) == pytest.approx(found.thrust, rel=1e-4, abs=1e-6)
        assert row["status"] == found.status


def test_other_certificates(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """None, and one that does not hold."""
    without_figures(monkeypatch)
    for table, says in (
        (invented(), "Accuracy against the model: unknown"),
        (certified(holds=False), "Accuracy against the model: outside the tolerance."),
    ):
        table.save("map.npz")
        assert run("report", "map.npz", "-o", "out").code == 0
        assert says in page_of(tmp_path / "out")
