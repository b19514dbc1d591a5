"""The bundled propellers: complete, plausible, and the published numbers."""

from __future__ import annotations

import csv
import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from propmap import catalogue
from propmap.catalogue.lookup import propeller
from propmap.errors import InputError
from propmap.io.geometry import read_propeller_toml

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT.parent / "shared" / "data"
FOLDER = Path(catalogue.__file__).parent
with_data = pytest.mark.skipif(not DATA.is_dir(), reason="the published data are not here")

PE0 = {
    "apc-8x6e": "8x6E",
    "apc-8x6sf": "8x6SF",
    "apc-8x4.5mr": "8x45MR",
    "apc-11x7e": "11x7E",
    "apc-9x6e": "9x6E",
}


def test_names_are_tidy() -> None:
    names = catalogue.names()
    assert names == sorted(set(names)) and len(names) == 282
    assert all(name == name.lower() and " " not in name for name in names)
    assert [entry.name for entry in catalogue.entries()] == names


def test_what_an_entry_says_is_what_the_blade_is() -> None:
    for entry in catalogue.entries():
        blade = catalogue.load(entry.name)
        assert (blade.name, blade.blades) == (entry.name, entry.blades)
        assert blade.diameter == pytest.approx(entry.diameter_m, rel=1e-6)
        assert blade.source == entry.source and blade.citation


@pytest.mark.parametrize("name", sorted(file.stem for file in FOLDER.glob("propellers/*.toml")))
def test_its_files_stand_the_check_of_a_users(name: str) -> None:
    file = FOLDER / "propellers" / f"{name}.toml"
    assert read_propeller_toml(file) == catalogue.load(name)


@pytest.mark.parametrize("name", catalogue.names())
def test_every_blade_is_plausible(name: str) -> None:
    blade = catalogue.load(name)
    assert 0.02 < blade.radius < 2.0
    assert 0.05 * blade.radius < blade.chord.max() < 0.4 * blade.radius
    assert np.deg2rad(10.0) < blade.twist.max() < np.deg2rad(60.0)
    assert blade.twist.min() >= 0.0
    assert blade.root <= 0.31 * blade.radius
    assert blade.blades == (int(name[-1]) if name[-2:-1] == "-" and name[-1].isdigit() else 2)


@pytest.mark.parametrize("name", catalogue.names())
def test_the_label_is_the_diameter(name: str) -> None:
    size = float(next(part for part in name.split("-")[1:] if "x" in part).split("x")[0])
    unit = 0.001 if name.split("-")[1] in {"ef", "kpf", "pl", "vp"} else 0.0254
    # APC's 13 and 17 inches are 12.95 and 16.95, and its 4.7 are 4.75.
    room = 1e-6 if catalogue.entry(name).geometry == "measured" else 0.011
    assert catalogue.load(name).diameter == pytest.approx(size * unit, rel=room)


def test_import_is_light() -> None:
    script = (
        "import sys, propmap.catalogue, propmap.io.geometry as g;"
        "print(sorted({'jax', 'scipy', 'pandas', 'matplotlib'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    assert done.stdout.strip() == b"[]"


def test_search_needs_every_word() -> None:
    found = [entry.name for entry in catalogue.search("thin ELECTRIC 9x6")]
    assert found == ["apc-9x6e", "uiuc-apce-9x6"]
    assert len(catalogue.search("")) == len(catalogue.names())
    assert catalogue.search("no such propeller") == []


def test_an_unknown_name() -> None:
    with pytest.raises(InputError, match=r"did you mean .*apc-9x6e.*see `propmap props`"):
        catalogue.load("apc-9x6")


def test_a_file_of_ones_own(tmp_path: Path) -> None:
    text = (Path(catalogue.__file__).parent / "propellers" / "apc-8x6e.toml").read_text()
    path = tmp_path / "mine.toml"
    path.write_text(text.replace('name = "apc-8x6e"', 'name = "mine"'))
    blade = propeller(path)
    assert blade.name == "mine"
    np.testing.assert_array_equal(blade.twist, catalogue.load("apc-8x6e").twist)


@with_data
@pytest.mark.parametrize("name", PE0)
def test_apc_blades_are_the_published_ones(name: str) -> None:
    path = DATA / "apc" / f"{PE0[name]}-PERF.PE0"
    rows = [line.split() for line in path.read_text().splitlines()]
    # Read here by position, independently of the reader: 13 figures to a row.
    table = np.array([r for r in rows if len(r) == 13 and r[0][0].isdigit()], dtype=float)
    for blade in (catalogue.load(name), propeller(path)):
        np.testing.assert_allclose(blade.station, table[:, 0] * 0.0254, rtol=1e-6)
        np.testing.assert_allclose(blade.chord, table[:, 1] * 0.0254, rtol=1e-6)
        np.testing.assert_allclose(blade.twist, table[:, 7] * np.pi / 180.0, rtol=1e-6)
        assert blade.root == pytest.approx(blade.station[0])


@with_data
def test_uiuc_blades_are_the_published_ones() -> None:
    with (DATA / "uiuc" / "geometry.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    blade_names = {row["BladeName"] for row in rows}
    by_label = {e.source.split("'")[1] for e in catalogue.entries() if e.name.startswith("uiuc")}
    assert by_label == blade_names
    for name in ("uiuc-apce-9x6", "uiuc-gwsdd-9x5", "uiuc-kpf-96x70", "uiuc-da4002-9x2.85"):
        blade = catalogue.load(name)
        label = blade.source.split("'")[1]
        published = {
            (float(r["r/R"]), float(r["c/R"]), float(r["beta"]))
            for r in rows
            if r["BladeName"] == label
        }
        assert blade.station.size == len(published)
        for r, c, beta in published:
            i = int(np.argmin(np.abs(blade.station - r * blade.radius)))
            assert blade.station[i] == pytest.approx(r * blade.radius, rel=1e-6)
            assert blade.chord[i] == pytest.approx(c * blade.radius, rel=1e-6)
            assert np.rad2deg(blade.twist[i]) == pytest.approx(beta, rel=1e-6)


def test_three_measured_blades_of_one_name_are_three_entries() -> None:
    for stem in ("uiuc-gwsdd-2.5x0.8", "uiuc-gwsdd-5x4.3"):
        blades = [catalogue.load(f"{stem}{suffix}") for suffix in ("", "-b", "-c")]
        assert len({b.chord.tobytes() for b in blades}) == 3
        assert [b.source.split(", ")[-1][:16] for b in blades] == [
            f"measured blade {i}" for i in (1, 2, 3)
        ]


def test_nr640_stands_at_the_angle_of_its_label() -> None:
    for name, degrees in {"5x3.16": 15.0, "5x4.29": 20.0, "9x5.68": 15.0, "9x7.72": 20.0}.items():
        blade = catalogue.load(f"uiuc-nr640-{name}")
        angle = np.interp(0.75 * blade.radius, blade.station, blade.twist)
        assert np.rad2deg(angle) == pytest.approx(degrees, abs=1e-4)
        pitch = 0.75 * np.pi * blade.diameter / 0.0254 * np.tan(angle)
        assert pitch == pytest.approx(float(name.split("x")[1]), abs=0.01)


@with_data
def test_building_again_gives_the_same_files(tmp_path: Path) -> None:
    (tmp_path / "tools").mkdir()
    script = tmp_path / "tools" / "build_catalogue.py"
    script.write_bytes((ROOT / "tools" / "build_catalogue.py").read_bytes())
    subprocess.run([sys.executable, str(script), str(DATA)], check=True)

    def digests(folder: Path) -> dict[str, str]:
        return {
            str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest()
            for p in sorted(folder.iterdir())
        }

    for part, count in {"propellers": 129, "apc_files": 2, "measurements": 4}.items():
        built = digests(tmp_path / "src" / "propmap" / "catalogue" / part)
        assert len(built) == count
        assert built == digests(ROOT / "src" / "propmap" / "catalogue" / part)
