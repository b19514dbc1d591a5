"""The section law's parameter sets: Table I, files, messages."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from propmap import Airfoil, InputError, airfoil, airfoil_names
from propmap.model.airfoil import CONSTANTS

GOOD = "c_l1 = 5.0\nc_l2 = 1.5\nc_d = 1.2\nalpha_0 = 0.3\n"


def written(folder: Path, text: str | bytes) -> Path:
    path = folder / "section.toml"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


@pytest.mark.parametrize(
    ("name", "c_l1", "c_l2", "c_d", "degrees"),
    [
        ("paper-soft", 6.9, 2.0, 3.7, 20.4),
        ("paper-stiff", 4.2, 2.0, 1.3, 27.5),
        ("paper-apc", 5.3, 1.7, 1.8, 20.6),
    ],
)
def test_named_sets_are_table_1(
    name: str, c_l1: float, c_l2: float, c_d: float, degrees: float
) -> None:
    assert name in airfoil_names()
    found = airfoil(name.upper())
    assert (found.name, found.c_l1, found.c_l2, found.c_d) == (name, c_l1, c_l2, c_d)
    assert found.alpha_0 == pytest.approx(degrees * np.pi / 180.0, rel=1e-14)
    # The paper's constants, and neither camber nor the simplified law.
    assert (found.c_d0, found.c_p, found.sharpness) == (0.01, 1.328, 50.0)
    assert (found.zero_lift_angle, found.lift_law) == (0.0, "blended")
    assert "10.1109/CCTA.2017.8062443" in found.source


def test_the_table_has_each_number_of_the_law_in_order() -> None:
    law = airfoil("paper-apc")
    numbers = [f.name for f in fields(law) if isinstance(getattr(law, f.name), float)]
    assert [*CONSTANTS] == numbers
    for constant in CONSTANTS.values():
        if constant.fit is not None:
            start, lower, upper, spread = constant.fit
            assert constant.limits[0] <= lower <= start <= upper <= constant.limits[1]
            assert spread > 0.0


def test_identified_constants_serve_every_model() -> None:
    found = airfoil("apc-8x6e-2019")
    assert "10.3390/drones3040077" in found.source and "propmap fit tunnel" in found.source
    # Camber, which the paper's law lacks.
    assert -0.1 < found.zero_lift_angle < -0.05
    for corrections in ((), ("pitt-peters",)):
        assert found.with_corrections(corrections).corrections == corrections


def test_a_file_is_read(tmp_path: Path) -> None:
    text = GOOD + 'zero_lift_angle = -0.05\nsharpness = 40\nname = "mine"\n'
    assert airfoil(written(tmp_path, text)) == Airfoil(
        5.0, 1.5, 1.2, 0.3, zero_lift_angle=-0.05, sharpness=40, name="mine"
    )
    # The simplified law needs no attached slope.
    text = GOOD.replace("c_l1 = 5.0\n", "") + 'lift_law = "simplified"\n'
    assert airfoil(written(tmp_path, text)).lift_law == "simplified"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (GOOD + "cl_1 = 5.0\n", ("unknown field", "cl_1")),
        (GOOD.replace("c_l1 = 5.0\n", ""), ("c_l1 is missing",)),
        ("c_l1: 5.0\n", ("not valid TOML",)),
        (b"\xff\xfe\x00", ("not a text file",)),
        (GOOD.replace("5.0", '"5.0"'), ("c_l1", "'5.0'", "number")),
        (GOOD.replace("0.3", "20.4"), ("alpha_0", "20.4", "radians")),
        (GOOD + 'lift_law = "thin"\n', ("lift_law", "thin", "simplified")),
    ],
)
def test_a_bad_file_is_told_in_one_line(
    tmp_path: Path, text: str | bytes, told: tuple[str, ...]
) -> None:
    path = written(tmp_path, text)
    with pytest.raises(InputError) as caught:
        airfoil(path)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(f"{path}: ")
    for part in told:
        assert part in message


def test_a_missing_file_and_an_unknown_name_are_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        airfoil(tmp_path / "none.toml")
    with pytest.raises(InputError, match="there is no table"):
        airfoil(tmp_path)
    with pytest.raises(InputError, match="paper-soft"):
        airfoil("papersoft")


FIELDS = {"c_l1": 5.1, "c_l2": 1.0 / 3.0, "c_d": 1e-5, "alpha_0": 0.3, "zero_lift_angle": -0.05}


@pytest.mark.parametrize("source", ['J. "Joe" Doe', "back\\slash\r\n", '"""', "Zürich\x07"])
def test_a_written_set_reads_back_the_same(tmp_path: Path, source: str) -> None:
    mine = Airfoil(**FIELDS, sharpness=40.0, lift_law="simplified", name="a 'b'", source=source)
    assert airfoil(written(tmp_path, mine.to_toml())) == mine


def test_a_set_of_numpy_numbers_reads_back_the_same(tmp_path: Path) -> None:
    # What a fit returns; np.float64 is a float, but its repr is not TOML.
    mine = Airfoil(**{field: np.float64(value) for field, value in FIELDS.items()})
    assert airfoil(written(tmp_path, mine.to_toml())) == Airfoil(**FIELDS)


def test_with_parameters_changes_a_copy_and_checks_it() -> None:
    mine = Airfoil(**FIELDS)
    changed = mine.with_parameters(c_d=2.0)
    assert (mine.c_d, changed.c_d, changed.c_l1) == (1e-5, 2.0, 5.1)
    with pytest.raises(InputError, match="sharpness"):
        mine.with_parameters(sharpness=1.0)
