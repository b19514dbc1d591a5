"""`propmap table`: the file, the certificate shown, and one-line errors."""

from __future__ import annotations

import functools
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import propmap
from propmap.loads import LOADS
from propmap.table import LoadTable, build_table
from tests.fit.fit_records import fit_text, parameter

from .conftest import ROTOR, Run
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


def test_a_fit_brings_its_covariance_which_is_shown_with_the_certificate(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[dict[str, Any]] = []

    def build(rotor: propmap.Rotor, **named: Any) -> LoadTable:
        """A table with a certificate, without a model behind it."""
        assert rotor.model.uncertainty is not None
        known, content = rotor.model.uncertainty.covariance, invented().content
        calls.append({**named, "known": known})
        parameters = {
            "parameters": list(known.determined.names),
            "not_counted": list(known.unknown),
            "points": 1000,
            "median": dict.fromkeys(LOADS, 0.015),
            "percentile_95": dict.fromkeys(LOADS, 0.045),
        }
        info = {
            **content.info,
            "certificate": certificate(unresolved_cells=12),
            "parameter_uncertainty": parameters,
            "airfoil_covariance": known.as_dict(),
        }
        return LoadTable(replace(content, info=info))

    monkeypatch.setattr("propmap.table.build.build_table", build)
    text = fit_text(
        parameters=[parameter(name, 1.0, 0.0, 9.0) for name in ("c_l1", "drag_area_x", "c_d")],
        covariance=np.array([[0.04, 0.1, -0.01], [0.1, 8.0, 0.2], [-0.01, 0.2, np.inf]]),
    )
    (tmp_path / "fit.toml").write_text(text)
    asked = ["table", "apc-8x6e", "--airfoil", "fit.toml", *SMALL, "-o"]
    done = run(*asked, "map.npz")
    assert (done.code, done.err) == (0, "")
    known = calls[0]["known"]
    assert (known.names, known.unknown) == (("c_l1", "c_d"), ("c_d",))
    np.testing.assert_array_equal(known.matrix, [[0.04, -0.01], [-0.01, np.inf]])
    shown = run("show", "map.npz").out
    for text in (
        "parameters, median",
        "covariance of c_l1, at 1000 points",
        "do not determine them: c_d",
        "tolerance of 0.50% holds on 4096 points",
        "largest errors used 26000 more points",
        "unresolved: 12 cells, 0.98% of the envelope",
        "errors at 1020 points in these cells reach 3.10%",
        "300 are in the vortex ring state; points without loads: 0",
    ):
        assert text in done.out and text in shown
    assert len(re.findall(r"│ +6000 │ +7\.25 │ +45 │", shown)) == len(LOADS)
    assert "envelope: 1909.86 to 9549.3 rpm" in shown
    told = json.loads(run("show", "map.npz", "--format", "json").out)["airfoil_covariance"]
    assert told == {"names": ["c_l1", "c_d"], "matrix": [[0.04, -0.01], [-0.01, None]]}
    # Another format, and without the vortex ring.
    assert run(*asked, "map.nc", "--no-vortex-ring").code == 0
    assert [call["leave_out_vortex_ring"] for call in calls] == [False, True]
    with xarray.open_dataset("map.nc", engine="h5netcdf") as found:
        assert found["thrust"].dims == ("omega", "advance", "beta")


def test_an_interrupted_build_leaves_nothing(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(propmap.Rotor, "loads", stop)
    assert run("table", *ROTOR, *SMALL, "-o", "map.npz").code == 130
    assert list(tmp_path.iterdir()) == []
