"""`propmap table`: the file, the certificate shown, and one-line errors."""

from __future__ import annotations

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
from propmap.model.airfoil import SectionCovariance
from propmap.table import LoadTable, build_table
from tests.fit.fit_records import fit_text, parameter

from .conftest import ROTOR, Run
from .invented_tables import certificate, invented, without_figures

SMALL = ["--rpm", "4000:4400", "--speed", "14:16", "--beta", "75:90", "--tolerance", "5%"]


BUILT: dict[str, LoadTable] = {}
"""Tables by all that they are made of."""


def _built(rotor: propmap.Rotor, **options: Any) -> LoadTable:
    """A table with a short certificate, which is built once."""
    made_of = {
        name: value for name, value in options.items() if name not in ("progress", "workers")
    }
    key = repr((rotor.model.fingerprint(), sorted(made_of.items())))
    if key not in BUILT:
        BUILT[key] = build_table(rotor, certificate_points=512, **options)
    return BUILT[key]


@pytest.fixture(autouse=True)
def _short_certificate(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("propmap.table.build.build_table", _built)
    # How few errors are overlooked is a question for `tests/table`.
    monkeypatch.setattr("propmap.table.build.PATROL_POINTS", 256)
    monkeypatch.setattr("propmap.table.verification.FEWEST_CLIMBS", 2)


def test_a_table_is_filed_and_its_certificate_shown(run: Run, tmp_path: Path) -> None:
    done = run("table", *ROTOR, *SMALL, "-o", "map.npz")
    assert (done.code, done.err) == (0, "")
    assert [p.name for p in tmp_path.iterdir()] == ["map.npz"]
    assert "Certificate" in done.out and "tolerance of 5.00% holds on" in done.out
    table = LoadTable.load("map.npz", propeller=propmap.propeller("apc-8x6e"))
    assert table.envelope["beta"] == pytest.approx(np.radians([75.0, 90.0]))
    assert table.info["command"].startswith("propmap table apc-8x6e")
    assert table.certificate["holds"]


def test_a_fit_brings_its_covariance(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: dict[str, Any] = {}

    def build(rotor: propmap.Rotor, **_: object) -> LoadTable:
        known = rotor.model.uncertainty
        assert known is not None
        given["covariance"] = known.covariance
        return _uncertain(known.covariance)

    monkeypatch.setattr("propmap.table.build.build_table", build)
    text = fit_text(
        parameters=[parameter(name, 1.0, 0.0, 9.0) for name in ("c_l1", "drag_area_x", "c_d")],
        covariance=np.array([[0.04, 0.1, -0.01], [0.1, 8.0, 0.2], [-0.01, 0.2, np.inf]]),
    )
    (tmp_path / "fit.toml").write_text(text)
    done = run("table", "apc-8x6e", "--airfoil", "fit.toml", *SMALL, "-o", "map.npz")
    assert (done.code, done.err) == (0, "")
    assert given["covariance"].names == ("c_l1", "c_d")
    assert given["covariance"].unknown == ("c_d",)
    np.testing.assert_array_equal(given["covariance"].matrix, [[0.04, -0.01], [-0.01, np.inf]])
    for shown in (done.out, run("show", "map.npz").out):
        assert "parameters, median" in shown and "1.500 %" in shown
        assert "covariance of c_l1, at 1000 points" in shown
        assert "do not determine them: c_d" in shown
    told = json.loads(run("show", "map.npz", "--format", "json").out)
    assert told["airfoil_covariance"] == {
        "names": ["c_l1", "c_d"],
        "matrix": [[0.04, -0.01], [-0.01, None]],
    }
    assert run("export", "map.npz", "--to", "csv", "-o", "to").code == 0
    assert "standard deviation of: thrust 1.50%" in (tmp_path / "to" / "README-csv.txt").read_text()


def _uncertain(covariance: SectionCovariance) -> LoadTable:
    """A table with a certificate, without a model behind it."""
    content = invented().content
    parameters = {
        "parameters": list(covariance.determined.names),
        "not_counted": list(covariance.unknown),
        "points": 1000,
        "median": dict.fromkeys(LOADS, 0.015),
        "percentile_95": dict.fromkeys(LOADS, 0.045),
    }
    filed = {"certificate": certificate(unresolved_cells=12), "parameter_uncertainty": parameters}
    filed["airfoil_covariance"] = covariance.as_dict()
    return LoadTable(replace(content, info={**content.info, **filed}))


def test_unresolved_cells_are_told(run: Run) -> None:
    _uncertain(SectionCovariance(("c_l1",), np.eye(1))).save("map.npz")
    done = run("show", "map.npz")
    assert (done.code, done.err) == (0, "")
    assert "tolerance of 0.50% holds on 4096 points" in done.out
    assert "largest errors used 26000 more points" in done.out
    assert "at [1/min]" in done.out
    assert len(re.findall(r"│ +6000 │ +7\.25 │ +45 │", done.out)) == len(LOADS)
    assert "unresolved: 12 cells, 0.98% of the envelope" in done.out
    assert "errors at 1020 points in these cells reach 3.10%" in done.out
    assert "300 are in the vortex ring state and 0 have no loads" in done.out
    assert "envelope: 1909.86 to 9549.3 rpm" in done.out


def test_a_certificate_from_before_the_search_is_shown(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It does not say where its largest errors are, nor that they were searched for."""
    without_figures(monkeypatch)
    content = invented().content
    later = ("search_points", "max_omega", "max_speed", "max_beta")
    told = {k: v for k, v in certificate(unresolved_cells=0).items() if k not in later}
    LoadTable(replace(content, info={**content.info, "certificate": told})).save("map.npz")
    done = run("show", "map.npz")
    assert (done.code, done.err) == (0, "")
    assert "tolerance of 0.50% holds on 4096 points" in done.out
    assert "search for" not in done.out and "at [" not in done.out
    assert run("report", "map.npz", "-o", "out").code == 0
    assert "at_rpm" not in Path("out/table-certificate.csv").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["absent.npz"], "no such file"),
        (["bad.npz"], "not a table, or it is damaged"),
        (["map.npz", "--format", "csv"], "use --format json"),
    ],
)
def test_what_cannot_be_shown(run: Run, tmp_path: Path, arguments: list[str], message: str) -> None:
    invented().save("map.npz")
    (tmp_path / "bad.npz").write_bytes((tmp_path / "map.npz").read_bytes()[:500])
    done = run("show", *arguments)
    assert done.code == 2
    assert message in done.err
    assert done.err.count("\n") == 1


def test_netcdf(run: Run) -> None:
    assert run("table", *ROTOR, *SMALL, "-o", "map.nc").code == 0
    with xarray.open_dataset("map.nc", engine="h5netcdf") as found:
        assert found["thrust"].dims == ("omega", "advance", "beta")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--tolerance", "much"], "not a fraction"),
        (["--tolerance", "-1%"], "not a fraction"),
        (["--tolerance", "0.001%"], "must be between 0.20% and 10%"),
        (["--tolerance", "80%"], "must be between"),
        (["--rpm", "4000"], "not a range"),
        (["--rpm", "5000:4000"], "do not increase"),
        (["--rpm", "0:4000"], "advance ratio is infinite"),
        (["--beta", "0:270"], "between 0 and pi"),
        (["-o", "map.csv"], "extension"),
        (
            ["-o", "absent/map.npz"],
            "error: absent/map.npz: there is no folder 'absent'; create it or choose another\n",
        ),
    ],
)
def test_what_cannot_be_is_told_in_one_line(
    run: Run, tmp_path: Path, arguments: list[str], message: str
) -> None:
    done = run("table", *ROTOR, *SMALL, "-o", "map.npz", *arguments)
    assert done.code == 2
    assert message in done.err
    assert done.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_existing_files_are_kept(run: Run, tmp_path: Path) -> None:
    (tmp_path / "map.npz").write_text("mine")
    assert "--force" in run("table", *ROTOR, *SMALL, "-o", "map.npz").err
    assert (tmp_path / "map.npz").read_text() == "mine"


def test_an_interrupted_build_leaves_nothing(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    BUILT.clear()
    monkeypatch.setattr(propmap.Rotor, "loads", stop)
    assert run("table", *ROTOR, *SMALL, "-o", "map.npz").code == 130
    assert list(tmp_path.iterdir()) == []


def test_rotor_speeds_too_far_apart_are_one_line(run: Run) -> None:
    wide = ["--rpm", "1000:9000", "--speed", "0:12", "--beta", "0:120", "--tolerance", "1%"]
    done = run("table", "10x4.5", *wide, "-o", "t.npz")
    assert done.code != 0 and not Path("t.npz").exists()
    told = done.err.splitlines()[-1]
    for words in ("error: from 1000 to 9000 rpm", "of the envelope, mostly at beta", "--rpm "):
        assert words in told
