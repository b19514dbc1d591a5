"""`propmap table`: the file, the certificate shown, and one-line errors."""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.loads import LOADS
from propmap.table import LoadTable, build_table

from .conftest import ROTOR, Run, refused
from .invented_tables import certificate, invented

SMALL = ["--rpm", "4000:4400", "--speed", "14:16", "--beta", "75:90", "--tolerance", "5%"]


def test_a_table_is_filed_and_its_certificate_and_corrections_shown(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    brief = functools.partial(build_table, certificate_points=512)
    monkeypatch.setattr("propmap.table.build.build_table", brief)
    # How few errors are overlooked is a question for `tests/table`.
    monkeypatch.setattr("propmap.table.build.PATROL_POINTS", 256)
    monkeypatch.setattr("propmap.table.verification.FEWEST_CLIMBS", 2)
    tip_loss = ["--correction", "tip-loss"]
    done = run("table", *ROTOR, *SMALL, *tip_loss, "-o", "map.npz")
    assert (done.code, done.err) == (0, "")
    assert [p.name for p in tmp_path.iterdir()] == ["map.npz"]
    blade = propmap.propeller("apc-8x6e")
    table = LoadTable.load("map.npz", propeller=blade)
    assert table.envelope["beta"] == pytest.approx(np.radians([75.0, 90.0]))
    assert table.info["command"].startswith("propmap table apc-8x6e")
    corrections = propmap.model_corrections("recommended", ["tip-loss"])
    model = propmap.Model(blade, propmap.airfoil("paper-apc"), corrections=corrections)
    assert table.info["model_sha256"] == model.fingerprint()
    told = json.loads(run("show", "map.npz", "--format", "json").out)
    assert told["corrections"] == ["pitt-peters", "radial-friction", "tip-loss"]
    named = "corrections: pitt-peters, radial-friction, tip-loss"
    assert named in run("show", "map.npz").out
    assert run("export", "map.npz", "--to", "csv", "-o", "to").code == 0
    assert named in Path("to/README-csv.txt").read_text()
    done = run("export", "map.npz", "--to", "c", "-o", "no", *tip_loss)
    assert "--correction does not apply to --to c of" in done.err


def test_show_lists_the_certificate(run: Run) -> None:
    invented(certificate=certificate(unresolved_cells=12)).save("map.npz")
    shown = run("show", "map.npz").out
    for text in (
        "tolerance of 0.50% holds on 4096 points",
        "unresolved: 12 cells, 0.98% of the envelope",
        "300 are in the vortex ring state; points without loads: 0",
    ):
        assert text in shown
    row = r"│ +0\.210 % │ +0\.030 % │ +3\.100 % │ +6000 │ +7\.25 │ +45 │"
    assert len(re.findall(row, shown)) == len(LOADS)


def test_an_interrupted_build_leaves_nothing(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(propmap.Rotor, "loads", stop)
    assert run("table", *ROTOR, *SMALL, "-o", "map.npz").code == 130
    assert list(tmp_path.iterdir()) == []


def test_a_table_of_both_directions_is_refused(run: Run) -> None:
    asked = ["--rpm", "-4000:4400", *SMALL[2:], "-o", "map.npz"]
    refused(run("table", *ROTOR, *asked), "includes 0", "one table for each direction")
