"""`propmap fit tunnel`, `fit static` and `check`: files in, a fit file and its errors out."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.catalogue.identified import PARAMETERS
from propmap.cli.fit import FitChoice, section_prior
from propmap.fit.comparison import INSIDE, OUTSIDE
from propmap.fit.files import read_fit
from propmap.fit.least_squares import FINAL_EVALUATIONS
from propmap.fit.parameters import Choice
from propmap.model.airfoil import Airfoil, parameter_set

from .conftest import Run
from .fit_inputs import CHECKED, FREE, QUICK, STAND, TURNS, UIUC, fit_record, fitted, picked

pytestmark = pytest.mark.usefixtures("brief")
WHOLE = FINAL_EVALUATIONS  # of a fit that is not brief


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
    assert {name: one["rows"] for name, one in found["residuals"].items()} == {
        "thrust": 14, "torque": 14
    }  # fmt: skip
    law = parameter_set(tunnel_fit)
    assert law.name == "tunnel_fit"
    assert all(getattr(law, name) == found["parameters"][name]["value"] for name in FREE)


def uiuc_files(folder: Path) -> list[Path]:
    """Rows in the layout of the UIUC database."""
    diameter = propmap.propeller("apc-8x6e").diameter
    size = UIUC.air_density * TURNS**2 * diameter**4
    ct, cp = UIUC.loads["thrust"] / size, UIUC.loads["torque"] * 2.0 * np.pi / (size * diameter)
    rows = picked()
    flying, static = rows[UIUC.speed[rows] > 0.0], rows[UIUC.speed[rows] == 0.0]
    columns = (UIUC.speed / (TURNS * diameter), ct, cp, 0.0 * ct + 0.5)
    files = [folder / f"sample_8x6_{n}.txt" for n in (f"{TURNS[rows[0]] * 60.0:.0f}", "static")]
    moving = np.stack(columns, axis=1)[flying]
    np.savetxt(files[0], moving, "%.12f", header="J CT CP eta", comments="")
    still = np.stack((TURNS * 60.0, ct, cp), axis=1)[static]
    np.savetxt(files[1], still, "%.12f", header="RPM CT CP", comments="")
    return files


def test_uiuc_files_are_the_same_rows(run: Run, tmp_path: Path, tunnel_fit: Path) -> None:
    files = uiuc_files(tmp_path)
    found, _ = fitted(run, "tunnel", "apc-8x6e", *files, *QUICK)
    assert [d["file"] for d in found["data"]] == [path.name for path in files]
    assert found["rows"] == 28
    for name in FREE:
        want = fit_record(tunnel_fit)["parameters"][name]["value"]
        # The rpm in the file's name is rounded.
        assert found["parameters"][name]["value"] == pytest.approx(want, rel=1e-3)


def test_data_by_name_and_every_option(run: Run) -> None:
    asked = ["--loads", "thrust", "--weight", "thrust=2", "--rho", "1.2", "--robust"]
    asked += ["--airfoil", "paper-apc", "--fix", "c_d0=0.015", "--prior", "zero_lift_angle=0:0.2"]
    found, out = fitted(run, "tunnel", "apc-8x6e", "UIUC-8x6e", *QUICK, *asked, "--bootstrap", "3")
    assert found["data"] == [{"catalogue": "uiuc-8x6e"}]
    assert found["settings"]["loads"] == ["thrust"] and found["air"]["density"] == 1.2
    assert found["settings"]["loss"] == "soft_l1"
    assert found["settings"]["weights"] == {"thrust": 2.0}
    assert found["rows"] == UIUC.omega.size
    for text in ("Parameters", "verdict", "Residuals", "1 start;", "sensitivities", "bootstrap"):
        assert text in out
    want = parameter_set("paper-apc")
    assert found["parameters"]["c_l1"]["start"] == want.c_l1
    assert parameter_set("out.toml").alpha_0 == want.alpha_0
    assert found["fixed"]["c_d0"] == parameter_set("out.toml").c_d0 == 0.015
    assert found["parameters"]["zero_lift_angle"]["prior"] == [0.0, 0.2]
    drawn = [found["parameters"]["c_l1"][f"bootstrap_{end}_95"] for end in ("low", "high")]
    assert drawn[0] <= drawn[1]


def test_a_narrow_range_of_speeds_and_what_a_poor_fit_leaves_out_are_noted(
    run: Run, monkeypatch: pytest.MonkeyPatch, tunnel_csv: Path
) -> None:
    rows = "".join(f"{rpm},7,0,{5e-8 * rpm**2}\n" for rpm in range(4000, 7000, 300))
    Path("narrow.csv").write_text("rpm,speed_mps,beta_deg,thrust_N\n" + rows)
    found, out = fitted(run, "tunnel", "apc-8x6e", "narrow.csv", *QUICK)
    says = "all data are from one speed, 7.0 to 7.0"
    assert any(says in remark for remark in found["remarks"]) and f"note: {says}" in out
    # Other fits here do not look for it.
    monkeypatch.setattr("propmap.fit.comparison.POOR", 0.03)
    found, out = fitted(run, "tunnel", "apc-8x6e", tunnel_csv, *QUICK)
    told = "wrong assumption: c_d0 = 0.01, the constant drag"
    assert any(told in remark for remark in found["remarks"])
    assert f"note: {told}" in " ".join(out.split())


def test_check_in_every_format(run: Run, tunnel_fit: Path, tunnel_csv: Path) -> None:
    arguments = ["check", tunnel_fit, tunnel_csv]
    done = run(*arguments, "--format", "json")
    assert (done.code, done.err) == (0, "")
    found = json.loads(done.out)
    assert set(found) == {"corrections", "rows", "loads"}
    assert found["corrections"] == ["pitt-peters", "radial-friction", "installed"]
    assert found["rows"] == 14
    assert set(found["loads"]) == {"thrust_N", "torque_Nm"}
    for name, load in found["loads"].items():
        assert set(load) == CHECKED | {"by_speed", "by_envelope", "in_band"}
        # The data of the fit lie inside its envelope.
        assert load["by_envelope"] == {INSIDE: {key: load[key] for key in CHECKED}}
        assert sum(band["rows"] for band in load["by_speed"].values()) == 14
        # The data of the fit itself.
        assert load["in_band"] >= 13.0 / 14.0
        residual = fit_record(tunnel_fit)["residuals"][name.partition("_")[0]]
        assert load["rms"] == pytest.approx(residual["rms"], rel=0.02)
        assert load["bias"] == pytest.approx(residual["bias"], rel=0.1)
    rows = list(csv.DictReader(io.StringIO(run(*arguments, "--format", "csv").out)))
    assert [row["load"] for row in rows if row["band"] == "all"] == ["thrust_N", "torque_Nm"]
    assert "hover model's rms" in run(*arguments).out
    assert run(*arguments, "-o", "check.json").out == ""
    assert Path("check.json").read_text() == done.out


def test_check_tells_errors_beyond_the_training_apart(
    run: Run, tmp_path: Path, tunnel_fit: Path, tunnel_csv: Path
) -> None:
    known = read_fit(tunnel_fit).record.envelope
    assert known is not None and known.percentiles == (0.0, 100.0)
    assert known.edgewise_ratio == (0.0, 0.0) and known.climb_ratio == known.advance_ratio
    # Twice the speed of the fastest row, with loads that are wrong by far.
    rpm, speed = TURNS[picked()[0]] * 60.0, 2.0 * float(UIUC.speed[picked()].max())
    (tmp_path / "more.csv").write_text(f"{tunnel_csv.read_text()}{rpm},{speed},0,1.0,0.01\n")
    arguments = ["check", tunnel_fit, "more.csv"]
    done = run(*arguments, "--format", "json")
    assert done.err.startswith("note: 6.7% of the rows are outside the fitted data: V")
    assert "rotor speed" not in done.err and "V cos(beta)/(Omega R) up to" in done.err
    thrust = json.loads(done.out)["loads"]["thrust_N"]
    apart = thrust["by_envelope"]
    assert (apart[INSIDE]["rows"], apart[OUTSIDE]["rows"]) == (14, 1)
    assert apart[OUTSIDE]["rms"] == pytest.approx(abs(thrust["worst"]))
    rows = list(csv.DictReader(io.StringIO(run(*arguments, "--format", "csv").out)))
    assert [r["band"] for r in rows if r["load"] == "thrust_N"][:3] == ["all", INSIDE, OUTSIDE]
    assert INSIDE in run(*arguments).out


PROP = ["--prop", "apc-8x6e"]
NARROW = ["--free", "c_l1,zero_lift_angle", "--prior-from", "family"]


def test_a_stand_narrows_what_the_family_leaves_open(run: Run) -> None:
    Path("stand.csv").write_text(STAND)
    done = run("fit", "static", "stand.csv", *PROP, "-o", "fit.toml")
    assert done.code == 0
    note, wrote = done.err.splitlines()
    source = "16 propellers of the family apce"
    assert note.startswith(f"note: the prior of the section constants is from {source}")
    assert "without the catalogue constants of" in note and "--prior-from none" in note
    assert wrote == "wrote fit.toml"
    found = fit_record(Path("fit.toml"))
    assert found["free"] == list(PARAMETERS)
    assert any(source in text for text in found["remarks"])
    law = parameter_set("fit.toml")
    assert 4.5 < law.c_l1 < 7.0 and law.zero_lift_angle < 0.0 and 1.0 < law.c_d < 5.0
    for name, told in found["parameters"].items():
        mean, deviation = told["prior"]
        assert "times that of the prior" in told["verdict"]
        assert abs(told["value"] - mean) < 3.0 * deviation, name
    told = [(int(a), int(b)) for a, b in re.findall(r"(\d+)% -> (\d+)%", done.out)]
    assert len(told) >= 10
    (before, after), *_ = told  # thrust at rest
    assert 6 <= before <= 16 and after <= 4
    assert all(after <= before + 2 for before, after in told)
    moving = [after for _, after in told[2:8:2]]  # thrust at J = 0.2, 0.4, 0.6 along the axis
    assert moving == sorted(moving)
    # Edgewise at J = 0.6, the error of the theory in oblique flow is 9 % of the thrust.
    assert 9 <= told[12][1] <= 11


def test_uiuc_s_static_files_and_no_file_to_write(run: Run, tmp_path: Path) -> None:
    flying, static = uiuc_files(tmp_path)
    assert "--prop" in run("fit", "static", static).err
    done = run("fit", "static", static, *PROP, *NARROW)
    assert done.code == 0 and "wrote" not in done.err and "sd before -> after" in done.out
    refused = run("fit", "static", flying, *PROP)
    assert refused.code == 2 and "propmap fit tunnel" in refused.err


FIVE = ("c_l1", "c_l2", "c_d", "alpha_0", "zero_lift_angle")


def chosen(wanted: str | None = None, base: Airfoil | None = None, **stated: Any) -> Choice:
    """As `fit tunnel` chooses."""
    asked = FitChoice(prior_from=wanted, **stated)
    expected = asked.expected("apc-8x6e", propmap.propeller("apc-8x6e"), base)
    return asked.chosen(FIVE, base, expected=expected)


def test_whoever_says_what_to_fit_gets_that_and_no_more() -> None:
    choice = chosen()
    assert choice.free == PARAMETERS
    # The search starts at the most likely constants.
    assert np.abs(choice.prior_residuals(choice.first)[0]).max() < 1e-9
    four = chosen(free="c_l1,c_l2,c_d,alpha_0")
    assert four == Choice()
    assert four.first.tolist() == [2.0 * np.pi, 2.0, 0.0, 0.47]
    law = parameter_set("paper-apc")
    based = chosen(base=law)
    assert based.expected is None and based.free == FIVE and based.fixed["c_d0"] == law.c_d0
    assert chosen("none").free == FIVE and chosen("none").fixed == {}


def test_what_is_stated_wins_over_the_prior() -> None:
    choice = chosen(fix=["c_d=1.5"], prior=["c_l2=1.9:0.2", "c_l1=5:0.1"])
    assert "c_d" not in choice.free and choice.fixed["c_d"] == 1.5
    assert "c_l2" in choice.free and "c_l2" not in choice.fixed
    told = choice.prior_of("c_l1")
    assert told is not None and (told.mean, told.deviation) == (5.0, 0.1)
    few = chosen("family", free="c_l1", base=parameter_set("paper-apc"))
    assert few.expected is not None and few.fixed["c_l2"] == parameter_set("paper-apc").c_l2


def test_whose_prior() -> None:
    for wanted, prop, says in (
        ("family", "uiuc-apcsf-10x7", "of the family apcsf"),
        ("family", "my-blade.csv", "small propellers of all families"),
        ("gwsdd", "my-blade.csv", "13 propellers of the family gwsdd"),
        (" Family", "apc-8x6e", "without the catalogue constants of"),
    ):
        blade = None if prop == "my-blade.csv" else propmap.propeller(prop)
        prior = section_prior(wanted, prop, blade, by_default=False)
        assert prior is not None and says in prior.source


@pytest.mark.slow
def test_thrust_alone_at_low_speed_leaves_physical_constants(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    """APC 8x4.5MR at 0 and 5 m/s, Davoudi & Duraisamy 2019: without a prior the fit ends at c_l1
    above 10 and c_d = 0, and extrapolates badly."""
    monkeypatch.setattr("propmap.fit.least_squares.FINAL_EVALUATIONS", WHOLE)
    quick = ["--starts", "1", "--folds", "0", "-o", "fit.toml"]
    done = run("fit", "tunnel", "apc-8x4.5mr", "davoudi-8x4.5mr-thrust", *quick)
    assert done.code == 0
    said = "note: the prior of the section constants is from small propellers of all families"
    assert said in done.err
    law, found = parameter_set("fit.toml"), fit_record(Path("fit.toml"))
    assert 4.0 < law.c_l1 < 8.0 and 1.0 < law.c_d < 5.0
    assert 0.2 < law.alpha_0 < 0.4 and -0.1 < law.zero_lift_angle < 0.01 and 0.0 < law.c_d0 < 0.05
    held = [n for n, p in found["parameters"].items() if "by its prior" in p["verdict"]]
    # Thrust tells of lift, not of drag; how far the blade is turned is not known to a degree.
    assert {"c_d", "c_d0", "alpha_0"} <= set(held) and "zero_lift_angle" not in held
