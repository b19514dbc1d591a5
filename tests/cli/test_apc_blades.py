"""Blades by their maker's files are found by name, and a user's own file finds its series."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap import catalogue
from propmap.catalogue.lookup import meant_by
from propmap.units import INCH
from tests.io import samples

from .conftest import Run


def written(folder: Path, name: str, title: str) -> Path:
    """Write a blade of the catalogue as a file of APC with this title."""
    blade = catalogue.load(name)
    rows = [
        f"{y / INCH:12.4f}{c / INCH:12.4f}{4.0:12.4f}{0.1:12.4f}{0.1:12.4f}{angle:12.4f}{0.0:12.4f}"
        for y, c, angle in zip(blade.station, blade.chord, np.degrees(blade.twist), strict=True)
    ]
    trailer = re.sub(r"2\.50", f"{blade.radius / INCH:.2f}", samples.PE0_TRAILER)
    trailer = trailer.replace("0.50", f"{blade.root / INCH:.2f}")
    path = folder / "mine.PE0"
    path.write_text(
        samples.PE0_HEADER.replace("5x4T ", f"{title} ") + "\n".join(rows) + "\n" + trailer
    )
    return path


@pytest.mark.parametrize("name", ["apc-7x5e", "APC 12x4.5MR", "APC 5x4E-3"])
def test_by_name_it_is_the_makers_blade(name: str, run: Run) -> None:
    entry = meant_by(name)
    assert isinstance(entry, catalogue.Entry) and entry.geometry == "maker"
    blade = propmap.propeller(name)
    assert blade.blades == entry.blades and "PE0 file" in blade.source
    done = run("predict", name, "--rpm", "5000", "--speed", "5", "--beta", "0")
    assert done.code == 0 and "blade of the manufacturer's file" in done.err


@pytest.mark.parametrize(
    ("title", "says"),
    [
        ("10x7SF", "identified from 117 rows of 'apcsf 10.0x7.0 - 2'"),
        ("10x7.3SF", "10 propellers of its family, apcsf, for the blade of the manufacturer"),
        ("10x7", "12 propellers of its family, apcsp, for the blade of the manufacturer"),
        ("10x7N", "none of its family"),
        ("0x7E", "none of its family"),
    ],
)
def test_a_users_own_file_has_the_constants_of_its_series(
    title: str, says: str, run: Run, tmp_path: Path
) -> None:
    path = written(tmp_path, "apc-10x7sf", title)
    done = run("predict", path, "--rpm", "5000", "--speed", "5", "--beta", "0", "--format", "json")
    assert done.code == 0, done.err
    assert says in done.err
    if title == "10x7SF":
        # The very blade of the catalogue, but for the digits of a file.
        same = run("predict", "apc-10x7sf", "--rpm", "5000", "--speed", "5", "--beta", "0",
                   "--format", "json")  # fmt: skip
        found, wanted = json.loads(done.out), json.loads(same.out)
        assert found["thrust_N"] == pytest.approx(wanted["thrust_N"], rel=2e-3)
        assert found["thrust_std_N"] == pytest.approx(wanted["thrust_std_N"], rel=0.02)


def test_at_least_280_are_listed_with_their_blades(run: Run) -> None:
    rows = json.loads(run("props", "--format", "json").out)
    assert sum("not measured" not in row["title"] for row in rows) >= 280
