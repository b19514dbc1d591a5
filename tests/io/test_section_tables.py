"""Section tables of other programs: the figures read, what is added to them, what is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import propmap
from propmap.errors import InputError
from propmap.io.sections import read_section_table

REYNOLDS = (1e5, 4e5)
ANGLES = np.linspace(-180.0, 180.0, 49)


def section(angle: np.ndarray, reynolds: float) -> tuple[np.ndarray, np.ndarray]:
    """A section that stalls near 12 degrees and has camber; angles in degrees."""
    a = np.radians(angle + 2.0)
    attached = np.exp(-((a / 0.25) ** 4))
    lift = 6.0 * a * attached + 1.1 * np.sin(2.0 * a) * (1.0 - attached)
    return lift, 4.0 / np.sqrt(reynolds) + 1.2 * np.sin(a) ** 2


def rows(angle: np.ndarray, reynolds: float, separator: str = " ") -> str:
    lift, drag = section(angle, reynolds)
    return "".join(
        separator.join(f"{v:.6f}" for v in row) + "\n"
        for row in zip(angle, lift, drag, 0.0 * lift, strict=True)
    )


def aerodyn(angle: np.ndarray) -> str:
    """As of AeroDyn v13 and v14: parameters, rows, EOT, for each Reynolds number in millions."""
    text = "An invented section\nmade for a test\n"
    text += f" {len(REYNOLDS)}  Number of airfoil tables in this file\n"
    for re in REYNOLDS:
        text += f" {re / 1e6}  Table ID parameter (Reynolds number in millions)\n"
        text += " 12.0  Stall angle (deg)\n"
        text += " 0.0  No longer used, enter zero\n -2.0  Zero lift angle of attack (deg)\n"
        text += rows(angle, re, "\t") + "EOT\n"
    return text


def aerodyn_15(angle: np.ndarray) -> str:
    text = '! AirfoilInfo, invented\n"DEFAULT" InterpOrd ! order\n 1 NonDimArea ! area\n'
    text += (
        f"0 NumCoords ! none\n {len(REYNOLDS)} NumTabs ! Number of airfoil tables in this file.\n"
    )
    for re in REYNOLDS:
        text += (
            f"! table\n {re / 1e6} Re ! in millions\n 0 UserProp ! control\nFalse InclUAdata ! no\n"
        )
        text += f"! ....\n {angle.size} NumAlf ! rows\n! Alpha Cl Cd Cm\n! (deg) (-) (-) (-)\n"
        text += rows(angle, re)
    return text


def cactus(angle: np.ndarray) -> str:
    text = "Title: invented\nThickness to Chord Ratio: 0.15\nZero Lift AOA (deg): -2.0\n\n"
    for re in REYNOLDS:
        text += f"Reynolds Number: {re:g}\nBV Dyn. Stall Model - Positive Stall AOA (deg): 12\n"
        text += "AOA (deg) CL CD Cm25\n" + rows(angle, re, "\t") + "\n"
    return text


def qblade(angle: np.ndarray, coefficients: int = 3) -> str:
    """As of QBlade CE 2: polars side by side, at common angles."""
    text = "-----QBlade Multi RE Polar File-----\nTime : 21:36:42\n\n"
    text += "invented   POLARNAME   - the polar name\n12.0   THICKNESS   - the name of the blade\n"
    text += f"{int(coefficients > 3)}   ISDECOMPOSED   - is the polar decomposed\n"
    numbers = "   ".join(f"{re:.4E}" for re in REYNOLDS)
    text += f"REYNOLDS   {numbers}   - the list of Reynolds numbers for the imported polars\n\n"
    text += "-----Polar Data-----\nAOA" + len(REYNOLDS) * " CL CD CM" + "\n"
    for a in angle:
        each = [(*section(a, re), 0.5, 9.0, 9.0, 9.0)[:coefficients] for re in REYNOLDS]
        text += " ".join(f"{v:.6f}" for v in (a, *np.ravel(each))) + "\n"
    return text


def qblade_decomposed(angle: np.ndarray) -> str:
    return qblade(angle, 6)


def qblade_without_heads(angle: np.ndarray) -> str:
    """As of earlier releases: the keyword is behind the numbers."""
    text = " ".join(f"{re:g}" for re in REYNOLDS) + " REYNOLDS\n\nAOA CL CD CM CL CD CM\n"
    return text + qblade(angle).split("CM\n")[1]


def csv(angle: np.ndarray) -> str:
    text = "re, alpha_deg, cl, cd, note\n"
    for re in REYNOLDS:
        for a, lift, drag in zip(angle, *section(angle, re), strict=True):
            text += f"{re:g},{a:.6f},{lift:.6f},{drag:.6f},x\n"
    return text


def csv_in_thousands(angle: np.ndarray) -> str:
    text = csv(angle).replace("re,", "Re (x1000),", 1)
    for reynolds in REYNOLDS:
        text = text.replace(f"\n{reynolds:g},", f"\n{reynolds / 1e3:g},")
    return text


def javafoil(angle: np.ndarray, unit: str = "[\u00b0]", digits: int = 6) -> str:
    """As copied from JavaFoil: settings, names with Greek letters, and a row of units."""
    text = f"JavaFoil polars\nName = invented\nMach = 0; Re = {REYNOLDS[0]:.0f}; T.U. = 1.0\n"
    text += f"\u03b1\tCl\tCd\tCm 0.25\n{unit}\t[-]\t[-]\t[-]\n"
    written = angle if unit == "[\u00b0]" else np.radians(angle)
    for a, lift, drag in zip(written, *section(angle, REYNOLDS[0]), strict=True):
        text += f"{a:.{digits}f}\t{lift:.6f}\t{drag:.6f}\t0\n"
    return text


def xfoil(angle: np.ndarray, reynolds: float) -> str:
    text = "\n       XFOIL         Version 6.99\n\n Calculated polar for: INVENTED\n\n"
    text += " 1 1 Reynolds number fixed          Mach number fixed\n\n"
    text += f" Mach =   0.000     Re =     {reynolds / 1e6:.3f} e 6     Ncrit =   9.000\n\n"
    text += "   alpha    CL        CD       CDp       CM     Top_Xtr  Bot_Xtr\n"
    text += "  ------ -------- --------- --------- -------- -------- --------\n"
    return text + rows(angle, reynolds)


@pytest.mark.parametrize(
    "layout",
    [
        aerodyn,
        aerodyn_15,
        cactus,
        csv,
        csv_in_thousands,
        qblade,
        qblade_decomposed,
        qblade_without_heads,
    ],
)
def test_the_same_section_in_every_format(
    tmp_path: Path, layout: Callable[[np.ndarray], str]
) -> None:
    path = tmp_path / "invented.dat"
    path.write_text(layout(ANGLES))
    table = propmap.airfoil(path)
    assert isinstance(table, propmap.SectionTable)
    assert table.name == "invented" and "continued" not in table.source
    np.testing.assert_allclose(table.reynolds, REYNOLDS)
    np.testing.assert_allclose(table.angle, np.radians(ANGLES), atol=1e-9)
    for k, re in enumerate(REYNOLDS):
        lift, drag = section(ANGLES, re)
        np.testing.assert_allclose(table.lift[k], lift, atol=1e-6)
        np.testing.assert_allclose(table.drag[k], drag, atol=1e-6)


@pytest.mark.parametrize(
    ("unit", "digits"), [("[\u00b0]", 6), ("[rad]", 6), ("[rad]", 5), ("[rad]", 4)]
)
def test_units_in_the_row_below_the_names_are_read(tmp_path: Path, unit: str, digits: int) -> None:
    """Half a turn is 3.1416 or 3.14159 rad, on either side of 180 degrees."""
    path = tmp_path / "polar.txt"
    path.write_text(javafoil(ANGLES, unit, digits), encoding="utf-8")
    table = read_section_table(path)
    lift, drag = section(ANGLES, REYNOLDS[0])
    np.testing.assert_allclose(table.angle, np.radians(ANGLES), atol=10.0**-digits)
    np.testing.assert_allclose(table.lift[0], lift, atol=10.0**-digits)
    np.testing.assert_allclose(table.drag[0], drag, atol=10.0**-digits)
    assert table.reynolds == REYNOLDS[0]


def test_blank_units_below_the_names_leave_the_names(tmp_path: Path) -> None:
    rows = "".join(f"{angle},1e5,{0.01 * angle},0.02\n" for angle in range(-180, 181, 20))
    path = tmp_path / "polar.csv"
    tables = []
    for units in ("", ",-,-,-\n", ",-\n"):
        path.write_text(f"alpha_deg,re,cl,cd\n{units}{rows}")
        tables.append(read_section_table(path))
    assert all(np.array_equal(table.lift, tables[0].lift) for table in tables[1:])


def test_a_damaged_row_in_place_of_the_units_is_named(tmp_path: Path) -> None:
    path = tmp_path / "polar.csv"
    path.write_text("alpha_deg,cl,cd\n-:0.02\n4,0.7,0.02\n8,1.0,0.03\n")
    with pytest.raises(InputError, match=r"line 1: column alpha_deg is missing.*units below it"):
        read_section_table(path)


def test_a_folder_of_polars_is_continued_past_stall(tmp_path: Path) -> None:
    angle = np.arange(-14.0, 18.1, 0.5)
    for re in REYNOLDS:
        # In the order of two runs of XFOIL: up from zero, then down from zero once more.
        both = np.concatenate([angle[angle >= 0.0], angle[angle <= 0.0][::-1]])
        (tmp_path / f"re{re:g}.pol").write_text(xfoil(both, re))
    table = propmap.airfoil(str(tmp_path))
    assert isinstance(table, propmap.SectionTable)
    assert "XFOIL" in table.source and "continued from -14 and 18 deg by Viterna" in table.source
    np.testing.assert_allclose(table.reynolds, REYNOLDS)
    degrees = np.degrees(table.angle)
    inside = (degrees > -14.1) & (degrees < 18.1)
    np.testing.assert_allclose(degrees[inside], angle, atol=1e-9)
    for k, re in enumerate(REYNOLDS):
        lift, drag = section(angle, re)
        np.testing.assert_allclose(table.lift[k, inside], lift, atol=1e-6)
        # NASA CP-2230: C_D,max = 1.11 + 0.018 AR of a plate of aspect ratio 10 ...
        at = dict(
            zip(
                degrees.round(3).tolist(),
                zip(table.lift[k], table.drag[k], strict=True),
                strict=True,
            )
        )
        assert at[90.0] == pytest.approx((0.0, 1.29), abs=1e-12)
        # ... and constants that meet the polar at its last angle.
        s, c = np.sin(np.radians(18.0)), np.cos(np.radians(18.0))
        s4, c4 = np.sin(np.radians(40.0)), np.cos(np.radians(40.0))
        a2 = (lift[-1] - 1.29 * s * c) * s / c**2
        b2 = (drag[-1] - 1.29 * s**2) / c
        assert at[40.0] == pytest.approx(
            (0.645 * 2.0 * s4 * c4 + a2 * c4**2 / s4, 1.29 * s4**2 + b2 * c4)
        )
        # Met from behind, and below: 0.7 of the lift.
        assert at[140.0][0] == pytest.approx(-0.7 * at[40.0][0])
        assert at[-40.0][0] == pytest.approx(-0.7 * at[40.0][0])
        assert at[-180.0] == at[180.0] and at[180.0][0] == 0.0
        assert (table.drag[k] >= drag.min() - 1e-6).all()
        assert np.abs(np.diff(table.lift[k])).max() < 0.6  # no jump where parts meet


def test_different_angles_are_brought_together(tmp_path: Path) -> None:
    (tmp_path / "a.pol").write_text(xfoil(np.arange(-12.0, 16.1, 1.0), 1e5))
    (tmp_path / "b.pol").write_text(xfoil(np.arange(-10.0, 18.1, 0.8), 4e5))
    table = read_section_table(tmp_path)
    for k, (re, angle) in enumerate([(1e5, 5.0), (4e5, 6.0)]):
        lift, drag = section(np.array([angle]), re)
        j = int(np.argmin(np.abs(table.angle - np.radians(angle))))
        assert np.degrees(table.angle[j]) == pytest.approx(angle)
        assert (table.lift[k, j], table.drag[k, j]) == pytest.approx((lift[0], drag[0]), abs=1e-6)
    assert np.diff(table.angle).min() > np.radians(0.04)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (csv(ANGLES).replace(",-7.500000", ",x"), "line 25: alpha_deg is 'x'"),
        (csv(ANGLES).replace("cl,", "lift,"), "not a section table"),
        (aerodyn(ANGLES).split("EOT")[0] + "EOT\n", "table 2 of 2 is missing"),
        (
            aerodyn(ANGLES).replace(" 2  Num", " 1  Num"),
            "a row after table 1, the last table that the file states",
        ),
        (
            qblade(ANGLES).replace("1.0000E+05   ", ""),
            "line 11: found 7 numbers, expected the angle and 3 coefficients for each of 1 Re",
        ),
        (xfoil(ANGLES, 1e5).replace("CM ", "CL CD"), "line 10: found a second polar"),
        (xfoil(ANGLES, 1e5) + xfoil(ANGLES, 2e5), "line 70: found a second polar"),
        ("alpha,cl,cd\n" + 2 * "0,1,0.02\n" + "0,1,0.03\n", "0 deg occurs twice, in line 2 with"),
        (csv(np.radians(ANGLES)), "3.142 deg, so the angles may be in radians; give"),
        (aerodyn_15(ANGLES).replace("0.4 Re", "4e5 Re"), "is 4e+11; give the Reynolds number of"),
        (aerodyn(ANGLES).replace("0.4 ", "0.1 "), "Re = 100000 occurs twice"),
        (aerodyn_15(ANGLES)[:-900], "NumAlf is 49"),
        (
            cactus(ANGLES).replace("Number: 400000", "Number: "),
            "line 58: Reynolds number is nothing",
        ),
        (xfoil(np.arange(-8.0, 6.1), 1e5), "the lift still rises at the last"),
        (xfoil(np.arange(-8.0, 95.0), 1e5), "expected -180 to 180"),
        (xfoil(ANGLES, 1e5) + " 31.0 30.5 0.5\n", "lift coefficient of 30.5"),
    ],
)
def test_errors_name_the_file_and_the_line(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "bad.dat"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_section_table(path)
    assert says in str(caught.value) and "bad.dat" in str(caught.value)


def test_a_folder_holds_polars_alone(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no table"):
        read_section_table(tmp_path)
    (tmp_path / "notes.txt").write_text("nothing\n")
    with pytest.raises(InputError, match="only polars"):
        read_section_table(tmp_path)


def test_a_table_open_at_180_degrees_and_without_a_reynolds_number(tmp_path: Path) -> None:
    text = aerodyn(ANGLES[:-1]).replace(" 2  Number", " 1  Number").partition("EOT")[0]
    (tmp_path / "a.dat").write_text(text.replace(" 0.1  Table", " 0  Table"))
    table = read_section_table(tmp_path / "a.dat")
    assert table.reynolds.size == 1 and "Reynolds number not stated" in table.source
    assert table.angle[-1] == np.pi
    np.testing.assert_allclose(table.lift[:, -1], table.lift[:, 0], atol=1e-12)
