"""The database's table, the catalogue's files, and the command that makes these of that."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import propmap as pm
from propmap import catalogue
from propmap.catalogue.expected import GEOMETRIES, bundled_population, parse_populations
from propmap.catalogue.identified import identified
from tests.io.samples_csv import rewritten
from tests.tools.catalogue.test_identification import coefficients
from tools.catalogue.__main__ import main
from tools.catalogue.database import read_uiuc_database
from tools.catalogue.files import as_csv, as_toml, parse_identified

FILE = Path(catalogue.__file__).with_name("identified") / "uiuc.csv"
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
    assert (one.name, one.blades) == ("a 9.0x6.0 - 2", 2)
    assert (other.name, other.blades) == ("b 9.0x6.0 - 3", 3)
    np.testing.assert_array_equal(one.rpm, [4000.0, 4000.0, 5000.0, 2000.0, 2500.0])
    np.testing.assert_array_equal(one.run, [0, 0, 1, 2, 2])
    np.testing.assert_array_equal(one.thrust, [0.09, 0.08, 0.08, 0.11, 0.12])
    np.testing.assert_array_equal(other.power, [0.06])
    by_semicolon = tmp_path / "other.csv"
    by_semicolon.write_bytes(rewritten(HEADER + ROWS, "semicolons, decimal commas").encode())
    np.testing.assert_array_equal(read_uiuc_database(by_semicolon)[0].thrust, one.thrust)


def test_files_are_small_and_read_back_the_same() -> None:
    text = FILE.read_text(encoding="utf-8")
    assert len(text) < 300_000
    assert as_csv(parse_identified(text, "here")) == text
    text = as_toml({name: bundled_population(name) for name in GEOMETRIES})
    assert as_toml(parse_populations(text)) == text


def rows_of(blade: str, label: str) -> str:
    """Rows that the bundled constants of a blade give."""
    one = identified(blade, 2)
    assert one is not None
    rpm = np.array([3000.0, 4000.0, 5000.0, 6000.0, *6 * [5000.0]])
    advance = np.array([0.0, 0.0, 0.0, 0.0, *np.linspace(0.1, 0.5, 6)])
    thrust, power = coefficients(pm.propeller(blade), one.airfoil, rpm, advance)
    return "".join(
        f"{label} - 2,{label},{label.split()[0]},2,9.0,6.0,{j},{n},{c},{p},,1\n"
        for j, n, c, p in zip(advance, rpm, thrust, power, strict=True)
    )


@pytest.mark.slow
def test_constants_are_found_written_and_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    loads, output = tmp_path / "loads.csv", tmp_path / "identified.csv"
    first = rows_of("uiuc-apce-9x4.5", "apce 9.0x4.5")
    loads.write_text(HEADER + first, encoding="utf-8")
    main([str(loads), "-o", str(output)])
    capsys.readouterr()
    found, by_maker = parse_identified(output.read_text(encoding="utf-8"), "it")
    assert (by_maker.propeller, by_maker.geometry) == ("apc-9x4.5e", "maker")
    assert (found.propeller, found.rows, found.static_rows) == ("uiuc-apce-9x4.5", 10, 4)
    assert found.thrust_rms < 1e-3
    # What is in the file is kept, and what is new added.
    more = rows_of("uiuc-apce-9x6", "apce 9.0x6.0").replace("apce 9.0x6.0 - 2", "another - 2")
    loads.write_text(HEADER + first + more, encoding="utf-8")
    main([str(loads), "-o", str(output)])
    outcome = capsys.readouterr()
    assert "uiuc-apce-9x4.5," not in outcome.err and "uiuc-apce-9x6," in outcome.err
    again = parse_identified(output.read_text(encoding="utf-8"), "it")
    names = ["uiuc-apce-9x4.5", "apc-9x4.5e", "uiuc-apce-9x6", "apc-9x6e"]
    assert [one.propeller for one in again] == names
    assert again[0].constants.tolist() == found.constants.tolist()
