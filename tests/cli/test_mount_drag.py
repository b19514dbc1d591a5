"""What a motor would add is told where rotor drag is; a factor on the drag is deprecated."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.model.airfoil import parameter_set

from .conftest import BETA, POINT, ROTOR, RPM, SPEED, Run

MOTOR = 0.028 * 0.030
"""[m^2], of 28 x 30 mm below 8 inches."""


def rise(rotor: propmap.Rotor, speed: float, beta: float) -> float:
    """Share of the rotor drag by the motor [-], written out."""
    found = rotor.loads(RPM * np.pi / 30.0, speed, np.radians(beta))
    across, along = speed * np.sin(np.radians(beta)), speed * np.cos(np.radians(beta))
    air = np.hypot(across, along + found.mean_inflow)
    return float(0.5 * 1.225 * MOTOR * across * air / found.drag)


def test_predict_tells_what_a_motor_would_add(run: Run, rotor: propmap.Rotor) -> None:
    text = " ".join(run("predict", *ROTOR, *POINT).out.split())
    share = rise(rotor, SPEED, BETA)
    assert share > 0.2
    told = f"a motor of 28 x 30 mm in the slipstream would raise it by {100.0 * share:.0f} %"
    assert told in text and "mount-drag" in text and "mount_area" in text


def test_the_correction_adds_it(run: Run, rotor: propmap.Rotor) -> None:
    asked = ["predict", *ROTOR, *POINT, "--format", "json"]
    bare, mounted = (
        json.loads(run(*asked, *more).out) for more in ([], ["--correction", "mount-drag"])
    )
    raised = mounted.pop("drag_N") / bare.pop("drag_N")
    assert raised == pytest.approx(1.0 + rise(rotor, SPEED, BETA), rel=1e-6)
    assert mounted == bare
    assert "motor" not in run("predict", *ROTOR, *POINT, "--correction", "mount-drag").out


def test_several_points_have_a_range_and_axial_ones_none(
    run: Run, rotor: propmap.Rotor, tmp_path: Path
) -> None:
    path = tmp_path / "points.csv"
    path.write_text("rpm,speed_mps,beta_deg\n4000,14,80\n4000,14.5,90\n4000,14,0\n")
    text = run("predict", *ROTOR, "--points", path).out
    low, high = sorted(100.0 * rise(rotor, *point) for point in ((14.0, 80.0), (14.5, 90.0)))
    assert f"by {low:.0f} to {high:.0f} %" in " ".join(text.split())
    path.write_text("rpm,speed_mps,beta_deg\n4000,14,0\n4000,0,80\n")
    assert "motor" not in run("predict", *ROTOR, "--points", path).out


def test_a_drag_factor_in_a_file_is_deprecated_in_one_line(run: Run, tmp_path: Path) -> None:
    text = parameter_set("paper-apc").to_toml()
    path = tmp_path / "law.toml"
    path.write_text(re.sub(r"drag_factor = 1\.0", "drag_factor = 2.0", text))
    asked = ["predict", "apc-8x6e", "--airfoil", path, *POINT, "--format", "json"]
    done = run(*asked)
    assert done.code == 0 and done.err.count("\n") == 1
    assert done.err.startswith("propmap: warning: drag_factor is deprecated: ")
    assert "mount-drag" in done.err and "mount_area" in done.err
    # It works as before.
    path.write_text(text)
    once = run(*asked)
    assert once.err == ""
    drags = [json.loads(one.out)["drag_N"] for one in (done, once)]
    assert drags[0] == pytest.approx(2.0 * drags[1], rel=1e-12)


@pytest.mark.parametrize("given", [["--free", "c_l1,drag_factor"], ["--fix", "drag_factor=1.5"]])
def test_and_in_a_fit(run: Run, given: list[str], tunnel_csv: Path) -> None:
    # Refused only after the choice has been read, so that nothing is computed.
    fit = ["fit", "tunnel", "apc-8x6e", tunnel_csv, "--loads", "drag", "-o", "x.toml"]
    done = run(*fit, *given)
    assert done.code == 2 and done.err.count("drag_factor is deprecated") == 1
