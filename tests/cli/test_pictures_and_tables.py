"""Pictures by `propmap plot`, and tables in narrow windows."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from propmap.cli.output import WideGrid, digits, percent
from propmap.fit.tunnel import TunnelData
from propmap.report.pictures import along

from .conftest import POINT, ROTOR, Run

pytestmark = pytest.mark.usefixtures("pictures_as_they_fall")


def test_planform(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "blade.pdf"
    done = run("plot", "planform", "uiuc-apce-9x6", "-o", path)
    assert done.code == 0 and done.err.endswith(f"wrote {path}\n")
    assert path.read_bytes().startswith(b"%PDF")
    assert list(tmp_path.iterdir()) == [path]


def test_a_home_that_cannot_be_written_is_not_mentioned(tmp_path: Path) -> None:
    others = {k: v for k, v in os.environ.items() if k not in ("MPLCONFIGDIR", "XDG_CONFIG_HOME")}
    done = subprocess.run(
        [sys.executable, "-m", "propmap", "plot", "planform", "uiuc-apce-9x6", "-o", "blade.svg"],
        cwd=tmp_path, env=others | {"HOME": os.devnull}, capture_output=True, text=True,
    )  # fmt: skip
    assert (done.returncode, done.stderr.splitlines()) == (0, ["wrote blade.svg"])


def test_map_with_measured_points(run: Run, tmp_path: Path) -> None:
    measured = tmp_path / "tunnel.csv"
    measured.write_text("rpm,speed_mps,beta_deg,thrust_N,drag_N\n4010,14,80,1.3,\n4000,15,90,1,1\n")
    path = tmp_path / "map.svg"
    ranges = ["--rpm", "4000", "--speed", "14:16:3", "--beta", "80,90"]
    done = run("plot", "map", *ROTOR, *ranges, "--measured", measured, "-o", path)
    assert done.code == 0, done.err
    text = path.read_text()
    for label in ("thrust T [N]", "rotor drag D [N]", "torque Q [N m]", "V [m/s]", "hover model"):
        assert label in text
    assert "tunnel" in text


def test_disk(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "disk.svg"
    done = run("plot", "disk", *ROTOR, *POINT, "-o", path)
    assert done.code == 0, done.err
    text = path.read_text()
    for label in ("flight", "rotation", "reverse flow", "stalled", "advancing"):
        assert label in text


def test_measured_points_lie_along_their_angle() -> None:
    speed, beta = np.array([4.0, 0.0, 2.0, 3.0]), np.radians([90.0, 0.0, 90.4, 60.0])
    points = TunnelData("", np.ones(4), speed, beta)
    quarter = 0.5 * np.pi
    assert along(points, quarter, at_rest=False).tolist() == [2, 0]
    assert along(points, quarter, at_rest=True).tolist() == [1, 2, 0]


HEADS = "<name|P shaft [W]|P electric [W]|throttle [%]|<status"
ROWS = [("uiuc-apcsf-11x4.7", "201.9", "263.2", "32.5", "ok"), ("b", "1", "2", "3", "rpm_limit")]
GRID = WideGrid(HEADS, ROWS, "", "caption", ("throttle [%]", "P shaft [W]"))


def shown(width: int) -> str:
    text = io.StringIO()
    Console(file=text, width=width, highlight=False, markup=False).print(GRID)
    return text.getvalue()


@pytest.mark.parametrize(
    ("width", "hidden"), [(120, ""), (62, "throttle [%]"), (48, "throttle [%], P shaft [W]")]
)
def test_columns_are_hidden_in_their_order_and_no_cell_is_cut(width: int, hidden: str) -> None:
    text = shown(width)
    assert max(map(len, text.splitlines())) <= width
    assert "…" not in text and "uiuc-apcsf-11x4.7" in text and "rpm_limit" in text
    told = text.partition("hidden")[2]
    for name, cell in (("throttle [%]", "32.5"), ("P shaft [W]", "201.9")):
        assert (name in told) == (name in hidden) == (cell not in text)
    assert "263.2" in text


def test_cells_without_a_number_are_a_dash() -> None:
    """The error of a load measured as zero has no relative size."""
    assert [percent(value, 2) for value in (np.nan, 0.1234)] == ["-", "12.34 %"]
    assert [digits(value) for value in (np.nan, -0.0, 1.23456)] == ["-", "0", "1.235"]
