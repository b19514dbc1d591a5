"""`make reproduce` writes one whole page and its numbers."""

from __future__ import annotations

import base64
import csv
import re
import subprocess
import sys
from pathlib import Path

import pytest

from papers.gill_dandrea_2017.__main__ import main
from papers.gill_dandrea_2017.page import FIGURES, FILES
from propmap.report.html import PAGE

ROOT = Path(__file__).parents[2]
SECTIONS = ("table-1", "figure-6", "figure-7", "camber", "rotor-drag", "times")


def test_other_folders_are_refused_before_any_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    for folder, message in (
        (tmp_path, "mine.txt"),
        (tmp_path / "mine.txt", "not a folder"),
        (tmp_path / "no" / "out", "there is no folder"),
    ):
        with pytest.raises(SystemExit) as ended:
            main(["-o", str(folder)])
        assert ended.value.code == 2 and message in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.slow
def test_the_page_and_its_numbers(tmp_path: Path) -> None:
    folder = tmp_path / "new"
    done = subprocess.run(
        [sys.executable, "-m", "papers.gill_dandrea_2017", "-o", str(folder)],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"wrote {folder / PAGE}")
    assert {p.name for p in tmp_path.iterdir()} == {"new"}
    assert {p.name for p in folder.iterdir()} == FILES
    _is_whole(folder)
    _says_what_was_found(folder)


def _is_whole(folder: Path) -> None:
    html = (folder / PAGE).read_text(encoding="utf-8")
    for name in SECTIONS:
        assert f'<section id="{name}">' in html and f'href="#{name}"' in html
    found = re.findall(r'src="data:image/svg\+xml;base64,([^"]+)"', html)
    files = {(folder / f"{name}.svg").read_bytes() for name in FIGURES}
    assert {base64.b64decode(text) for text in found} == files
    assert not [a for a in re.findall(r'(?:src|href)="([^"]*)"', html) if a.startswith("http")]
    assert "nan" not in re.sub(r"base64,[^\"]+", "", html).lower().split()


def _says_what_was_found(folder: Path) -> None:
    """The numbers themselves, from the CSVs alone."""

    def rows(name: str) -> list[dict[str, str]]:
        with (folder / name).open(newline="") as file:
            return list(csv.DictReader(file))

    worst = {
        (r["data_set"], r["load"], r["model"]): float(r["worst_over_largest_measured"])
        for r in rows("figure-7-errors.csv")
    }
    oblique, paper, ours = (
        "gill-dandrea-2019-8x6e", "with camber, 2019", "with camber, recommended inflow",
    )  # fmt: skip
    for load in ("thrust", "torque"):
        assert worst[oblique, load, paper] < 0.09 and worst[oblique, load, ours] < 0.09
    # The annulus average lets a rolling moment induce nothing.
    assert worst[oblique, "roll_moment", ours] < 0.09 < worst[oblique, "roll_moment", paper]
    assert worst[oblique, "pitch_moment", paper] == pytest.approx(1.0)
    assert worst[oblique, "thrust", "blade-element model of the campaign"] < 0.09
    assert (oblique, "pitch_moment", "blade-element model of the campaign") not in worst
    assert worst[oblique, "drag", "hover model"] == pytest.approx(1.0)
    for r in rows("figure-6-failure-speeds.csv"):
        assert float(r["off_by_5_percent_mps"]) < float(r["off_by_10_percent_mps"])
        # Without drag of the frame the hover model never predicts too much.
        assert r["sign_changes_mps"] == "" or float(r["drag_area_m2"]) > 0.0
    for r in rows("rotor-drag.csv"):
        if float(r["inflow_over_speed"]) < 0.1:
            low, high = float(r["fin_chord_line_N"]), float(r["fin_zero_lift_line_N"])
            assert 0.8 * low < float(r["theory_N"]) < 1.25 * high
