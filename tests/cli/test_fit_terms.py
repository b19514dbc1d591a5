"""`propmap fit terms`: logs in, a page out; what is refused.  The fits themselves are made up."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from propmap.fit.comparison import AxisErrors, FittedStep, RecordedFlight, Step
from propmap.units import GRAVITY

from .conftest import Run
from .test_fit_flight import turning_log

pytestmark = pytest.mark.usefixtures("filters_once", "pictures_as_they_fall")

ASKED: list[dict[str, Any]] = []


def made_up(
    _: object, flights: Sequence[RecordedFlight], steps: Sequence[Step], __: object, **settings: Any
) -> list[FittedStep]:
    """Each step has half of the error of the one before it."""
    ASKED.append({"flights": flights, "steps": steps, **settings})
    found = []
    for number, step in enumerate(steps):
        for left_out in range(len(flights)):
            offs = [np.full((len(f.passed), 3), 0.5**number) for f in flights]
            off = tuple(AxisErrors(one, one) for one in offs)
            found.append(FittedStep(step.name, left_out, {"c_l1": 5.0}, off, off))
    return found


@pytest.fixture
def flown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Two logs with a prediction beside them, the vehicle, and no fitting."""
    monkeypatch.setattr("propmap.fit.comparison.fit_terms", made_up)
    ASKED.clear()
    log = turning_log(tmp_path, 400)
    with log.open() as lines:
        table = list(csv.reader(lines))
    table[0] += ["other_fx", "other_fy", "other_fz"]
    for row in table[1:]:
        row += ["1.0", "2.0", "3.0"]
    log.write_text("\n".join(",".join(row) for row in table) + "\n")
    shutil.copy(log, tmp_path / "second.csv")
    return ["log.csv", "second.csv", "--vehicle", "logged.toml"]


def test_the_page_and_what_was_asked(run: Run, flown: list[str], tmp_path: Path) -> None:
    told = run("fit", "terms", *flown, "-o", "page", "--samples", "40", "--low-pass", "5")
    assert told.code == 0 and "wrote page/index.html and 4 other files" in told.out
    page = (tmp_path / "page" / "index.html").read_text()
    assert "terms reduce the error" in page and "prediction in the file" in page
    (asked,) = ASKED
    assert asked["samples"] == 40 and [f.name for f in asked["flights"]] == ["log", "second"]
    steps = asked["steps"]
    assert steps[0].vertical and not any(step.vertical for step in steps[1:])
    # One term more at a time, in the dependencies' order, and everything in the last.
    names = [set(step.choice.free) for step in steps]
    assert "drag_area_x" in names[1] and "drag_area_x" not in names[3]
    assert {"sensor_x", "clock_offset"} <= names[2] - names[1]
    assert names[4] - names[3] == {"wake_ahead", "wake_beside", "wake_downwash", "wake_share"}
    assert names[5] - names[4] == {"untwist"}
    assert names[6] - names[5] == {"download_area_x", "download_area_y"}
    assert names[7] - names[6] == {"plate_area"}
    # What is not free is absent, but with the same shape of the model.
    for step in steps[1:]:
        assert {"mount_area", "untwist"} <= set(step.choice.free) | set(step.choice.fixed)
    # Without what is mounted the blades keep their own rotor drag.
    for step in steps[:3]:
        assert step.choice.fixed["drag_factor"] == 1.0
        assert 0.0 < step.choice.fixed["mount_area"] < 1e-6
    first = asked["flights"][0]
    assert first.prediction is not None
    np.testing.assert_allclose(first.prediction, [[1.0, 2.0, 3.0]] * len(first.passed), atol=1e-6)
    assert abs(float(np.mean(first.passed.specific_force[:, 2])) - GRAVITY) < 1.5


def test_columns_of_a_prediction_by_name(run: Run, flown: list[str]) -> None:
    chosen = ["--prediction", "other_fz,other_fy,other_fx", "-o", "page"]
    assert run("fit", "terms", *flown, *chosen).code == 0
    prediction = ASKED[0]["flights"][0].prediction
    np.testing.assert_allclose(prediction[5], [3.0, 2.0, 1.0], atol=1e-6)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["log.csv"], "two logs have the name 'log'; give each flight once"),
        (["--prediction", "a,b,c"], "--prediction: 'a' is not a column; name three columns"),
        (["--prediction", "other_fx"], "--prediction: 1 columns; name three columns"),
        (["--prior-from", "none"], "fit terms needs a prior"),
        (["--low-pass", "-1"], "give a frequency, or 0 for no filter"),
        (["--vehicle", "none.toml"], "none.toml"),
    ],
)
def test_bad_input_in_one_line(run: Run, flown: list[str], more: list[str], said: str) -> None:
    told = run("fit", "terms", *flown, *more, "-o", "page")
    assert told.code == 2 and said in told.err and "Traceback" not in told.err
    assert len(told.err.strip().splitlines()) == 1
    assert not Path("page").exists()


def test_a_folder_with_other_files_is_kept(run: Run, flown: list[str], tmp_path: Path) -> None:
    (tmp_path / "page").mkdir()
    (tmp_path / "page" / "mine.txt").write_text("kept")
    told = run("fit", "terms", *flown, "-o", "page")
    assert told.code == 2 and "'mine.txt'" in told.err
    assert (tmp_path / "page" / "mine.txt").read_text() == "kept"
