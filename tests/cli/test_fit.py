"""`propmap fit tunnel` and `propmap check`: files in, a fit file and its errors out."""

from __future__ import annotations

import csv
import hashlib
import io
import json
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.fit.comparison import INSIDE, OUTSIDE
from propmap.fit.files import read_fit
from propmap.model.airfoil import parameter_set

from .conftest import Run
from .fit_inputs import (
    CHECKED,
    FREE,
    ONE_SPEED,
    QUICK,
    UIUC,
    fit_record,
    fitted,
    picked,
    uiuc_files,
)

pytestmark = pytest.mark.usefixtures("brief")


def test_the_file_carries_what_repeats_the_fit(tunnel_fit: Path, tunnel_csv: Path) -> None:
    found = fit_record(tunnel_fit)
    data = tunnel_csv.read_bytes()
    assert found["kind"] == "tunnel" and found["propmap"] == propmap.__version__
    assert found["data"] == [{"file": "tunnel.csv", "sha256": hashlib.sha256(data).hexdigest()}]
    assert found["free"] == list(FREE) and found["rows"] == 28 and found["unsolved_rows"] == 0
    air = propmap.Air()
    assert found["air"] == {"density": air.density, "viscosity": air.viscosity}
    settings = {"starts": 1, "folds": 0, "loss": "linear", "bootstrap": 0, "seed": 2017}
    assert settings.items() <= found["settings"].items()
    assert found["settings"]["loads"] == ["thrust", "torque"]
    covariance = np.array(found["covariance"])
    assert covariance.shape == (2, 2)
    np.testing.assert_allclose(covariance, covariance.T)
    for k, name in enumerate(FREE):
        p = found["parameters"][name]
        assert p["low_95"] < p["value"] < p["high_95"]
        assert p["identified"] is (p["verdict"] == "identified")
        assert p["high_95"] - p["value"] == pytest.approx(2.06 * covariance[k, k] ** 0.5, rel=0.01)
    assert set(found["residuals"]) == {"thrust", "torque"}
    assert found["residuals"]["thrust"]["rows"] == 14
    assert "by_speed" in found["residuals"]["torque"]
    assert len(found["starts"]) == 1 and found["starts"][0]["minimum"] == 1


def test_the_file_is_a_parameter_set(run: Run, tunnel_fit: Path) -> None:
    law = parameter_set(tunnel_fit)
    found = fit_record(tunnel_fit)["parameters"]
    assert law.c_l1 == found["c_l1"]["value"]
    assert law.zero_lift_angle == found["zero_lift_angle"]["value"]
    assert law.name == "tunnel_fit"
    done = run(
        "predict", "apc-8x6e", "--airfoil", tunnel_fit,
        "--rpm", "5000", "--speed", "0", "--beta", "0", "--format", "json",
    )  # fmt: skip
    assert (done.code, done.err) == (0, "")
    rotor = propmap.Rotor(propmap.Model(propmap.propeller("apc-8x6e"), law))
    expected = rotor.loads(5000.0 * np.pi / 30.0, 0.0, 0.0)
    assert json.loads(done.out)["thrust_N"] == pytest.approx(float(expected.thrust))


def test_uiuc_files_are_the_same_rows(run: Run, tmp_path: Path, tunnel_fit: Path) -> None:
    files = uiuc_files(tmp_path)
    found, _ = fitted(run, "tunnel", "apc-8x6e", *files, *QUICK)
    assert [d["file"] for d in found["data"]] == [path.name for path in files]
    assert found["rows"] == 28
    for name in FREE:
        want = fit_record(tunnel_fit)["parameters"][name]["value"]
        # The rpm in the file's name is rounded.
        assert found["parameters"][name]["value"] == pytest.approx(want, rel=1e-3)


def test_by_name_of_the_catalogue(run: Run) -> None:
    arguments = ["--loads", "thrust", "--weight", "thrust=2", "--rho", "1.2", "--robust"]
    found, out = fitted(run, "tunnel", "apc-8x6e", "UIUC-8x6e", *QUICK, *arguments)
    assert found["data"] == [{"catalogue": "uiuc-8x6e"}]
    assert found["settings"]["loads"] == ["thrust"] and found["air"]["density"] == 1.2
    assert found["settings"]["loss"] == "soft_l1"
    assert found["settings"]["weights"] == {"thrust": 2.0}
    assert found["rows"] == UIUC.omega.size
    for text in ("Parameters", "verdict", "Residuals", "1 start;", "sensitivities"):
        assert text in out


def test_priors_fixed_values_and_bootstrap(run: Run, tunnel_csv: Path) -> None:
    found, out = fitted(
        run, "tunnel", "apc-8x6e", tunnel_csv, *QUICK,
        "--fix", "c_d0=0.015", "--prior", "c_l1=5.0:0.2", "--bootstrap", "3",
    )  # fmt: skip
    assert found["fixed"] == {"c_d0": 0.015}
    assert parameter_set("out.toml").c_d0 == 0.015
    assert found["parameters"]["c_l1"]["prior"] == [5.0, 0.2]
    assert (
        found["parameters"]["c_l1"]["bootstrap_low_95"]
        <= (found["parameters"]["c_l1"]["bootstrap_high_95"])
    )
    assert "bootstrap" in out


def test_another_set_gives_what_is_not_free(run: Run, tunnel_csv: Path) -> None:
    base = ["--airfoil", "paper-apc"]
    found, _ = fitted(run, "tunnel", "apc-8x6e", tunnel_csv, *QUICK, *base)
    want = parameter_set("paper-apc")
    assert found["parameters"]["c_l1"]["start"] == want.c_l1
    assert parameter_set("out.toml").alpha_0 == want.alpha_0


@pytest.mark.parametrize(("speed", "says"), [(0.0, "from hover"), (7.0, "one speed, 7.0 to 7.0")])
def test_a_narrow_range_of_speeds_is_said_in_words(
    run: Run, tmp_path: Path, speed: float, says: str
) -> None:
    rows = "".join(f"{rpm},{speed},0,{5e-8 * rpm**2}\n" for rpm in range(4000, 7000, 300))
    (tmp_path / "narrow.csv").write_text("rpm,speed_mps,beta_deg,thrust_N\n" + rows)
    found, out = fitted(run, "tunnel", "apc-8x6e", tmp_path / "narrow.csv", *QUICK)
    assert any(says in remark for remark in found["remarks"])
    assert f"note: all data are from {says.removeprefix('from ')}" in out


def test_what_a_poor_fit_leaves_out_is_noted(
    run: Run, monkeypatch: pytest.MonkeyPatch, tunnel_csv: Path
) -> None:
    # Other fits here do not look for it.
    monkeypatch.setattr("propmap.fit.comparison.POOR", 0.03)
    found, out = fitted(run, "tunnel", "apc-8x6e", tunnel_csv, *QUICK)
    told = "c_d0 = 0.01, the constant drag, does not hold"
    assert any(told in remark for remark in found["remarks"])
    assert f"note: {told}" in " ".join(out.split())


def test_check_as_json(run: Run, tunnel_fit: Path, tunnel_csv: Path) -> None:
    done = run("check", tunnel_fit, tunnel_csv, "--format", "json")
    assert (done.code, done.err) == (0, "")
    found = json.loads(done.out)
    assert set(found) == {"corrections", "rows", "loads"}
    assert found["corrections"] == ["pitt-peters", "radial-friction"] and found["rows"] == 14
    assert set(found["loads"]) == {"thrust_N", "torque_Nm"}
    for name, load in found["loads"].items():
        assert set(load) == CHECKED | {"by_speed", "by_envelope", "in_band"}
        # Nothing of its own data is beyond them.
        assert load["by_envelope"] == {INSIDE: {key: load[key] for key in CHECKED}}
        assert sum(band["rows"] for band in load["by_speed"].values()) == 14
        assert all(set(band) == CHECKED for band in load["by_speed"].values())
        # The data of the fit itself.
        residual = fit_record(tunnel_fit)["residuals"][name.partition("_")[0]]
        assert load["rms"] == pytest.approx(residual["rms"], rel=0.02)
        assert load["bias"] == pytest.approx(residual["bias"], rel=0.1)


def test_check_tells_errors_beyond_the_training_apart(
    run: Run, tmp_path: Path, tunnel_fit: Path, tunnel_csv: Path
) -> None:
    known = read_fit(tunnel_fit).record.envelope
    assert known is not None and known.percentiles == (0.0, 100.0)
    assert known.edgewise_ratio == (0.0, 0.0) and known.climb_ratio == known.advance_ratio
    # Twice the speed of the fastest row, with loads that are wrong by far.
    rpm, speed = ONE_SPEED, 2.0 * float(UIUC.speed[picked()].max())
    (tmp_path / "more.csv").write_text(f"{tunnel_csv.read_text()}{rpm},{speed},0,1.0,0.01\n")
    arguments = ["check", tunnel_fit, "more.csv"]
    done = run(*arguments, "--format", "json")
    assert done.err.startswith("note: 6.7% of the rows lie beyond the data of the fit: V")
    assert "rotor speed" not in done.err and "V cos(beta)/(Omega R) up to" in done.err
    thrust = json.loads(done.out)["loads"]["thrust_N"]
    apart = thrust["by_envelope"]
    assert (apart[INSIDE]["rows"], apart[OUTSIDE]["rows"]) == (14, 1)
    assert apart[OUTSIDE]["rms"] == pytest.approx(abs(thrust["worst"]))
    own = fit_record(tunnel_fit)["residuals"]["thrust"]["rms"]
    assert apart[INSIDE]["rms"] == pytest.approx(own, rel=0.02)
    rows = list(csv.DictReader(io.StringIO(run(*arguments, "--format", "csv").out)))
    assert [r["band"] for r in rows if r["load"] == "thrust_N"][:3] == ["all", INSIDE, OUTSIDE]
    assert INSIDE in run(*arguments).out
    # An earlier version wrote no envelope: nothing is said.
    (tmp_path / "old.toml").write_text(tunnel_fit.read_text().partition("[fit.envelope]")[0])
    old = run("check", "old.toml", "more.csv", "--format", "json")
    assert (old.code, old.err) == (0, "")
    assert json.loads(old.out)["loads"]["thrust_N"]["by_envelope"] == {}


def test_check_as_csv_table_and_file(
    run: Run, tmp_path: Path, tunnel_fit: Path, tunnel_csv: Path
) -> None:
    arguments = ["check", tunnel_fit, tunnel_csv]
    rows = list(csv.DictReader(io.StringIO(run(*arguments, "--format", "csv").out)))
    assert set(rows[0]) == CHECKED | {"load", "band"}
    assert [row["load"] for row in rows if row["band"] == "all"] == ["thrust_N", "torque_Nm"]
    out = run(*arguments).out
    for text in ("thrust_N", "torque_Nm", "hover model's rms", "all", "m/s"):
        assert text in out
    written = run(*arguments, "-o", tmp_path / "check.json")
    assert written.code == 0 and written.out == ""
    assert json.loads((tmp_path / "check.json").read_text())["rows"] == 14


def test_check_of_a_plain_parameter_set(run: Run, tmp_path: Path, tunnel_csv: Path) -> None:
    (tmp_path / "set.toml").write_text(parameter_set("paper-apc").to_toml())
    arguments = ["check", "set.toml", tunnel_csv, "--format", "json"]
    found = json.loads(run(*arguments, "--prop", "apc-8x6e").out)
    assert found["rows"] == 14
    refused = run(*arguments)
    assert (refused.code, refused.out) == (2, "")
    assert "the file has no table [fit]; add --prop NAME" in refused.err
