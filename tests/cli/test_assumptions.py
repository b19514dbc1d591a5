"""No figure of an aircraft without what it rests on: five vehicle files, by every command."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import xarray

from .conftest import Run
from .test_aircraft import BARE, POWERED

EXAMPLES = Path(__file__).parents[2] / "examples" / "aircraft"
COAXIAL = BARE.replace('"apc-8x6e"', '"apc-11x7e"') + "".join(
    f'[[rotors]]\nposition = [{x}, {y}, -0.08]\nspin = "{spin}"\n'
    for x, y, spin in ((0.16, 0.16, "ccw"), (-0.16, 0.16, "cw"),
                       (-0.16, -0.16, "ccw"), (0.16, -0.16, "cw"))
)  # fmt: skip
FILES = {
    "bare": (BARE, ["no body drag", "shaft power (no [motor])", "; no wakes"]),
    "mounted": (
        POWERED.replace("[esc]\nefficiency = 0.95\n", "") + "[mount]\narea = 0.0008\n",
        ["body drag 0.015 m^2 ahead", "lossless speed controllers", "drag of [mount]"],
    ),
    "delivery": (
        (EXAMPLES / "delivery.toml").read_text(encoding="utf-8"),
        ["body drag 0.03 m^2 ahead", "electrical power", "installed rotors", "11x4.7 identified"],
    ),
    "tailsitter": (
        (EXAMPLES / "tailsitter.toml").read_text(encoding="utf-8"),
        ["body drag 0.25 m^2 ahead", "air 1.225 kg/m^3"],
    ),
    "coaxial": (
        COAXIAL, ["no body drag", "8 rotors above each other: lower ones in slipstreams"]
    ),
}  # fmt: skip
FAST = ["--speed", "5", "--no-bands"]


@pytest.fixture(params=FILES)
def said(request: pytest.FixtureRequest) -> list[str]:
    """What must be said of the file x.toml."""
    text, words = FILES[request.param]
    Path("x.toml").write_text(text, encoding="utf-8")
    return [*words, "constants: "]


def lines_of(text: str, words: list[str]) -> list[str]:
    """The lines that say something of it: two at most, and all is said."""
    found = [line for line in text.splitlines() if "assumed: " in line or "kg/m^3; con" in line]
    assert len(found) == 2 and all(any(word in line for line in found) for word in words), found
    assert all(len(line) < 160 for line in found)
    return found


def test_trim_says_what_it_rests_on(run: Run, said: list[str]) -> None:
    shown = run("trim", "x.toml", *FAST, "-o", "x.txt")
    assert shown.code == 0, shown.err
    lines_of(Path("x.txt").read_text(encoding="utf-8"), said)
    lines_of(run("trim", "x.toml", *FAST, "--format", "csv").err, said)
    told = json.loads(run("trim", "x.toml", *FAST, "--format", "json").out)["assumptions"]
    assert list(told) == [
        "body_drag", "power", "rotors", "propeller", "air", "constants", "wakes"
    ]  # fmt: skip
    assert "no [body]" in told["body_drag"] or "as given" in told["body_drag"]


@pytest.mark.slow
def test_choose_and_exports_say_it(run: Run, said: list[str]) -> None:
    here = [word for word in said if word not in ("11x4.7 identified", "; no wakes")]
    asked = ["x.toml", "--task", "hover", "--diameter", "9:9", "--blades", "3"]
    lines_of(run("choose", *asked).out, here)
    assert "propellers" in (told := json.loads(run("choose", *asked, "--format", "json").out))
    assert "body_drag" in told["assumptions"]
    lines_of(run("choose", *asked, "--format", "csv").err, here)
    written = run("export", "x.toml", "--to", "px4", "-o", "out")
    if written.code == 0:  # else it is no multirotor, or one with coaxial pairs
        lines_of(written.err, said)
        lines_of(Path("out/README-px4.md").read_text().replace("Assumed", "assumed"), said)


def test_what_depends_on_body_drag_says_so_beside_the_figure(run: Run) -> None:
    for text, missing in ((BARE, True), (POWERED, False)):
        Path("x.toml").write_text(text)
        shown = run("trim", "x.toml", "--airfoil", "apc-8x6e-2019", "--speed", "0:16:3",
                    "--no-bands").out  # fmt: skip
        figures = {line.partition(":")[0]: line for line in shown.splitlines() if ": " in line}
        for name in ("least power, longest time", "best range", "top speed"):
            assert ("without body drag" in figures[name]) is missing
        assert "without body drag" not in figures["hover"]


def test_netcdf_and_missions_carry_it(run: Run) -> None:
    Path("x.toml").write_text(POWERED)
    Path("legs.csv").write_text("speed_mps,climb_mps,duration_s\n0,2,20\n10,0,120\n")
    law = ["--airfoil", "apc-8x6e-2019"]
    run("trim", "x.toml", *law, *FAST, "-o", "x.nc")
    with xarray.open_dataset("x.nc", engine="h5netcdf") as found:
        assert found.attrs["assumed_power"] == "electrical power"
    mission = ["trim", "x.toml", *law, "--mission", "legs.csv"]
    lines_of(run(*mission).out, ["body drag 0.015 m^2 ahead"])
    assert json.loads(run(*mission, "--format", "json").out)["assumptions"]["power"]


def test_a_table_need_not_have_the_speed_that_is_tried_first(run: Run) -> None:
    """Hover is at 6444 rpm; rotors are tried at a tip speed of 60 m/s first, 5639 rpm."""
    Path("x.toml").write_text((EXAMPLES.parent / "quadrotor.toml").read_text(encoding="utf-8"))
    law = ["--airfoil", "paper-apc", "--beta", "0:180", "--tolerance", "5%"]
    for rpm, speed, code in (("6000:8000", "0:6", 0), ("5000:7000", "3:6", 2)):
        built = run("table", "apc-8x6e", *law, "--rpm", rpm, "--speed", speed, "-o", f"{code}.npz")
        assert built.code == 0, built.err
        done = run(
            "trim", "x.toml", "--table", f"{code}.npz", "--speed", "0:4:2", "--format", "csv"
        )
        assert done.code == code, done.err
        if code:
            assert "the rotors have no loads (outside); give loads that cover hover" in done.err
        else:
            assert ",6444" in done.out or "6443" in done.out
