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
from propmap.model.plausibility import CHORD, RADIUS, TWIST, at_share, blade_warnings
from propmap.model.propeller import WIDEST_CHORD

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT.parent / "shared" / "data"
FOLDER = Path(catalogue.__file__).parent
with_data = pytest.mark.skipif(not DATA.is_dir(), reason="the published data are not here")

PE0 = {"apc-8x6e": "8x6E", "apc-8x6sf": "8x6SF", "apc-8x4.5mr": "8x45MR"}


def test_names_are_tidy() -> None:
    names = catalogue.names()
    assert names == sorted(set(names)) and len(names) == 282
    assert all(name == name.lower() and " " not in name for name in names)
    assert [entry.name for entry in catalogue.entries()] == names


def test_entries_and_labels_are_those_of_plausible_blades() -> None:
    for entry in catalogue.entries():
        name, blade = entry.name, catalogue.load(entry.name)
        assert (blade.name, blade.blades, blade.source) == (name, entry.blades, entry.source)
        assert blade.diameter == pytest.approx(entry.diameter_m, rel=1e-6) and blade.citation
        size = float(next(part for part in name.split("-")[1:] if "x" in part).split("x")[0])
        unit = 0.001 if name.split("-")[1] in {"ef", "kpf", "pl", "vp"} else 0.0254
        # APC's 13 and 17 inches are 12.95 and 16.95, and its 4.7 are 4.75.
        room = 1e-6 if entry.geometry == "measured" else 0.011
        assert blade.diameter == pytest.approx(size * unit, rel=room), name
        assert blade.blades == (int(name[-1]) if name[-2:-1] == "-" and name[-1].isdigit() else 2)
        assert blade.twist.min() >= 0.0 and blade.root <= 0.31 * blade.radius, name
        # The ranges of the warnings have room, but not so much that they say nothing.
        assert blade_warnings(blade) == []
        chord, twist = at_share(blade, 0.75)
        assert 1.1 * CHORD.low < chord / blade.radius < CHORD.high / 1.1, name
        widest = blade.chord.max() / blade.radius
        assert 1.1 * WIDEST_CHORD.low < widest < WIDEST_CHORD.high / 1.1, name
        assert 2.0 * TWIST.low < np.degrees(twist) < TWIST.high / 1.2, name
        assert 2.0 * RADIUS.low < blade.radius < RADIUS.high / 2.0, name


def test_bundled_files_pass_the_checks_of_a_users(tmp_path: Path) -> None:
    files = sorted(FOLDER.glob("propellers/*.toml"))
    assert len(files) > 100
    for file in files:
        assert read_propeller_toml(file) == catalogue.load(file.stem)
    mine = tmp_path / "mine.toml"
    mine.write_text(files[0].read_text().replace(f'name = "{files[0].stem}"', 'name = "mine"'))
    blade = propeller(mine)
    assert blade.name == "mine"
    np.testing.assert_array_equal(blade.twist, catalogue.load(files[0].stem).twist)


def test_search_needs_every_word() -> None:
    found = [entry.name for entry in catalogue.search("thin ELECTRIC 9x6")]
    assert found == ["apc-9x6e", "uiuc-apce-9x6"]
    assert len(catalogue.search("")) == len(catalogue.names())
    assert catalogue.search("no such propeller") == []
    with pytest.raises(InputError, match=r"did you mean .*apc-9x6e.*see `propmap props`"):
        catalogue.load("apc-9x6")


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
