"""The database's table of all loads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from propmap.errors import InputError
from tests.io.samples_csv import DIALECTS, rewritten
from tools.catalogue.database import read_uiuc_database

HEADER = "PropName,BladeName,Family,B,D,P,J,N,CT,CP,eta,volume\n"
ROWS = """a 9.0x6.0 - 2,a 9.0x6.0,a,2,9.0,6.0,0.2,4000.0,0.09,0.05,0.3,1
a 9.0x6.0 - 2,a 9.0x6.0,a,2,9.0,6.0,0.3,4000.0,0.08,0.05,0.4,1
b 9.0x6.0 - 3,b 9.0x6.0,b,3,9.0,6.0,0.2,5000.0,0.10,0.06,0.3,1
a 9.0x6.0 - 2,a 9.0x6.0,a,2,9.0,6.0,0.3,5000.0,0.08,0.05,0.4,1
a 9.0x6.0 - 2,a 9.0x6.0,a,2,9.0,6.0,0.0,2000.0,0.11,0.05,,1
a 9.0x6.0 - 2,a 9.0x6.0,a,2,9.0,6.0,0.0,2500.0,0.12,0.05,,1
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "loads.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_rows_are_sorted_by_propeller_and_numbered_by_run(tmp_path: Path) -> None:
    one, other = read_uiuc_database(written(tmp_path, HEADER + ROWS))
    assert (one.name, one.blades, other.name, other.blades) == (
        "a 9.0x6.0 - 2",
        2,
        "b 9.0x6.0 - 3",
        3,
    )
    np.testing.assert_array_equal(one.rpm, [4000.0, 4000.0, 5000.0, 2000.0, 2500.0])
    np.testing.assert_array_equal(one.run, [0, 0, 1, 2, 2])
    np.testing.assert_array_equal(one.thrust, [0.09, 0.08, 0.08, 0.11, 0.12])
    np.testing.assert_array_equal(other.power, [0.06])


def test_bad_tables_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no column CP"):
        read_uiuc_database(written(tmp_path, "PropName,BladeName,Family,B,J,N,CT\n"))
    with pytest.raises(InputError, match="line 3: CT is 'x'"):
        read_uiuc_database(written(tmp_path, HEADER + ROWS.replace("0.08,0.05,0.4", "x,1,1", 1)))
    with pytest.raises(InputError, match="no such file"):
        read_uiuc_database(tmp_path / "none.csv")


@pytest.mark.parametrize("dialect", DIALECTS)
def test_dialects_of_spreadsheets(tmp_path: Path, dialect: str) -> None:
    plain = read_uiuc_database(written(tmp_path, HEADER + ROWS))
    other = tmp_path / "other.csv"
    other.write_bytes(rewritten(HEADER + ROWS, dialect).encode())
    for one, two in zip(plain, read_uiuc_database(other), strict=True):
        assert one[:4] == two[:4]
        for expected, found in zip(one[4:], two[4:], strict=True):
            np.testing.assert_array_equal(expected, found)
