"""Files in units other than those they state; those of loads: ``tests/cases/test_slips.py``."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.cli.fit_flight import read_flights
from propmap.errors import InputError
from propmap.vehicle.files import read_vehicle

from .conftest import ROTOR, Outcome, Run, refused
from .fit_inputs import LEVEL, QUICK, VEHICLE

BLADE = propmap.propeller("apc-8x6e")
RADIUS, CHORD, TWIST = BLADE.station, BLADE.chord, np.degrees(BLADE.twist)
INCH = 0.0254
RPM = np.pi / 30.0
POINT = ("--airfoil", "paper-apc", "--rpm", 6000, "--speed", 5, "--beta", 60, "--format", "csv")


def blade_csv(
    radius: np.ndarray, chord: np.ndarray, twist: np.ndarray = TWIST, unit: str = "m"
) -> str:
    rows = zip(radius, chord, twist, strict=True)
    text = "".join(",".join(f"{v:.9g}" for v in row) + "\n" for row in rows)
    return f"# blades: 2\nradius_{unit},chord_{unit},twist_deg\n{text}"


def in_fractions(station: np.ndarray, chord: np.ndarray) -> str:
    names = f"# radius_m: {BLADE.radius}\nr_over_R,c_over_R"
    return blade_csv(station, chord).replace("radius_m,chord_m", names)


SHARE, WIDTH = RADIUS / BLADE.radius, CHORD / BLADE.radius
BLADES = {
    "fractions": (in_fractions(SHARE, WIDTH), ""),
    "chord in mm as m": (blade_csv(RADIUS, 1e3 * CHORD), "millimeters with a radius in meters"),
    "chord in percent": (in_fractions(SHARE, 100.0 * WIDTH), "percent of the radius"),
    "chord over the diameter": (in_fractions(SHARE, 0.5 * WIDTH), "fraction of the diameter"),
    "radius in percent": (in_fractions(100.0 * SHARE, WIDTH), "looks like percent"),
    "diameter as radius": (blade_csv(2.0 * RADIUS, CHORD), "the radius looks like a diameter"),
    "lengths in inches as mm": (
        blade_csv(RADIUS / INCH, CHORD / INCH, unit="mm"),
        "inches read as millimeters",
    ),
    "twist from the tip": (blade_csv(RADIUS, CHORD, TWIST[::-1]), "run from the tip to the root"),
    "twist from the axis": (blade_csv(RADIUS, CHORD, 90.0 - TWIST), "measured from the axis"),
    "twist with another sign": (blade_csv(RADIUS, CHORD, -TWIST), "looks like the wrong sign"),
    "twist in radians": (blade_csv(RADIUS, CHORD, np.radians(TWIST)), "looks like radians"),
    "twist in degrees": (
        blade_csv(RADIUS, CHORD).replace("twist_deg", "twist_rad"),
        "looks like degrees",
    ),
}


@pytest.mark.parametrize("case", BLADES)
def test_blades(run: Run, tmp_path: Path, case: str) -> None:
    text, cause = BLADES[case]
    (tmp_path / "blade.csv").write_text(text)
    result = run("predict", "blade.csv", *POINT)
    if not cause:
        assert (result.code, result.err) == (0, "")
        return
    # The first line is about the blade; operating points of a wrong radius may add an error.
    told = result.err.splitlines()[0]
    assert cause in told and told.startswith(("propmap: error: ", "note: "))


def test_blade_without_loads(run: Run) -> None:
    Path("blade.csv").write_text(BLADES["twist from the tip"][0])
    for command in ("props show blade.csv", "plot planform blade.csv -o a.svg"):
        result = run(*command.split())
        assert result.code == 0 and "run from the tip to the root" in result.err


ROWS = np.array([[5000.0, 4.0, 30.0], [6000.0, 8.0, 60.0], [7000.0, 10.0, 75.0]])
POINTS: dict[str, tuple[list[float], int, str]] = {
    "right": ([1.0, 1.0, 1.0], 0, ""),
    "rad/s": ([RPM, 1.0, 1.0], 0, "looks like rad/s"),
    "electrical": ([7.0, 1.0, 1.0], 2, "electrical rpm"),
    "km/h": ([1.0, 3.6 * 2.0, 1.0], 0, "km/h"),
    "radians": ([1.0, 1.0, np.pi / 180.0], 0, "beta is 1.309 deg; it looks like radians"),
}


@pytest.mark.parametrize("case", POINTS)
def test_points(run: Run, tmp_path: Path, case: str) -> None:
    factors, code, cause = POINTS[case]
    rows = "".join(",".join(f"{v:.6g}" for v in row) + "\n" for row in ROWS * factors)
    (tmp_path / "points.csv").write_text("rpm,speed_mps,beta_deg\n" + rows)
    result = run("predict", *ROTOR, "--points", "points.csv", "--format", "csv")
    assert result.code == code
    first, *others = result.err.splitlines() or [""]
    assert cause in first and bool(first) is bool(cause)
    assert all("multiple_roots" in other for other in others)


def test_air(run: Run) -> None:
    for option, value, cause in (
        ("--rho", 1225, "looks like g/m^3"),
        ("--mu", 1.81e-4, "looks like poise"),
        ("--altitude", 15000, ""),
    ):
        result = run("predict", "apc-8x6e", *POINT, option, value)
        assert result.code == 0 and cause in result.err and bool(result.err) is bool(cause)


@pytest.mark.usefixtures("brief")
def test_a_fit_refuses_errors_and_keeps_accepted_doubts(run: Run) -> None:
    def fitted_to_thrust(factor: float) -> Outcome:
        rows = (f"{rpm},0,0,{9e-8 * rpm**2 * factor}\n" for rpm in range(3000, 7000, 500))
        Path("tunnel.csv").write_text("rpm,speed_mps,beta_deg,thrust_N\n" + "".join(rows))
        asked = ("fit", "tunnel", "apc-8x6e", "tunnel.csv", *QUICK, "-o", "fit.toml")
        return run(*asked, "--accept")

    refused(fitted_to_thrust(1e3 / 9.80665), "tunnel.csv: C_T is ", "thrust looks like grams")
    assert not Path("fit.toml").exists()
    result = fitted_to_thrust(0.22481)
    assert result.code == 0 and "note: tunnel.csv: thrust is 0." in result.err
    assert "thrust looks like pounds" in Path("fit.toml").read_text()
    assert "thrust looks like pounds" in run("check", "fit.toml", "tunnel.csv").err


def test_level_table(tmp_path: Path) -> None:
    (tmp_path / "vehicle.toml").write_text(VEHICLE)
    vehicle, path = read_vehicle(tmp_path / "vehicle.toml"), tmp_path / "level.csv"
    path.write_text(LEVEL)
    assert read_flights([path], vehicle, "level", seconds=2.0, samples=100).remarks == ()
    path.write_text(re.sub(r",(5\d{3})", lambda found: f",{int(found[1]) * RPM:.3f}", LEVEL))
    with pytest.raises(InputError, match="rad/s") as caught:
        read_flights([path], vehicle, "level", seconds=2.0, samples=100)
    assert "revolutions per minute" in str(caught.value)
