"""Files in units other than those they state: each is pointed out in words, with its cause."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.catalogue.lookup import measurement
from propmap.cli.fit_flight import read_flights
from propmap.errors import InputError
from propmap.fit.tunnel import tunnel_warnings
from propmap.model.plausibility import blade_warnings
from propmap.vehicle.files import read_vehicle

from .conftest import Run
from .fit_inputs import LEVEL, QUICK, UIUC, VEHICLE, picked, tunnel_table

BLADE = propmap.propeller("apc-8x6e")
RADIUS, CHORD, TWIST = BLADE.station, BLADE.chord, np.degrees(BLADE.twist)
INCH = 0.0254
RPM_PER_RADIAN = 60.0 / (2.0 * np.pi)
POINT = ("--airfoil", "paper-apc", "--rpm", 6000, "--speed", 5, "--beta", 60, "--format", "csv")


def blade_csv(header: str, *columns: np.ndarray, radius: float | None = None) -> str:
    stated = "" if radius is None else f"# radius_m: {radius}\n"
    rows = "\n".join(",".join(f"{v:.9g}" for v in row) for row in zip(*columns, strict=True))
    return f"# blades: 2\n{stated}{header}\n{rows}\n"


def in_fractions(station: np.ndarray, chord: np.ndarray) -> str:
    return blade_csv("r_over_R,c_over_R,twist_deg", station, chord, TWIST, radius=BLADE.radius)


SHARE, WIDTH = RADIUS / BLADE.radius, CHORD / BLADE.radius
GOOD_BLADES = {
    "metres": blade_csv("radius_m,chord_m,twist_deg", RADIUS, CHORD, TWIST),
    "millimetres": blade_csv("radius_mm,chord_mm,twist_deg", 1e3 * RADIUS, 1e3 * CHORD, TWIST),
    "inches": blade_csv("radius_in,chord_in,twist_deg", RADIUS / INCH, CHORD / INCH, TWIST),
    "radians": blade_csv("radius_m,chord_m,twist_rad", RADIUS, CHORD, np.radians(TWIST)),
    "fractions": in_fractions(SHARE, WIDTH),
}
BLADES = {
    "chord in mm as m": (
        blade_csv("radius_m,chord_m,twist_deg", RADIUS, 1e3 * CHORD, TWIST),
        "millimeters with a radius in meters",
    ),
    "chord in inches as m": (
        blade_csv("radius_m,chord_m,twist_deg", RADIUS, CHORD / INCH, TWIST),
        "inches with a radius in meters",
    ),
    "chord in inches as mm": (
        blade_csv("radius_mm,chord_mm,twist_deg", 1e3 * RADIUS, CHORD / INCH, TWIST),
        "inches read as millimeters",
    ),
    "chord in cm as mm": (
        blade_csv("radius_mm,chord_mm,twist_deg", 1e3 * RADIUS, 1e2 * CHORD, TWIST),
        "centimeters read as millimeters",
    ),
    "chord in m as inches": (
        blade_csv("radius_in,chord_in,twist_deg", RADIUS / INCH, CHORD, TWIST),
        "meters read as inches",
    ),
    "chord in mm as inches": (
        blade_csv("radius_in,chord_in,twist_deg", RADIUS / INCH, 1e3 * CHORD, TWIST),
        "millimeters with a radius in inches",
    ),
    "chord in per cent": (in_fractions(SHARE, 100.0 * WIDTH), "percent of the radius"),
    "chord over the diameter": (in_fractions(SHARE, 0.5 * WIDTH), "fraction of the diameter"),
    "radius in per cent": (in_fractions(100.0 * SHARE, WIDTH), "looks like percent"),
    "diameter as radius": (
        blade_csv("radius_m,chord_m,twist_deg", 2.0 * RADIUS, CHORD, TWIST),
        "the radius looks like a diameter",
    ),
    "lengths in mm as m": (
        blade_csv("radius_m,chord_m,twist_deg", 1e3 * RADIUS, 1e3 * CHORD, TWIST),
        "looks like millimeters",
    ),
    "lengths in cm as m": (
        blade_csv("radius_m,chord_m,twist_deg", 1e2 * RADIUS, 1e2 * CHORD, TWIST),
        "looks like centimeters",
    ),
    "lengths in inches as m": (
        blade_csv("radius_m,chord_m,twist_deg", RADIUS / INCH, CHORD / INCH, TWIST),
        "looks like inches",
    ),
    "lengths in inches as mm": (
        blade_csv("radius_mm,chord_mm,twist_deg", RADIUS / INCH, CHORD / INCH, TWIST),
        "looks like inches read as millimeters",
    ),
    "lengths in mm as inches": (
        blade_csv("radius_in,chord_in,twist_deg", 1e3 * RADIUS, 1e3 * CHORD, TWIST),
        "looks like millimeters read as inches",
    ),
    "lengths in m as mm": (
        blade_csv("radius_mm,chord_mm,twist_deg", RADIUS, CHORD, TWIST),
        "looks like meters read as millimeters",
    ),
    "twist from the tip": (
        blade_csv("radius_m,chord_m,twist_deg", RADIUS, CHORD, TWIST[::-1]),
        "run from the tip to the root",
    ),
    "twist from the axis": (
        blade_csv("radius_m,chord_m,twist_deg", RADIUS, CHORD, 90.0 - TWIST),
        "measured from the axis",
    ),
    "twist with another sign": (
        blade_csv("radius_m,chord_m,twist_deg", RADIUS, CHORD, -TWIST),
        "looks like the wrong sign",
    ),
    "twist in radians": (
        blade_csv("radius_m,chord_m,twist_deg", RADIUS, CHORD, np.radians(TWIST)),
        "looks like radians",
    ),
    "twist in degrees": (
        blade_csv("radius_m,chord_m,twist_rad", RADIUS, CHORD, TWIST),
        "looks like degrees",
    ),
}


@pytest.mark.parametrize("case", GOOD_BLADES)
def test_good_blades_are_passed(run: Run, tmp_path: Path, case: str) -> None:
    (tmp_path / "blade.csv").write_text(GOOD_BLADES[case])
    result = run("predict", "blade.csv", *POINT)
    assert (result.code, result.err) == (0, "")


@pytest.mark.parametrize("case", BLADES)
def test_blades(run: Run, tmp_path: Path, case: str) -> None:
    text, cause = BLADES[case]
    (tmp_path / "blade.csv").write_text(text)
    result = run("predict", "blade.csv", *POINT)
    # The first line is about the blade; operating points of a wrong radius may add an error.
    told = result.err.splitlines()[0]
    assert cause in told
    assert told.startswith(("propmap: error: ", "note: "))


def test_blade_without_loads(run: Run, tmp_path: Path) -> None:
    (tmp_path / "blade.csv").write_text(BLADES["twist from the tip"][0])
    for command in (
        ("props", "show", "blade.csv"),
        ("plot", "planform", "blade.csv", "-o", "a.svg"),
    ):
        result = run(*command)
        assert result.code == 0
        assert "run from the tip to the root" in result.err


ROWS = np.array([[5000.0, 4.0, 30.0], [6000.0, 8.0, 60.0], [7000.0, 10.0, 75.0]])


def points_csv(rpm: float = 1.0, speed: float = 1.0, beta: float = 1.0) -> str:
    rows = ROWS * [rpm, speed, beta]
    return "rpm,speed_mps,beta_deg\n" + "".join(
        ",".join(f"{v:.6g}" for v in r) + "\n" for r in rows
    )


POINTS: dict[str, tuple[str, int, str]] = {
    "rad/s": (points_csv(rpm=1.0 / RPM_PER_RADIAN), 0, "looks like rad/s"),
    "per second": (points_csv(rpm=1.0 / 60.0), 0, "looks like revolutions per second"),
    "converted twice": (points_csv(rpm=RPM_PER_RADIAN), 2, "converted from rad/s twice"),
    "electrical": (points_csv(rpm=7.0), 2, "electrical rpm"),
    "km/h": (points_csv(speed=3.6 * 2.0), 0, "km/h"),
    "radians": (
        points_csv(beta=np.pi / 180.0),
        0,
        "the largest beta is 1.309 deg; it looks like radians",
    ),
    "huge": (points_csv(rpm=1e9), 2, "propmap has no model above Mach 1"),
    "Mach 0.8": (points_csv(rpm=3.6), 0, "Mach 0.788"),
}


@pytest.mark.parametrize("case", POINTS)
def test_points(run: Run, tmp_path: Path, case: str) -> None:
    text, code, cause = POINTS[case]
    (tmp_path / "points.csv").write_text(text)
    result = run(
        "predict", "apc-8x6e", "--airfoil", "paper-apc", "--points", "points.csv", "--format", "csv"
    )
    assert result.code == code
    first, *others = result.err.splitlines()
    assert cause in first
    assert all("multiple_roots" in other for other in others)


def test_good_points_are_passed(run: Run, tmp_path: Path) -> None:
    (tmp_path / "points.csv").write_text(points_csv())
    result = run(
        "predict", "apc-8x6e", "--airfoil", "paper-apc", "--points", "points.csv", "--format", "csv"
    )
    assert (result.code, result.err) == (0, "")


AIRS = {
    "grams": (("--rho", 1225), "looks like g/m^3"),
    "grams per cubic centimetre": (("--rho", 0.001225), "looks like g/cm^3"),
    "slugs": (("--rho", 0.002377), "looks like slug/ft^3"),
    "pounds": (("--rho", 0.0765), "looks like lb/ft^3"),
    "micropascal": (("--mu", 18.1), "looks like microPa s"),
    "poise": (("--mu", 1.81e-4), "looks like poise"),
}


@pytest.mark.parametrize("case", AIRS)
def test_air(run: Run, case: str) -> None:
    options, cause = AIRS[case]
    result = run("predict", "apc-8x6e", *POINT, *options)
    assert result.code == 0
    assert cause in result.err


def test_density_of_the_standard_atmosphere_is_passed(run: Run) -> None:
    result = run("predict", "apc-8x6e", *POINT, "--altitude", 15000)
    assert (result.code, result.err) == (0, "")


TUNNEL = tunnel_table(picked())
AXIAL = tunnel_table(np.arange(UIUC.omega.size))
THRUST_ALONE = tunnel_table(picked(), ("thrust_N",))
NAMES = ("rpm", "speed_mps", "beta_deg", "thrust_N", "torque_Nm")


def scaled(text: str, **factors: float) -> str:
    """A table with some columns times a factor."""
    header, *rows = (line.split(",") for line in text.splitlines())
    out = [header]
    for row in rows:
        cells = zip(header, row, strict=True)
        out.append([repr(float(cell) * factors.get(name, 1.0)) for name, cell in cells])
    return "\n".join(",".join(row) for row in out) + "\n"


def turned(text: str, change: Callable[[float], float]) -> str:
    header, *rows = (line.split(",") for line in text.splitlines())
    place = header.index("beta_deg")
    for row in rows:
        row[place] = repr(float(change(float(row[place]))))
    return "\n".join(",".join(row) for row in [header, *rows]) + "\n"


def oblique() -> str:
    """The polynomials of Gill & D'Andrea 2019, axial, oblique and edgewise."""
    m = measurement("gill-dandrea-2019-8x6e")
    density = propmap.Air().density / m.air_density
    columns = [
        m.omega * RPM_PER_RADIAN,
        m.speed,
        np.degrees(m.beta),
        *(m.loads[name] * density for name in ("thrust", "drag", "torque")),
    ]
    rows = "\n".join(",".join(repr(float(v)) for v in row) for row in zip(*columns, strict=True))
    return f"rpm,speed_mps,beta_deg,thrust_N,drag_N,torque_Nm\n{rows}\n"


OBLIQUE = oblique()
DISK = "measured from the disk plane"
LOADS = {
    "thrust in grams": (scaled(TUNNEL, thrust_N=1e3 / 9.80665), "thrust looks like grams"),
    "thrust in kg": (scaled(TUNNEL, thrust_N=1.0 / 9.80665), "thrust looks like kilograms"),
    "thrust in mN": (scaled(TUNNEL, thrust_N=1e3), "thrust looks like millinewtons"),
    "thrust in ounces": (scaled(TUNNEL, thrust_N=3.5969), "thrust looks like ounces"),
    "thrust in pounds": (scaled(TUNNEL, thrust_N=0.22481), "thrust looks like pounds"),
    "torque in N cm": (scaled(TUNNEL, torque_Nm=1e2), "torque looks like N cm"),
    "torque in N mm": (scaled(TUNNEL, torque_Nm=1e3), "torque looks like N mm"),
    "torque in kg m": (scaled(TUNNEL, torque_Nm=0.10197), "torque looks like kg m"),
    "torque in kg cm": (scaled(TUNNEL, torque_Nm=10.197), "kg cm"),
    "torque in g cm": (scaled(TUNNEL, torque_Nm=10197.0), "torque looks like g cm"),
    "torque in oz in": (scaled(TUNNEL, torque_Nm=141.61), "ounce-inches"),
    "rpm in rad/s": (scaled(TUNNEL, rpm=1.0 / RPM_PER_RADIAN), "rpm in rad/s"),
    "rpm per second": (scaled(TUNNEL, rpm=1.0 / 60.0), "rpm in revolutions per second"),
    "rad/s converted twice": (scaled(TUNNEL, rpm=RPM_PER_RADIAN), "converted from rad/s twice"),
    "electrical rpm": (scaled(TUNNEL, rpm=7.0), "electrical rpm"),
    "slow electrical rpm": (scaled(TUNNEL, rpm=4.0), "electrical rpm"),
    "speed in km/h": (scaled(TUNNEL, speed_mps=3.6), "km/h"),
    "thrust against its sign": (scaled(TUNNEL, thrust_N=-1.0), "thrust is negative near V = 0"),
    "torque against its sign": (scaled(TUNNEL, torque_Nm=-1.0), "torque is negative near V = 0"),
    "axial beta from the disk": (turned(AXIAL, lambda b: 90.0 - b), DISK),
    "oblique beta from the disk": (turned(OBLIQUE, lambda b: 90.0 - b), DISK),
    "beta in radians": (turned(OBLIQUE, np.radians), "looks like radians"),
    "thrust alone, in grams": (scaled(THRUST_ALONE, thrust_N=102.0), "thrust looks like grams"),
    "thrust alone, rpm in rad/s": (scaled(THRUST_ALONE, rpm=0.10472), "rpm in rad/s"),
    "thrust alone, speed in km/h": (scaled(THRUST_ALONE, speed_mps=3.6), "km/h"),
}


def told_of(text: str, folder: Path, blade: propmap.Propeller = BLADE) -> str:
    path = folder / "tunnel.csv"
    path.write_text(text)
    try:
        return " ".join(tunnel_warnings([str(path)], blade, propmap.Air()))
    except InputError as error:
        assert str(error).startswith("tunnel.csv: ")
        return str(error)


@pytest.mark.parametrize("case", LOADS)
def test_loads(tmp_path: Path, case: str) -> None:
    text, cause = LOADS[case]
    assert cause in told_of(text, tmp_path)


@pytest.mark.parametrize("text", [TUNNEL, THRUST_ALONE, AXIAL, OBLIQUE])
def test_good_loads_are_passed(tmp_path: Path, text: str) -> None:
    assert told_of(text, tmp_path) == ""


def test_diameter_for_radius_shows_in_the_loads(tmp_path: Path) -> None:
    """A blade in fractions of the radius looks right at any size."""
    (tmp_path / "blade.csv").write_text(
        in_fractions(SHARE, WIDTH).replace(f"{BLADE.radius}", f"{2.0 * BLADE.radius}")
    )
    large = propmap.propeller(tmp_path / "blade.csv")
    assert blade_warnings(large) == []
    assert "a diameter in place of the radius" in told_of(TUNNEL, tmp_path, large)


def test_fit_refuses_what_cannot_be(run: Run, tmp_path: Path) -> None:
    (tmp_path / "tunnel.csv").write_text(LOADS["thrust in grams"][0])
    result = run("fit", "tunnel", "apc-8x6e", "tunnel.csv", *QUICK, "-o", "fit.toml")
    assert result.code == 2
    assert "tunnel.csv: C_T is " in result.err
    assert "thrust looks like grams" in result.err
    assert not (tmp_path / "fit.toml").exists()


@pytest.mark.slow
def test_fit_keeps_its_doubts(run: Run, tmp_path: Path) -> None:
    (tmp_path / "tunnel.csv").write_text(scaled(TUNNEL, thrust_N=0.22481))
    asked = ("fit", "tunnel", "apc-8x6e", "tunnel.csv", *QUICK, "-o", "fit.toml")
    assert run(*asked).code == 2
    result = run(*asked, "--accept")
    assert result.code == 0
    assert "note: tunnel.csv: thrust is 0." in result.err
    assert "thrust looks like pounds" in (tmp_path / "fit.toml").read_text()
    result = run("check", "fit.toml", "tunnel.csv")
    assert "thrust looks like pounds" in result.err


SLOW_TURNING = {"rad/s": (1.0 / RPM_PER_RADIAN, "rad/s"), "electrical rpm": (7.0, "electrical rpm")}


@pytest.mark.parametrize("case", SLOW_TURNING)
def test_level_table(tmp_path: Path, case: str) -> None:
    (tmp_path / "vehicle.toml").write_text(VEHICLE)
    vehicle, path = read_vehicle(tmp_path / "vehicle.toml"), tmp_path / "level.csv"
    path.write_text(LEVEL)
    assert read_flights([path], vehicle, "level", seconds=2.0, samples=100).remarks == ()
    factor, cause = SLOW_TURNING[case]
    path.write_text(scaled(LEVEL, **{f"rpm_{k}": factor for k in range(1, 5)}))
    with pytest.raises(InputError, match=cause) as caught:
        read_flights([path], vehicle, "level", seconds=2.0, samples=100)
    assert "revolutions per minute" in str(caught.value)
