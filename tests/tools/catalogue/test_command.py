"""``python -m tools.catalogue``, on two propellers of made-up rows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import propmap as pm
from propmap.catalogue.identified import identified
from tools.catalogue.__main__ import main
from tools.catalogue.files import parse_identified

HEADER = "PropName,BladeName,Family,B,D,P,J,N,CT,CP,eta,volume\n"


def rows_of(blade: str, label: str) -> str:
    """Rows that the bundled constants of a blade give."""
    one, propeller = identified(blade, 2), pm.propeller(blade)
    assert one is not None
    rpm = np.array([3000.0, 4000.0, 5000.0, 6000.0, *6 * [5000.0]])
    advance = np.array([0.0, 0.0, 0.0, 0.0, *np.linspace(0.1, 0.5, 6)])
    turns, diameter = rpm / 60.0, 2.0 * propeller.radius
    rotor = pm.Rotor(pm.Model(propeller, one.airfoil))
    loads = rotor.loads(2.0 * np.pi * turns, advance * turns * diameter, 0.0)
    thrust = loads.thrust / (1.225 * turns**2 * diameter**4)
    power = 2.0 * np.pi * turns * loads.torque / (1.225 * turns**3 * diameter**5)
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
    known = identified("uiuc-apce-9x4.5", 2)
    assert known is not None
    assert (found.propeller, found.blades, found.rows, found.static_rows) == (
        *("uiuc-apce-9x4.5", 2),
        *(10, 4),
    )
    # Less data than the constants were found from, and the same prior.
    spread = np.sqrt(np.diag(found.covariance))
    assert (np.abs(found.constants - known.constants) < 2.0 * spread).all()
    assert found.thrust_rms < 1e-3
    # What is in the file is kept, and what is new added.
    more = rows_of("uiuc-apce-9x6", "apce 9.0x6.0").replace("apce 9.0x6.0 - 2", "another - 2")
    loads.write_text(HEADER + first + more, encoding="utf-8")
    main([str(loads), "-o", str(output)])
    outcome = capsys.readouterr()
    assert "uiuc-apce-9x4.5," not in outcome.err and "uiuc-apce-9x6," in outcome.err
    assert "median" in outcome.out
    again = parse_identified(output.read_text(encoding="utf-8"), "it")
    assert [one.propeller for one in again] == [
        *("uiuc-apce-9x4.5", "apc-9x4.5e"),
        *("uiuc-apce-9x6", "apc-9x6e"),
    ]
    assert again[0].constants.tolist() == found.constants.tolist()


def test_a_table_of_something_else_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    loads = tmp_path / "loads.csv"
    loads.write_text("rpm,thrust\n1,2\n", encoding="utf-8")
    with pytest.raises(SystemExit) as ended:
        main([str(loads), "-o", str(tmp_path / "out.csv")])
    assert ended.value.code == 2 and "there is no column PropName" in capsys.readouterr().err
    assert not (tmp_path / "out.csv").exists()
