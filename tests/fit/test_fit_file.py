"""Fit files: what is written is read again, and what is damaged is named."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import numpy as np
import pytest

from propmap import __version__
from propmap.errors import InputError
from propmap.fit.files import DataSource, is_fit, read_fit
from propmap.fit.fit import coverage
from propmap.model.airfoil import parameter_set

from .fit_records import ENVELOPE, fit_text, parameter, record


def written(folder: Path, text: str) -> Path:
    file = folder / "fit.toml"
    file.write_text(text)
    return file


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    omega, beta = np.array([300.0, 500.0, 600.0]), np.array([0.1, 1.5, 1.5])
    prior = msgspec.structs.replace(parameter("c_d", 1.0, 0.0, 9.0), prior=(1.0, 0.5))
    changed = {
        "covered": coverage(omega, np.array([0.0, 4.0, 5.0]), beta, 0.1),
        "parameters": [parameter("c_l1", 5.0, 0.5, 12.0), prior],
        "covariance": np.diag([0.04, np.inf]),
        "settings": {"loss": "linear", "loads": ["thrust"]},
        "body": {"lift_area": 0.01},
        "wing": {"wing_c_l1": 4.0},
        "envelope": ENVELOPE,
    }
    want = record(**changed)
    found = read_fit(written(tmp_path, fit_text(**changed)))
    assert found.record.table() == want.table()
    np.testing.assert_array_equal(found.record.covariance, want.covariance)
    assert found.record.parameters == want.parameters and found.record.covered == want.covered
    assert found.values == {"lift_area": 0.01, "wing_c_l1": 4.0}
    assert found.model.propeller.name == "apc-8x6e" and found.model.air == want.air
    assert found.covariance is not None and found.covariance.unknown == ("c_d",)
    known = parameter_set(tmp_path / "fit.toml").uncertainty
    assert found.record.envelope == ENVELOPE and known is not None and known.envelope == ENVELOPE


def test_a_file_of_an_earlier_version_has_no_envelope(tmp_path: Path) -> None:
    path = written(tmp_path, fit_text())
    known = parameter_set(path).uncertainty
    assert read_fit(path).record.envelope is None and known is not None and known.envelope is None


@pytest.mark.parametrize(
    ("entry", "damage", "says"),
    [
        ("rows = 20", "rows = 2.5", "at rows: Expected int, got float"),
        ("hover_rms = 0.3", "", "at residuals.thrust: Object missing required field hover_rms"),
        ('"c_l1",', "", "the parameters differ from the list free"),
        (r"chord_m = \[\n", "chord_m = [ -0.01,", "the table [fit] cannot be read: "),
        (r"\[fit.envelope\]", "[fit.envelope]\nrpm = [2, 1]\n[x]", "cannot be read: "),
        ("density = .*", "density = -1.2", "at air: air density is -1.2: it must be positive"),
        ("c_l1 = ", "lift_slope = 5.0\nc_l1 = ", "unknown field 'lift_slope'"),
        ("c_l2 = .*\n", "", "c_l2 is missing"),
        (r"\[fit.body\]", "[fit.body]\ncentre_x = 0.01", "'centre_x' is not a parameter"),
    ],
)
def test_the_damaged_entry_and_another_version_are_named(
    tmp_path: Path, entry: str, damage: str, says: str
) -> None:
    whole = fit_text(envelope=ENVELOPE)
    text = re.sub(entry, damage, whole, count=1)
    assert text != whole
    this = f"written by propmap 0 (this is {__version__}): run `propmap fit` again"
    of_law = says in ("c_l2 is missing", "unknown field 'lift_slope'")
    for read in (read_fit, is_fit) if of_law else (read_fit,):
        with pytest.raises(InputError) as refused:
            read(written(tmp_path, text))
        assert says in str(refused.value) and str(refused.value).startswith(str(tmp_path))
        assert this in str(refused.value) and refused.value.remedy
    ours = text.replace('propmap = "0"', f'propmap = "{__version__}"')
    with pytest.raises(InputError, match=re.escape(says)) as refused:
        read_fit(written(tmp_path, ours))
    assert "written by" not in str(refused.value)


def test_a_folder_such_as_a_ros_2_bag_has_a_digest_of_its_files(tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    bag.mkdir()
    (bag / "metadata.yaml").write_text("a")
    (bag / "part.db3").write_bytes(b"b")
    first = DataSource.of(bag)
    assert first.name == "bag" and len(first.sha256) == 64
    (bag / "part.db3").write_bytes(b"c")
    assert DataSource.of(bag).sha256 != first.sha256
