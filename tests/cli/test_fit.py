"""`propmap fit` and `propmap check`: files in, a fit file and its errors out."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.airfoil import airfoil
from propmap.catalogue.measurements import measurement
from propmap.cli import main

from .conftest import Run

# One pair of free parameters, so that all fits here share their compiled programs.
FREE = ("c_l1", "zero_lift_angle")
QUICK = ["--free", ",".join(FREE), "--starts", "1", "--folds", "0"]
UIUC = measurement("uiuc-8x6e")
TURNS = UIUC.omega / (2.0 * np.pi)
DIAMETER = propmap.propeller("apc-8x6e").diameter
ONE_SPEED = round(float(TURNS[UIUC.speed > 0.0][0]) * 60.0)


def picked() -> np.ndarray:
    """Some rows of one rotational speed, then some static ones."""
    flying = np.flatnonzero(np.isclose(TURNS * 60.0, ONE_SPEED, atol=1.0) & (UIUC.speed > 0.0))
    return np.concatenate([flying[:9], np.flatnonzero(UIUC.speed == 0.0)[:5]])


def table(rows: np.ndarray, columns: tuple[str, ...] = ("thrust_N", "torque_Nm")) -> str:
    """Rows of the catalogue's measurement as CSV; the air has its own density."""
    assert UIUC.thrust is not None and UIUC.torque is not None
    loads = {"thrust_N": UIUC.thrust, "torque_Nm": UIUC.torque}
    density = propmap.Air().density / UIUC.air_density
    lines = [",".join(("rpm", "speed_mps", "beta_deg", *columns))]
    for k in rows:
        # Whole rpm, as in the name of a UIUC file.
        values = [TURNS[k] * 60.0, UIUC.speed[k], 0.0, *(loads[c][k] * density for c in columns)]
        lines.append(",".join(repr(float(v)) for v in values))
    return "\n".join(lines) + "\n"


def uiuc_files(folder: Path) -> list[Path]:
    """The same rows in the layout of the UIUC database."""
    assert UIUC.thrust is not None and UIUC.torque is not None
    size = UIUC.air_density * TURNS**2 * DIAMETER**4
    ct, cp = UIUC.thrust / size, UIUC.torque * 2.0 * np.pi / (size * DIAMETER)
    rows = picked()
    flying, static = rows[UIUC.speed[rows] > 0.0], rows[UIUC.speed[rows] == 0.0]
    advance = UIUC.speed / (TURNS * DIAMETER)
    first = ["J CT CP eta", *(f"{advance[k]:.12f} {ct[k]:.12f} {cp[k]:.12f} 0.5" for k in flying)]
    second = ["RPM CT CP", *(f"{TURNS[k] * 60.0:.9f} {ct[k]:.12f} {cp[k]:.12f}" for k in static)]
    names = (f"sample_8x6_{ONE_SPEED}.txt", "sample_8x6_static.txt")
    for name, lines in zip(names, (first, second), strict=True):
        (folder / name).write_text("\n".join(lines) + "\n")
    return [folder / name for name in names]


VEHICLE = """schema = 1
name = "test quadrotor"
frame = "flu"
mass = 0.93
propeller = "apc-8x6e"
""" + "".join(
    f'[[rotors]]\nposition = [{x}, {y}, 0.0]\nspin = "{spin}"\n'
    for x, y, spin in ((-0.1, -0.1, "cw"), (0.1, -0.1, "ccw"), (-0.1, 0.1, "ccw"), (0.1, 0.1, "cw"))
)
LEVEL = "speed_mps,pitch_deg,rpm_1,rpm_2,rpm_3,rpm_4\n" + "".join(
    f"{v},{0.15 * v * v},{rpm},{rpm},{rpm},{rpm}\n"
    for v, rpm in ((0, 5620), (0, 5630), (3, 5580), (6, 5500), (8, 5560), (9, 5600), (10, 5680))
)


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Data files and the fits of them that several tests look at."""
    folder = tmp_path_factory.mktemp("fit")
    (folder / "tunnel.csv").write_text(table(picked()))
    (folder / "vehicle.toml").write_text(VEHICLE)
    (folder / "level.csv").write_text(LEVEL)
    (folder / "set.toml").write_text(airfoil("paper-apc").to_toml())
    uiuc_files(folder)
    return folder


@pytest.fixture(scope="module")
def no_cache() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("propmap.compilation.keep_compiled", lambda: None)
        yield


@pytest.fixture(scope="module")
def tunnel_fit(place: Path, no_cache: None) -> Path:  # noqa: ARG001
    fit = place / "tunnel_fit.toml"
    arguments = ["fit", "tunnel", "apc-8x6e", str(place / "tunnel.csv"), *QUICK, "-o", str(fit)]
    assert main(arguments) == 0
    return fit


@pytest.fixture(scope="module")
def level_fit(place: Path, no_cache: None) -> Path:  # noqa: ARG001
    fit = place / "level_fit.toml"
    vehicle = ["--vehicle", str(place / "vehicle.toml")]
    level = [str(place / "level.csv"), "--method", "level", "--body-study"]
    assert main(["fit", "flight", *level, *vehicle, *QUICK, "-o", str(fit)]) == 0
    return fit


def record(path: Path) -> dict[str, Any]:
    return tomllib.loads(path.read_text(encoding="utf-8"))["fit"]


def test_the_file_carries_what_repeats_the_fit(tunnel_fit: Path, place: Path) -> None:
    found = record(tunnel_fit)
    data = (place / "tunnel.csv").read_bytes()
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
    law = airfoil(tunnel_fit)
    found = record(tunnel_fit)["parameters"]
    assert law.c_l1 == found["c_l1"]["value"]
    assert law.zero_lift_angle == found["zero_lift_angle"]["value"]
    assert law.name == "tunnel_fit"
    done = run(
        "predict", "apc-8x6e", "--airfoil", tunnel_fit,
        "--rpm", "5000", "--speed", "0", "--beta", "0", "--format", "json",
    )  # fmt: skip
    assert (done.code, done.err) == (0, "")
    rotor = propmap.Rotor(propmap.propeller("apc-8x6e"), law)
    expected = rotor.loads(5000.0 * np.pi / 30.0, 0.0, 0.0)
    assert json.loads(done.out)["thrust_N"] == pytest.approx(float(expected.thrust))


def fitted(run: Run, tmp_path: Path, *arguments: object) -> tuple[dict[str, Any], str]:
    fit = tmp_path / "out.toml"
    done = run("fit", *arguments, "-o", fit)
    assert (done.code, done.err) == (0, f"wrote {fit}\n"), done.err
    return record(fit), done.out


def test_uiuc_files_are_the_same_rows(
    run: Run, tmp_path: Path, place: Path, tunnel_fit: Path
) -> None:
    files = uiuc_files(tmp_path)
    found, _ = fitted(run, tmp_path, "tunnel", "apc-8x6e", *files, *QUICK)
    assert [d["file"] for d in found["data"]] == [path.name for path in files]
    assert found["rows"] == 28
    for name in FREE:
        want = record(tunnel_fit)["parameters"][name]["value"]
        # The rpm in the file's name is rounded.
        assert found["parameters"][name]["value"] == pytest.approx(want, rel=1e-3)
    assert place.is_dir()


def test_by_name_of_the_catalogue(run: Run, tmp_path: Path) -> None:
    arguments = ["--loads", "thrust", "--weight", "thrust=2", "--rho", "1.2", "--robust"]
    found, out = fitted(run, tmp_path, "tunnel", "apc-8x6e", "UIUC-8x6e", *QUICK, *arguments)
    assert found["data"] == [{"catalogue": "uiuc-8x6e"}]
    assert found["settings"]["loads"] == ["thrust"] and found["air"]["density"] == 1.2
    assert found["settings"]["loss"] == "soft_l1"
    assert found["settings"]["weights"] == {"thrust": 2.0}
    assert found["rows"] == UIUC.omega.size
    for text in ("Parameters", "verdict", "Residuals", "1 starts, 1 of them", "sensitivities"):
        assert text in out


def test_priors_fixed_values_and_bootstrap(run: Run, tmp_path: Path, place: Path) -> None:
    found, out = fitted(
        run, tmp_path, "tunnel", "apc-8x6e", place / "tunnel.csv", *QUICK,
        "--fix", "c_d0=0.015", "--prior", "c_l1=5.0:0.2", "--bootstrap", "3",
    )  # fmt: skip
    assert found["fixed"] == {"c_d0": 0.015}
    assert airfoil(tmp_path / "out.toml").c_d0 == 0.015
    assert found["parameters"]["c_l1"]["prior"] == [5.0, 0.2]
    assert (
        found["parameters"]["c_l1"]["bootstrap_low_95"]
        <= (found["parameters"]["c_l1"]["bootstrap_high_95"])
    )
    assert "bootstrap" in out


def test_another_set_gives_what_is_not_free(run: Run, tmp_path: Path, place: Path) -> None:
    base = ["--airfoil", "paper-apc"]
    found, _ = fitted(run, tmp_path, "tunnel", "apc-8x6e", place / "tunnel.csv", *QUICK, *base)
    want = airfoil("paper-apc")
    assert found["parameters"]["c_l1"]["start"] == want.c_l1
    assert airfoil(tmp_path / "out.toml").alpha_0 == want.alpha_0


@pytest.mark.parametrize(("speed", "says"), [(0.0, "from hover"), (7.0, "one speed, 7.0 to 7.0")])
def test_a_narrow_range_of_speeds_is_said_in_words(
    run: Run, tmp_path: Path, speed: float, says: str
) -> None:
    rows = "".join(f"{rpm},{speed},0,{3e-8 * rpm**2}\n" for rpm in range(4000, 7000, 300))
    (tmp_path / "narrow.csv").write_text("rpm,speed_mps,beta_deg,thrust_N\n" + rows)
    found, out = fitted(run, tmp_path, "tunnel", "apc-8x6e", tmp_path / "narrow.csv", *QUICK)
    assert any(says in remark for remark in found["remarks"])
    assert f"note: all data are from {says.removeprefix('from ')}" in out


KEYS = {"rows", "rms", "relative_rms", "bias", "worst", "hover_rms"}


def test_check_as_json(run: Run, tunnel_fit: Path, place: Path) -> None:
    done = run("check", tunnel_fit, place / "tunnel.csv", "--format", "json")
    assert (done.code, done.err) == (0, "")
    found = json.loads(done.out)
    assert set(found) == {"rows", "loads"} and found["rows"] == 14
    assert set(found["loads"]) == {"thrust_N", "torque_Nm"}
    for name, load in found["loads"].items():
        assert set(load) == KEYS | {"by_speed"}
        assert sum(band["rows"] for band in load["by_speed"].values()) == 14
        assert all(set(band) == KEYS for band in load["by_speed"].values())
        # The data of the fit itself.
        residual = record(tunnel_fit)["residuals"][name.partition("_")[0]]
        assert load["rms"] == pytest.approx(residual["rms"], rel=0.02)
        assert load["bias"] == pytest.approx(residual["bias"], rel=0.1)


def test_check_as_csv_table_and_file(
    run: Run, tmp_path: Path, tunnel_fit: Path, place: Path
) -> None:
    arguments = ["check", tunnel_fit, place / "tunnel.csv"]
    rows = list(csv.DictReader(io.StringIO(run(*arguments, "--format", "csv").out)))
    assert set(rows[0]) == KEYS | {"load", "band"}
    assert [row["load"] for row in rows if row["band"] == "all"] == ["thrust_N", "torque_Nm"]
    out = run(*arguments).out
    for text in ("thrust_N", "torque_Nm", "hover model's rms", "all", "m/s"):
        assert text in out
    written = run(*arguments, "-o", tmp_path / "check.json")
    assert written.code == 0 and written.out == ""
    assert json.loads((tmp_path / "check.json").read_text())["rows"] == 14


def test_check_of_a_plain_parameter_set(run: Run, place: Path) -> None:
    arguments = ["check", place / "set.toml", place / "tunnel.csv", "--format", "json"]
    found = json.loads(run(*arguments, "--prop", "apc-8x6e").out)
    assert found["rows"] == 14
    refused = run(*arguments)
    assert (refused.code, refused.out) == (2, "")
    assert "the file has no table [fit]; add --prop NAME" in refused.err


def test_a_level_table(level_fit: Path, place: Path) -> None:
    found = record(level_fit)
    assert found["kind"] == "level flight" and found["rows"] == 7
    names = [d["file"] for d in found["data"]]
    assert names == ["level.csv", "vehicle.toml"]
    assert set(found["residuals"]) == {"vertical_force"}
    assert found["settings"]["vehicle"] == "test quadrotor"
    # Numbers made up near the hover of paper-apc.
    assert found["residuals"]["vertical_force"]["relative_rms"] < 0.1
    assert place.is_dir()


def test_the_body_study_says_whether_its_terms_earn_their_place(level_fit: Path) -> None:
    told = [text for text in record(level_fit)["remarks"] if "place" in text]
    assert len(told) == 2
    assert told[0].startswith("lift_area ") and told[1].startswith("drag_area_x ")
    assert all("earn its place" in t or "earns its place" in t for t in told)
    assert all("m^2" in t and "residuals" in t for t in told)


def turning_log(folder: Path, count: int = 200) -> Path:
    """Two seconds of changing speed at 100 Hz, and the vehicle file with its columns."""
    time = np.arange(count) / 100.0
    speed = 2.0 + 4.0 * time
    half = 0.05 + 0.02 * time
    lines = ["t,vx,vy,vz,p,q,r,ax,ay,az,qw,qx,qy,qz,m1,m2,m3,m4"]
    for k in range(count):
        v = (speed[k] * np.cos(2 * half[k]), 0.0, speed[k] * np.sin(2 * half[k]))
        numbers = [time[k], *v, 0.0, 0.04, 0.0, 0.2, 0.0, 9.8]
        numbers += [np.cos(half[k]), 0.0, np.sin(half[k]), 0.0, *(4 * [585.0 + speed[k]])]
        lines.append(",".join(f"{number:.9g}" for number in numbers))
    (folder / "log.csv").write_text("\n".join(lines) + "\n")
    (folder / "logged.toml").write_text(
        VEHICLE
        + '[log]\nbody_frame = "flu"\nworld_frame = "enu"\nvelocity_in = "body"\n'
        + 'rotor_unit = "rad/s"\n[log.columns]\ntime = "t"\nvelocity = ["vx", "vy", "vz"]\n'
        + 'rates = ["p", "q", "r"]\nspecific_force = ["ax", "ay", "az"]\n'
        + "".join(f'{name} = "{name}"\n' for name in ("qw", "qx", "qy", "qz"))
        + 'rotor_speed = ["m1", "m2", "m3", "m4"]\n'
    )
    return folder / "log.csv"


@pytest.mark.slow
def test_without_steady_stretches_all_forces_are_fitted(run: Run, tmp_path: Path) -> None:
    log = turning_log(tmp_path)
    vehicle = ["--vehicle", tmp_path / "logged.toml"]
    free = ["--free", ",".join((*FREE, "drag_area_x")), "--starts", "1", "--samples", "40"]
    found, out = fitted(run, tmp_path, "flight", log, *vehicle, *free)
    assert found["kind"] == "flight" and found["rows"] == 120
    assert "fewer than 4 steady stretches of 2 s" in found["remarks"][0]
    assert "note: fewer than 4 steady stretches" in out
    checked = json.loads(run("check", "out.toml", log, *vehicle, "--format", "json").out)
    assert set(checked) == {"rows", "loads"} and checked["rows"] == 200
    assert set(checked["loads"]) == {"force_x_N", "force_y_N", "force_z_N"}
    assert set(checked["loads"]["force_z_N"]) == KEYS | {"by_speed"}
    refused = run("fit", "flight", log, *vehicle, *free, "--method", "level", "-o", "no.toml")
    assert refused.code == 2 and "no steady stretch of 2 s" in refused.err
    assert not (tmp_path / "no.toml").exists()


HEADER = "rpm,speed_mps,beta_deg,thrust_N\n"
ROW = "5000,5,0,1.5\n"
LEVEL_HEADER = LEVEL.partition("\n")[0] + "\n"
FILES = {
    "good.csv": table(picked()),
    "no_load.csv": "rpm,speed_mps,beta_deg\n5000,5,0\n",
    "empty_load.csv": HEADER + "5000,5,0,\n5000,6,0,\n",
    "two.csv": HEADER + 2 * ROW,
    "negative.csv": HEADER + ROW + "-5000,5,0,1.5\n",
    "nan.csv": HEADER + ROW + "5000,nan,0,1.5\n",
    "nan_load.csv": HEADER + ROW + "5000,6,0,nan\n",
    "text.csv": HEADER + ROW + "5000,6,0,high\n",
    "sample_static.txt": "RPM CT CP\n3000 0.1\n",
    "sample.txt": "J CT CP eta\n0.2 0.1 0.04 0.5\n",
    "header_5000.txt": "J CT CP eta\n",
    "words_5000.txt": "J CT CP eta\n0.2 much 0.04 0.5\n",
    "set.toml": airfoil("paper-apc").to_toml(),
    "damaged.toml": airfoil("paper-apc").to_toml() + '[fit]\nkind = "tunnel"\n',
    "flat.toml": airfoil("paper-apc").to_toml() + "fit = 3\n",
    "wrong_air.toml": airfoil("paper-apc").to_toml()
    + "[fit]\nbody = 3\nwing = {}\nair = {density = 1.2, viscosity = 2e-5}\n"
    + "[fit.propeller]\nname = 'x'\nblades = 2\nroot = 0.01\nstation_m = [0.01]\n"
    + "chord_m = [0.01]\ntwist_rad = [0.1]\n",
    "broken.toml": "c_l1 = = 5\n",
    "vehicle.toml": VEHICLE,
    "level.csv": LEVEL,
    "six.csv": LEVEL_HEADER.replace("rpm_4", "rpm_4,rpm_5,rpm_6") + "0,0,1,1,1,1,1,1\n",
    "nan_level.csv": LEVEL_HEADER + "0,0,5000,5000,nan,5000\n",
    "two_level.csv": "".join(LEVEL.splitlines(keepends=True)[:3]),
}
TUNNEL = ["fit", "tunnel", "apc-8x6e"]
TO = ["-o", "out.toml"]
GOOD = [*TUNNEL, "good.csv", *TO]
FLIGHT = ["fit", "flight", "--vehicle", "vehicle.toml", *TO]
CASES: list[tuple[list[str], str]] = [
    ([*GOOD, "--free", "c_l1,alpha"], "'alpha' is not a parameter; choose from alpha_0"),
    ([*GOOD, "--free", ""], "'' is not a parameter"),
    ([*GOOD, "--free", "c_l1,c_l1"], "c_l1 is named twice"),
    ([*GOOD, "--free", "c_l1,lift_area"], "lift_area has no part in a tunnel test"),
    ([*GOOD, "--free", "c_l1,drag_factor"], "add drag to the loads"),
    ([*GOOD, "--fix", "c_d0"], "--fix 'c_d0' has no '='; write --fix c_l1=6.0"),
    ([*GOOD, "--fix", "c_d0=small"], "--fix c_d0: 'small' is not a number"),
    ([*GOOD, "--fix", "c_d0=nan"], "c_d0 is nan"),
    ([*GOOD, "--fix", "c_l1=5"], "c_l1 is both free and fixed"),
    ([*GOOD, "--fix", "c_d0=0.5"], "give a value from 0 to 0.2"),
    ([*GOOD, "--fix", "cd0=0.01"], "choose from c_d0"),
    ([*GOOD, "--prior", "c_l2=2.0"], "--prior c_l2 has no deviation; write --prior c_l2=2.0:0.3"),
    ([*GOOD, "--prior", "c_l2=2.0:0"], "the prior of c_l2 has the deviation 0"),
    ([*GOOD, "--prior", "c_l2=two:1"], "'two' is not a number"),
    ([*GOOD, "--prior", "c_l2=nan:1"], "the prior of c_l2"),
    ([*GOOD, "--prior", "c_d0=0.01:0.01"], "c_d0 has a prior but is not free"),
    ([*GOOD, "--loads", "drag"], "good.csv has no drag; fit thrust, torque"),
    ([*GOOD, "--loads", "thrust,lift"], "'lift' is not a load; choose from thrust"),
    ([*GOOD, "--weight", "thrust"], "--weight 'thrust' has no number; write --weight thrust=2"),
    ([*GOOD, "--weight", "thrust=0"], "the weight of thrust is 0; give a number above 0"),
    ([*GOOD, "--weight", "thurst=2"], "'thurst' has a weight but is not fitted; fit thrust"),
    ([*GOOD, "--loads", "thrust,thrust"], "thrust is named twice"),
    ([*GOOD, "--starts", "0"], "'--starts'"),
    ([*GOOD, "--rho", "-1"], "density"),
    ([*TUNNEL, "good.csv"], "output"),
    ([*TUNNEL, "good.csv", "-o", "out.csv"], ".toml"),
    ([*TUNNEL, "good.csv", "-o", "nowhere/out.toml"], "nowhere"),
    ([*TUNNEL, "good.csv", *TO, "--picture", "out.bmp"], ".png"),
    (["fit", "tunnel", "apc-8x6f", "good.csv", *TO], "apc-8x6e"),
    ([*TUNNEL, "nowhere.csv", *TO], "neither a file nor a measurement of the catalogue"),
    ([*TUNNEL, "uiuc-8x6", *TO], "uiuc-8x6e"),
    ([*TUNNEL, "no_load.csv", *TO], "there is no column with a load; add one of thrust_N"),
    ([*TUNNEL, "empty_load.csv", *TO], "empty_load.csv has no thrust"),
    ([*TUNNEL, "two.csv", *TO], "2 measured numbers for 5 free parameters"),
    ([*TUNNEL, "negative.csv", *TO], "line 3, column rpm: -5000 is negative"),
    ([*TUNNEL, "nan.csv", *TO], "line 3, column speed_mps: nan is not a finite"),
    ([*TUNNEL, "nan_load.csv", *TO], "line 3, column thrust_N: nan is not a finite"),
    ([*TUNNEL, "text.csv", *TO], "'high' is not a number"),
    ([*TUNNEL, "sample.txt", *TO], "the rotational speed is not in the file's name"),
    ([*TUNNEL, "sample_static.txt", *TO], "line 2: found 2 numbers, expected 3"),
    ([*TUNNEL, "header_5000.txt", *TO], "no row below the header"),
    ([*TUNNEL, "words_5000.txt", *TO], "words_5000.txt, line 2"),
    (["check", "set.toml", "good.csv"], "add --prop NAME"),
    (["check", "nowhere.toml", "good.csv"], "no such file"),
    (["check", "broken.toml", "good.csv"], "not valid TOML"),
    (["check", "damaged.toml", "good.csv"], "the table [fit] is damaged"),
    (["check", "flat.toml", "good.csv"], "fit"),
    (["check", "wrong_air.toml", "good.csv"], "wrong_air.toml"),
    (["check", "damaged.toml", "level.csv", "--vehicle", "vehicle.toml"], "is damaged"),
    (["check", "set.toml", "level.csv", "--vehicle", "vehicle.toml"], "no accelerations"),
    (["check", "set.toml", "nowhere.csv", "--prop", "apc-8x6e"], "neither a file"),
    (["check", "set.toml", "good.csv", "--prop", "apc-8x6e", "-o", "nowhere/out.json"], "nowhere"),
    (["fit", "flight", "level.csv", *TO], "vehicle"),
    ([*FLIGHT, "level.csv", "--method", "balance"], "no accelerations; fit it with --method level"),
    ([*FLIGHT, "level.csv", "--free", "c_l1,wing_c_l1"], "the vehicle has no wing"),
    ([*FLIGHT, "six.csv"], "the vehicle has 4 rotors"),
    ([*FLIGHT, "nan_level.csv"], "line 2, column rpm_3"),
    ([*FLIGHT, "two_level.csv"], "2 measured numbers for 4 free parameters"),
    ([*FLIGHT, "nowhere.csv"], "nowhere.csv"),
    ([*FLIGHT, "good.csv"], "no body_frame; add body_frame"),
    (["fit", "flight", "level.csv", "--vehicle", "nowhere.toml", *TO], "nowhere.toml"),
]


@pytest.fixture
def workplace(tmp_path: Path) -> Path:
    for name, content in FILES.items():
        (tmp_path / name).write_text(content)
    return tmp_path


@pytest.mark.parametrize(
    ("arguments", "says"), CASES, ids=[f"{i}-{case[1]}" for i, case in enumerate(CASES)]
)
def test_one_line_and_no_file(run: Run, workplace: Path, arguments: list[str], says: str) -> None:
    before = {path: path.read_bytes() for path in workplace.rglob("*")}
    done = run(*arguments)
    assert done.code == 2, done.out
    assert done.out == ""
    assert done.err.startswith("propmap: error: ")
    assert done.err.count("\n") == 1 and done.err.endswith("\n")
    assert says in done.err
    assert {path: path.read_bytes() for path in workplace.rglob("*")} == before
