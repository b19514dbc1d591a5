"""Write the bundled propellers and measurements from the published data.

Usage: python tools/build_catalogue.py DATA_FOLDER

DATA_FOLDER contains apc/*.PE0, apc/pe0/*.PE0, uiuc/geometry.csv, uiuc/loads.csv and oblique/*.csv.
The tool replaces the files under src/propmap/catalogue/; equal data result in equal bytes.
"""

from __future__ import annotations

import csv
import json
import math
import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from propmap.catalogue.apc import series_of
from propmap.io.geometry import UIUC_CITATION, read_apc_pe0
from propmap.model.propeller import Propeller
from propmap.units import INCH

CATALOGUE = Path(__file__).resolve().parent.parent / "src" / "propmap" / "catalogue"
PER_LINE = 6
RHO = 1.225
RPM = 2.0 * math.pi / 60.0

APC_CITATION = "Landing Products Inc. (APC Propellers), performance data files, September 2022"
# file : (name in the catalogue, title, family code of the UIUC database)
APC_FILES = {
    "8x6E": ("apc-8x6e", "APC 8x6E Thin Electric", "apce"),
    "8x6SF": ("apc-8x6sf", "APC 8x6SF Slow Flyer", "apcsf"),
    "8x45MR": ("apc-8x4.5mr", "APC 8x4.5MR Multi-Rotor", "apcmr"),
    "11x7E": ("apc-11x7e", "APC 11x7E Thin Electric", "apce"),
    "9x6E": ("apc-9x6e", "APC 9x6E Thin Electric", "apce"),
}
OWN_FILES = {"8x6E", "8x6SF", "8x4.5MR", "11x7E", "9x6E"}  # their titles

# Series of which the catalogue has all blades; those of the others are read, to compare.
MAKERS_SERIES = {"apce", "apcsf", "apcmr"}
COMPARED_AT = 0.75  # share of the radius

# Families whose makers the database names; the others keep its code as their title.
UIUC_TITLES = {
    "apc29ff": "APC 29 Free Flight",
    "apce": "APC Thin Electric",
    "apcff": "APC Free Flight",
    "apcsf": "APC Slow Flyer",
    "apcsp": "APC Sport",
    "ef": "E-flite",
    "grcp": "Graupner CAM",
    "grcsp": "Graupner CAM Slim",
    "grsn": "Graupner Super Nylon",
    "gwsdd": "GWS Direct Drive",
    "gwssf": "GWS Slow Flyer",
    "kyosho": "Kyosho",
    "ma": "Master Airscrew",
    "mae": "Master Airscrew Electric",
    "magf": "Master Airscrew G/F",
    "mas": "Master Airscrew Scimitar",
    "union": "Union",
}
# Families whose diameter and pitch are labeled in millimeters.
UIUC_METRIC = {"ef", "kpf", "pl", "vp"}

# The NR640 has a hub of adjustable pitch.  The database tabulates its blade once, at 15 degrees
# at 0.75 R, under all four labels; the labels 5x4.29 and 9x7.72 mean 20 degrees there, and their
# thrust vanishes at an advance angle 4 to 5 degrees above that of the other two.
NR640_TURNED = {"nr640 5x4.29": 5.0, "nr640 9x7.72": 5.0}

Row = dict[str, str]


def main(data: Path) -> None:
    """Write all files of the catalogue from the folder ``data``."""
    propellers, apc_files, measurements = (
        CATALOGUE / name for name in ("propellers", "apc_files", "measurements")
    )
    for folder in (propellers, apc_files, measurements):
        folder.mkdir(parents=True, exist_ok=True)
        for old in folder.iterdir():
            old.unlink()
    loads = _read_csv(data / "uiuc" / "loads.csv")
    measured = list(_uiuc(data / "uiuc" / "geometry.csv", loads))
    for fields in [*_apc(data / "apc"), *measured]:
        _write(propellers / f"{fields['name']}.toml", fields)
    blades = _makers(data / "apc" / "pe0")
    _write_lines(apc_files / "blades.csv", _makers_table(blades))
    _write_lines(apc_files / "differences.csv", _differences(blades, measured))
    _write(measurements / "uiuc-8x6e.toml", _uiuc_8x6e(loads))
    for name, fields in _gill_dandrea(data / "oblique").items():
        _write(measurements / f"{name}.toml", fields)
    _write(measurements / "davoudi-8x4.5mr-thrust.toml", _davoudi(data / "oblique"))


def _apc(folder: Path) -> Iterable[dict[str, Any]]:
    for stem, (name, title, family) in APC_FILES.items():
        blade = read_apc_pe0(folder / f"{stem}-PERF.PE0")
        yield {
            "schema": 1,
            "name": name,
            "title": title,
            "family": family,
            "blades": blade.blades,
            "radius_m": blade.radius,
            "source": f"{blade.source}: chord, and twist of the chord line",
            "citation": APC_CITATION,
            "station_m": list(blade.station),
            "chord_m": list(blade.chord),
            "twist_rad": list(blade.twist),
        }


def _makers(folder: Path) -> dict[str, Propeller]:
    """APC's blades of known series by title, by diameter and pitch."""
    found = {}
    for path in folder.glob("*.PE0"):
        title = path.read_text(encoding="utf-8").split(maxsplit=1)[0]
        if series_of(title):
            found[title] = read_apc_pe0(path)

    def place(title: str) -> tuple[list[float], str]:
        size = re.match(r"([\d.]+)x([\d.]+)", title)
        assert size is not None  # else it would be of no series
        return [float(part) for part in size.groups()], title

    return {title: found[title] for title in sorted(found, key=place)}


def _makers_table(makers: dict[str, Propeller]) -> Iterable[str]:
    """A line for each blade that has no file of its own; all stations of the PE0 file."""
    yield "title,blades,radius_m,r_over_R,c_over_R,twist_deg"
    for title, blade in makers.items():
        family, _ = series_of(title) or ("", "")
        if family in MAKERS_SERIES and title not in OWN_FILES:
            shape = (
                " ".join(f"{value:.{digits}f}" for value in values)
                for values, digits in (
                    (blade.station / blade.radius, 4),
                    (blade.chord / blade.radius, 5),
                    (np.degrees(blade.twist), 2),
                )
            )
            yield ",".join([title, str(blade.blades), _float(blade.radius), *shape])


def _differences(makers: dict[str, Propeller], measured: Sequence[dict[str, Any]]) -> Iterable[str]:
    """Chord and twist of measured blades beside their maker's, at 0.75 R."""
    yield "family,title,chord_ratio,twist_less_deg"
    by_size = {(series_of(title) or ("", ""))[0] + title.rstrip("ESFMR"): title for title in makers}
    for fields in measured:
        family, size = fields["name"].split("-")[1:3]
        title = by_size.get(family + size)
        if title is not None:
            (chord, twist), (own_chord, own_twist) = (
                [float(np.interp(COMPARED_AT, r / r[-1], values)) for values in (c / r[-1], t)]
                for r, c, t in (
                    [np.array(fields[key]) for key in ("station_m", "chord_m", "twist_rad")],
                    [makers[title].station, makers[title].chord, makers[title].twist],
                )
            )
            yield f"{family},{title},{chord / own_chord:.4f},{math.degrees(twist - own_twist):.3f}"


def _uiuc(geometry: Path, loads: Sequence[Row]) -> Iterable[dict[str, Any]]:
    tables: dict[str, list[Row]] = {}
    for row in _read_csv(geometry):
        tables.setdefault(row["BladeName"], []).append(row)
    for blade_name, rows in tables.items():
        counts = sorted({int(r["B"]) for r in loads if r["BladeName"] == blade_name})
        blades = _distinct_blades(rows)
        for number, blade in enumerate(blades):
            yield _uiuc_blade(blade_name, blade, counts, number, len(blades))


def _distinct_blades(rows: Sequence[Row]) -> list[list[Row]]:
    """The tables of one name, split where r/R starts again; a table given twice counts once."""
    found: list[list[Row]] = []
    for row in rows:
        if not found or float(row["r/R"]) <= float(found[-1][-1]["r/R"]):
            found.append([])
        found[-1].append(row)
    kept: dict[tuple[tuple[str, ...], ...], list[Row]] = {}
    for table in found:
        kept.setdefault(tuple((r["r/R"], r["c/R"], r["beta"]) for r in table), table)
    return list(kept.values())


def _uiuc_blade(
    blade_name: str, rows: Sequence[Row], counts: Sequence[int], number: int, of: int
) -> dict[str, Any]:
    family, size = blade_name.split()
    size = "x".join(f"{float(part):g}" for part in size.split("x"))
    radius = float(rows[0]["D"]) * INCH / 2.0
    turned = NR640_TURNED.get(blade_name, 0.0)
    maker = UIUC_TITLES.get(family, family.upper())
    unit = " mm" if family in UIUC_METRIC else ""
    volume = rows[0]["volume"]
    source = f"UIUC Propeller Database, volume {volume}, blade {blade_name!r}"
    if of > 1:
        source += f", measured blade {number + 1} of {of}"
    if len(counts) > 1:
        *fewer, most = sorted(counts)
        source += f"; tested with {', '.join(map(str, fewer))} and {most} blades"
    if turned:
        source += (
            f"; the tabulated blade stands at 15 deg at 0.75 R and was turned by {turned:g} deg "
            "to the 20 deg of the label"
        )
    suffix = "-" + "abc"[number] if number else ""
    return {
        "schema": 1,
        "name": f"uiuc-{family}-{size}{suffix}",
        "title": f"{maker} {size}{unit}" + (f" (blade {number + 1})" if number else ""),
        "family": family,
        "blades": 2 if len(counts) != 1 else counts[0],
        "radius_m": radius,
        "source": source,
        "citation": UIUC_CITATION,
        "station_m": [float(r["r/R"]) * radius for r in rows],
        "chord_m": [float(r["c/R"]) * radius for r in rows],
        "twist_rad": [math.radians(float(r["beta"]) + turned) for r in rows],
    }


def _uiuc_8x6e(loads: Sequence[Row]) -> dict[str, Any]:
    rows = [r for r in loads if r["BladeName"] == "apce 8.0x6.0" and r["B"] == "2"]
    diameter = 8.0 * INCH
    turns = [float(r["N"]) / 60.0 for r in rows]
    thrust = [float(r["CT"]) * RHO * n**2 * diameter**4 for r, n in zip(rows, turns, strict=True)]
    power = [float(r["CP"]) * RHO * n**3 * diameter**5 for r, n in zip(rows, turns, strict=True)]
    return {
        "schema": 1,
        "name": "uiuc-8x6e",
        "propeller": "apc-8x6e",
        "kind": "measured",
        "air_density": RHO,
        "note": "Published as CT, CP and J; made dimensional with 1.225 kg/m^3 and D = 8 in. "
        "Rows at speed 0 are static tests.",
        "citation": UIUC_CITATION,
        "omega_rad_s": [2.0 * math.pi * n for n in turns],
        "speed_m_s": [float(r["J"]) * n * diameter for r, n in zip(rows, turns, strict=True)],
        "beta_rad": [0.0 for _ in rows],
        "thrust_N": thrust,
        "torque_Nm": [p / (2.0 * math.pi * n) for p, n in zip(power, turns, strict=True)],
    }


def _gill_dandrea(folder: Path) -> dict[str, dict[str, Any]]:
    """The two forms that one paper gives of one campaign."""
    citation = "Gill, D'Andrea, Drones 3(4):77, 2019, doi 10.3390/drones3040077 (CC BY 4.0)"
    found = {}
    for name, file, note, loads in (
        (
            "gill-dandrea-2019-8x6e",
            "apc_8x6e_published_polynomials.csv",
            "Section 5 of the paper, eqs. 95-102: one polynomial per load, fitted to wind-tunnel "
            "measurements of this load and evaluated here; the constants have two digits. No "
            "public data are closer to the measurements. The rms differences from the paper's own "
            "blade-element model, gill-dandrea-2019-8x6e-fit, are 2 to 4 % for thrust, torque and "
            "drag, and 27 % for the rolling moment.",
            ("thrust_N", "torque_Nm", "drag_N", "roll_moment_Nm", "pitch_moment_Nm"),
        ),
        (
            "gill-dandrea-2019-8x6e-fit",
            "apc_8x6e_published_fit.csv",
            "A model, not measurements: section 3 of the paper, closed-form blade elements on a "
            "blade of constant chord, evaluated here. Its nine constants were fitted to all loads "
            "of a wind-tunnel campaign together. Separate fits of each load are "
            "gill-dandrea-2019-8x6e.",
            ("thrust_N", "torque_Nm", "drag_N", "roll_moment_Nm"),
        ),
    ):
        rows = _read_csv(folder / file)
        found[name] = {
            "schema": 1,
            "name": name,
            "propeller": "apc-8x6e",
            "kind": "fit",
            "air_density": RHO,
            "note": note,
            "citation": citation,
            **_operating_points(rows),
            **{load: _column(rows, load) for load in loads},
        }
    return found


def _davoudi(folder: Path) -> dict[str, Any]:
    rows = _read_csv(folder / "apc_8x45mr_thrust.csv")
    return {
        "schema": 1,
        "name": "davoudi-8x4.5mr-thrust",
        "propeller": "apc-8x4.5mr",
        "kind": "digitized",
        "air_density": RHO,
        "note": "Digitized from a figure, 2-3 % of full scale. The air density of the tests is "
        "not known; 1.225 kg/m^3 is assumed.",
        "citation": "Davoudi, Duraisamy, A Hybrid Blade Element Momentum Model for Flight "
        "Simulation of Rotary Wing UAVs, AIAA 2019",
        **_operating_points(rows),
        "thrust_N": _column(rows, "thrust_N"),
    }


def _operating_points(rows: Sequence[Row]) -> dict[str, list[float]]:
    return {
        "omega_rad_s": [value * RPM for value in _column(rows, "rpm")],
        "speed_m_s": _column(rows, "speed_mps"),
        "beta_rad": [math.radians(value) for value in _column(rows, "beta_deg")],
    }


def _column(rows: Sequence[Row], name: str) -> list[float]:
    return [float(row[name]) for row in rows]


def _read_csv(path: Path) -> list[Row]:
    with path.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def _write(path: Path, fields: dict[str, Any]) -> None:
    _write_lines(path, (f"{key} = {_toml(value)}" for key, value in fields.items()))


def _write_lines(path: Path, lines: Iterable[str]) -> None:
    with path.open("x", encoding="utf-8", newline="\n") as stream:
        stream.write("\n".join(lines) + "\n")


def _toml(value: Any) -> str:
    if isinstance(value, str):
        # A JSON string of printable ASCII is a TOML string too.
        return json.dumps(value)
    if isinstance(value, list):
        cells = [_float(v) for v in value]
        rows = [cells[i : i + PER_LINE] for i in range(0, len(cells), PER_LINE)]
        return "[\n" + "".join(f"  {', '.join(row)},\n" for row in rows) + "]"
    return str(value) if isinstance(value, int) else _float(value)


def _float(value: float) -> str:
    """Seven significant digits, and a point, since TOML tells integers from floats."""
    text = f"{value:.7g}"
    return text if "." in text or "e" in text else f"{text}.0"


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
