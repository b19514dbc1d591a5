"""The validation page's tables say what the files of `make reproduce` say."""

from __future__ import annotations

from tools import docs_reproduce


def cells(table: str) -> list[list[str]]:
    return [[c.strip() for c in line.split("|")[1:-1]] for line in table.splitlines()]


def test_errors_name_data_and_load_once() -> None:
    row = {
        "data_set": "uiuc-8x6e",
        "load": "thrust",
        "model": "this",
        "rms_over_rms_measured": "0.0546",
        "worst_over_largest_measured": "1",
    }
    rows = [row, {**row, "model": "hover model"}, {**row, "load": "torque"}]
    _, _, first, second, third = cells(docs_reproduce.errors(rows))
    assert first == ["8x6E, axial (UIUC)", "thrust", "this", "5.5\N{NO-BREAK SPACE}%",
                     "100\N{NO-BREAK SPACE}%"]  # fmt: skip
    assert second[:3] == ["", "", "hover model"]
    assert third[:2] == ["", "torque"]


def test_what_is_not_identified_is_marked() -> None:
    row = {"fit": "mine", "data": "uiuc-8x6e", "low_95": "4", "high_95": "5"}
    first = {**row, "parameter": "c_l1_per_rad", "value": "4.5", "verdict": "identified"}
    second = {**row, "parameter": "c_l2", "value": "2e-6", "verdict": "weak: held"}
    found = cells(docs_reproduce.identified([first, second]))
    assert found[2] == ["mine", "4.5 (4 to 5)", "0\\* (4 to 5)", "fixed", "fixed", "fixed"]
    names = ("beta_deg", "polynomials_over_theory", "lowest", "highest")
    names += ("polynomials_over_recommended", "model_over_theory")
    row = dict(zip(names, ("15", "2.1", "", "2.2", "2.3", "1.9"), strict=True))
    none = docs_reproduce.rotor_drag([row])
    assert cells(none)[2] == ["15", "2.1", "none", "2.2", "2.3", "1.9"]
