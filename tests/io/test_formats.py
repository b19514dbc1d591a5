"""Each format is read to the numbers that are in it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from propmap.catalogue.lookup import propeller
from propmap.errors import InputError
from propmap.io.geometry import (
    read_apc_pe0,
    read_geometry_file,
    read_propeller_csv,
    read_propeller_toml,
    read_uiuc_geometry,
)
from propmap.model.propeller import Propeller

from . import samples

Writer = Callable[[str | bytes], Path]


def same_blade(one: Propeller, other: Propeller) -> bool:
    return all(
        np.allclose(getattr(one, field), getattr(other, field), rtol=1e-12, atol=0.0)
        for field in ("station", "chord", "twist")
    )


def test_pe0_columns_and_units(written: Writer) -> None:
    blade = read_apc_pe0(written(samples.PE0))
    assert (blade.name, blade.blades) == ("apc-5x4t", 2)
    np.testing.assert_allclose(blade.station, np.array([0.5, 1.0, 1.5, 2.0, 2.5]) * 0.0254)
    np.testing.assert_allclose(blade.chord, np.array([0.4, 0.6, 0.65, 0.5, 0.01]) * 0.0254)
    np.testing.assert_allclose(np.rad2deg(blade.twist), [44.0, 32.0, 23.0, 17.0, 14.0])
    assert blade.root == pytest.approx(0.5 * 0.0254)
    assert blade.diameter == pytest.approx(5.0 * 0.0254)
    assert read_apc_pe0(written(samples.PE0.replace("\n", "\r\n"))) == blade
    # Loads begin at the hub transition if that is further out.
    blade = read_apc_pe0(written(samples.PE0.replace("HUBTRA:  0.50", "HUBTRA:  0.80")))
    assert blade.root == pytest.approx(0.8 * 0.0254)
    assert blade.station[0] == pytest.approx(0.5 * 0.0254)


def test_a_title_tells_the_blades_where_nothing_else_does(written: Writer) -> None:
    told = samples.CSV.replace("# name: hand-made", "# Gemfan 5 x 4,3 x 3")
    untold = told.replace("# blades: 3\n", "")
    assert read_propeller_csv(written(untold)).blades == 3
    assert read_propeller_csv(written(untold), blades=2).blades == 2
    assert read_propeller_csv(written(told.replace("blades: 3", "blades: 4"))).blades == 4


@pytest.mark.parametrize(
    ("name", "blades"),
    [("hq_5x4.3x4_geom.txt", 4), ("da4022_5x3.75_3_blades.txt", 3), ("da4022_5x3.75_0.txt", 2)],
)
def test_a_uiuc_file_is_named_after_its_blades(tmp_path: Path, name: str, blades: int) -> None:
    path = tmp_path / name
    path.write_text(samples.UIUC)
    assert read_uiuc_geometry(path, radius=0.0635).blades == blades


def test_uiuc_scales_with_radius_and_asks_for_its_blades(written: Writer) -> None:
    with pytest.raises(InputError, match="no number of blades; pass --blades"):
        read_uiuc_geometry(written(samples.UIUC), radius=0.15)
    told = written("# blades: 3\n" + samples.UIUC)
    assert read_uiuc_geometry(told, radius=0.15).blades == 3
    blade = read_uiuc_geometry(written(samples.UIUC), blades=2, radius=0.15)
    np.testing.assert_allclose(blade.station, np.array([0.2, 0.4, 0.6, 0.8, 1.0]) * 0.15)
    np.testing.assert_allclose(blade.chord, np.array([0.15, 0.21, 0.22, 0.17, 0.04]) * 0.15)
    np.testing.assert_allclose(np.rad2deg(blade.twist), [38.0, 30.0, 21.0, 15.0, 10.0])
    assert read_uiuc_geometry(written(samples.UIUC), blades=4, radius=0.15).blades == 4


@pytest.mark.parametrize(
    ("column", "per_metre"), [("m", 1.0), ("mm", 1000.0), ("in", 1.0 / 0.0254), ("_over_R", 10.0)]
)
@pytest.mark.parametrize("twist", ["deg", "rad"])
def test_csv_units_give_one_blade(
    written: Writer, column: str, per_metre: float, twist: str
) -> None:
    expected = read_propeller_csv(written(samples.CSV))
    assert (expected.name, expected.blades, expected.radius) == ("hand-made", 3, 0.1)
    stem = column.startswith("_")
    names = (f"r{column}", f"c{column}") if stem else (f"radius_{column}", f"chord_{column}")
    angles = np.rad2deg(expected.twist) if twist == "deg" else expected.twist
    rows = zip(angles, expected.chord * per_metre, expected.station * per_metre, strict=True)
    text = f"# radius_m: 0.1\ntwist_{twist},{names[1]},{names[0]}\n" + "".join(
        f"{float(a)!r},{float(c)!r},{float(r)!r}\n" for a, c, r in rows
    )
    assert same_blade(read_propeller_csv(written(text), blades=2), expected)


def test_csv_with_byte_order_mark_blank_lines_quotes_and_chord_over_radius(written: Writer) -> None:
    fraction = read_propeller_csv(written(samples.CSV.replace("chord_m", "c_over_R")))
    assert fraction.chord[0] == pytest.approx(0.015 * 0.1)
    text = "\ufeff" + samples.CSV.replace("radius_m,", '"radius_m", ').replace("\n", "\n\n")
    assert same_blade(read_propeller_csv(written(text)), read_propeller_csv(written(samples.CSV)))


def test_toml_fields(written: Writer) -> None:
    blade = read_propeller_toml(written(samples.TOML + "root_cutout_m = 0.03\n"))
    assert (blade.name, blade.root, blade.source) == ("hand-made", 0.03, "written for a test")


@pytest.mark.parametrize(
    ("content", "radius"),
    [(samples.PE0, None), (samples.UIUC, 0.1), (samples.CSV, None), (samples.TOML, None)],
    ids=["pe0", "uiuc", "csv", "toml"],
)
def test_content_tells_the_format(written: Writer, content: str, radius: float | None) -> None:
    path = written(content)
    blade = read_geometry_file(path, blades=5, radius=radius)
    assert blade.blades == 5
    assert propeller(str(path), blades=5, radius=radius) == blade
