"""Each view by itself, without a browser: numbers, commands, files, and what is wrong in a line."""

from __future__ import annotations

import base64
import csv
import io
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest

import propmap as pm
from propmap.errors import InputError
from propmap.explore.app import Application, Job
from propmap.explore.session import Session, Shelf, read_path
from propmap.explore.view import OneOf, Several, Slider, View, values_of
from propmap.explore.views import VIEWS
from propmap.explore.views.constants import fit_of

from .conftest import EXAMPLES, with_file

RPM = np.pi / 30.0
BY_NAME = {view.name: view for view in VIEWS}
SLOW = ("aircraft", "loads")  # the search for steady states takes some seconds
NAMES = [pytest.param(n, marks=pytest.mark.slow) if n in SLOW else n for n in BY_NAME]


@pytest.fixture(scope="module")
def sessions(shelf: Shelf) -> dict[str, Session]:
    """One for the view that needs a file."""
    given = read_path(EXAMPLES / "aircraft" / "delivery.toml")
    return {"aircraft": Session().with_file(given, shelf.put(given))}


def _answer(session: Session, view: View, **given: Any) -> Any:
    values, remarks = values_of(view.controls(session), given)
    assert not remarks
    return values, view.answer(session, values, settled=True)


@pytest.mark.parametrize("name", NAMES)
def test_every_view_answers_with_figures_that_plotly_takes(
    sessions: dict[str, Session], name: str
) -> None:
    view, session = BY_NAME[name], sessions.get(name, Session())
    values, found = _answer(session, view)
    places = {graph.name for graph in view.graphs(session)}
    assert found.figures and set(found.figures) <= places
    assert found.tables
    for figure in found.figures.values():
        go.Figure(figure)  # raises for what Plotly does not know
    assert "propmap " in view.shell(session, values)
    compile(view.python(session, values), "copied", "exec")


@pytest.mark.slow
def test_an_aircraft_says_what_it_rests_on(shelf: Shelf, tmp_path: Path) -> None:
    text = (EXAMPLES / "aircraft" / "delivery.toml").read_text(encoding="utf-8")
    for drag, words in (("[0.030", "body drag area 0.03 m^2 along x"), ("[0.0", "no body drag")):
        given = text.replace("drag_area = [0.030, 0.035, 0.06]", f"drag_area = {drag}, 0.0, 0.0]")
        (tmp_path / "x.toml").write_text(given, encoding="utf-8")
        file = read_path(tmp_path / "x.toml")
        _, found = _answer(Session().with_file(file, shelf.put(file)), BY_NAME["aircraft"])
        assert words in found.remarks[0] and "air 1.19" in found.remarks[1]
        first, *others = ["without body drag" in row[0] for row in found.tables[0].rows[:4]]
        assert not first and set(others) == {"no body" in words}


@pytest.mark.parametrize("name", NAMES)
def test_every_control_changes_something(sessions: dict[str, Session], name: str) -> None:
    """Figures, numbers, remarks or what is copied."""
    view, session = BY_NAME[name], sessions.get(name, Session())
    controls = view.controls(session)
    before, _ = values_of(controls, {})
    if name == "loads":
        before["data"] = "none"

    def shown(values: dict[str, Any]) -> str:
        found = view.answer(session, values, settled=name == "compare")
        told = view.shell(session, values), view.python(session, values)
        return repr((found.figures, found.tables, found.remarks, told))

    first = shown(before)
    for control in controls:
        value: Any = {"angles": "0,45", "speeds": "3,6"}.get(control.name, "apc-11x7e")
        if isinstance(control, Slider):
            value = control.default + 20 * control.step
            if value > control.high:
                value = max(control.low, control.default - 20 * control.step)
        elif isinstance(control, OneOf):
            others = [key for key, _ in control.options if key != before[control.name]]
            if not others:
                continue
            value = others[-1]
        elif isinstance(control, Several):
            value = list(before[control.name])[:-1]
        changed = {**before, control.name: value}
        if control.name == "speeds":
            before_x, changed["x"] = shown({**before, "x": "beta"}), "beta"
            assert shown(changed) != before_x
            continue
        assert shown(changed) != first, control.name


def test_numbers_and_curves_are_those_of_a_rotor() -> None:
    rotor = pm.Rotor(pm.catalogue_model("apc-8x6e"))
    values, found = _answer(Session(), BY_NAME["loads"], rpm="6000", speed="12", beta="70")
    loads = rotor.loads(6000.0 * RPM, 12.0, np.radians(70.0))
    told = {row[0]: row[1:] for row in found.tables[0].rows}
    assert values["rpm"] == 6000.0
    for label, name in {"thrust": "thrust", "rolling moment": "roll_moment"}.items():
        assert told[label][0] == f"{float(getattr(loads, name)):.4g}"
        assert told[label][1] == f"± {2.0 * float(getattr(loads.std, name)):.2g}"
    _, found = _answer(Session(), BY_NAME["loads"], rpm="5000", angles="90", bands="")
    (curve,) = [t for t in found.figures["drag"]["data"] if t["name"] == "β = 90°"]
    drawn = np.frombuffer(base64.b64decode(curve["y"]["bdata"]), np.float64)
    want = rotor.loads(5000.0 * RPM, np.linspace(0.0, 20.0, 31), np.pi / 2.0).drag
    np.testing.assert_allclose(drawn, want, rtol=1e-12)


def test_equal_thrust_is_equal_or_missing_with_the_reason() -> None:
    """At 100 rpm and 20 m/s the first propeller brakes more than the second can."""
    view, session = BY_NAME["compare"], Session()
    for given, lost in (({"rpm": "5000", "b": "apc 20x10e"}, 0), ({"rpm": "100"}, 27)):
        values, found = _answer(session, view, equal="thrust", **given)
        rows = list(csv.DictReader(io.StringIO(view.text(session, values, "compare.csv"))))
        first, second = rows[:31], rows[31:]
        gaps = [row["thrust_N"] == "" for row in second]
        assert sum(gaps) == lost == sum(row["status"] == "no equal thrust" for row in second)
        assert any("no equal thrust" in line for line in found.remarks) == bool(lost)
        most = max(abs(float(row["thrust_N"])) for row in first)
        for one, other, gap in zip(first, second, gaps, strict=True):
            if not gap:
                off = float(one["thrust_N"]) - float(other["thrust_N"])
                assert abs(off) < 1e-3 * most


DRAGGED = {"chord-2": "120", "twist-4": "-2"}
COMMANDS = {
    "loads": ("loads.csv", {"rpm": "5000", "angles": "0,90", "speed": "8"}),
    "disk": ("disk.csv", {"rpm": "5000", "speed": "9", "beta": "75"}),
    "blade": ("blade-loads.csv", {"rpm": "5000", **DRAGGED}),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_the_copied_command_gives_the_same_file_and_the_copied_python_runs(
    name: str, tmp_path: Path
) -> None:
    view, session = BY_NAME[name], Session()
    file, given = COMMANDS[name]
    values, _ = values_of(view.controls(session), given)
    (tmp_path / "copied.py").write_text(view.python(session, values))
    path = f"export PATH='{Path(sys.executable).parent}':$PATH\n"
    text = f"{path}set -e\n{view.shell(session, values)}\npython copied.py"
    done = subprocess.run(["bash", "-c", text], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout, done.stderr
    assert (tmp_path / file).read_text() == view.text(session, values, file)


def test_a_dragged_blade_is_saved_as_it_is_drawn(tmp_path: Path) -> None:
    view, session = BY_NAME["blade"], Session()
    values, _ = values_of(view.controls(session), DRAGGED)
    path = tmp_path / "blade.toml"
    path.write_text(view.text(session, values, "blade.toml"))
    was, now = session.model.propeller, pm.propeller(path)
    at = np.array([0.5, 0.8, 1.0]) * was.radius
    chord, twist = (
        [np.interp(at, blade.station, getattr(blade, name)) for blade in (was, now)]
        for name in ("chord", "twist")
    )
    assert chord[1][0] == pytest.approx(1.2 * chord[0][0], rel=5e-3)
    assert twist[1][1] == pytest.approx(twist[0][1] - np.radians(2.0), abs=2e-3)
    assert chord[1][2] == pytest.approx(chord[0][2])


def test_without_a_vehicle_a_line_says_what_to_do(application: Application) -> None:
    words = "open a vehicle file"
    with pytest.raises(InputError, match=words):
        BY_NAME["aircraft"].controls(Session())
    page, base = application.page("/aircraft", "")
    assert words in str(page) and base["empty"]


@pytest.mark.slow
def test_measured_points_are_drawn_and_fitted(shelf: Shelf) -> None:
    """A fit of loads that the model made with other constants finds these."""
    model = pm.catalogue_model("apc-8x6e")
    law = model.airfoil
    assert isinstance(law, pm.Airfoil)
    true = law.with_parameters(c_l1=law.c_l1 * 1.1)
    speeds = np.linspace(0.0, 10.0, 6)
    loads = pm.Rotor(model.with_airfoil(true)).loads(5000.0 * RPM, speeds, 0.0)
    made = zip(speeds, loads.thrust, loads.torque, strict=True)
    rows = "".join(f"5000,{v},0,{t},{q}\n" for v, t, q in made)
    text = f"rpm,speed_mps,beta_deg,thrust_N,torque_Nm\n{rows}"
    session = with_file(Session(), shelf, "mine.csv", text.encode())
    view = BY_NAME["constants"]
    values, found = _answer(session, view, free="c_l1", data="file")
    assert any("mine.csv" in table.caption for table in found.tables)
    _, drawn = _answer(session, BY_NAME["loads"], rpm="5000", data="file", angles="0")
    assert any("mine.csv" in str(trace.get("name")) for trace in drawn.figures["thrust"]["data"])
    assert fit_of(session, values).run(Job())["c_l1"] == pytest.approx(true.c_l1, rel=1e-3)
