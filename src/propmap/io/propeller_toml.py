"""Blade geometry in propmap's own format, one TOML file per propeller."""

from __future__ import annotations

import os
from typing import Any

from propmap.io.blade_table import build_propeller, check_radius
from propmap.io.text_file import read_lines
from propmap.io.toml_table import TomlTable, parse_toml
from propmap.model.blade_check import check_blades, check_root_cutout
from propmap.model.propeller import Propeller

SCHEMA = 1
KEYS = (
    *("schema", "name", "title", "family", "source", "citation"),
    *("blades", "radius_m", "root_cutout_m", "station_m", "chord_m", "twist_rad"),
)


def read_propeller_toml(
    path: str | os.PathLike[str], blades: int | None = None, radius: float | None = None
) -> Propeller:
    """A propeller from a file in the format of the catalogue.

    Parameters
    ----------
    path : path
        Of the file.
    blades : int, optional
        Replaces the file's.
    radius : float, optional
        Tip radius [m], which must agree with the file.

    Raises
    ------
    InputError
        Naming the field.
    """
    where = os.fspath(path)
    return parse_propeller_toml("\n".join(read_lines(path)), where, blades, radius)


def parse_propeller_toml(
    text: str, where: str, blades: int | None = None, radius: float | None = None
) -> Propeller:
    """``read_propeller_toml`` for text already in memory; ``where`` names it in messages."""
    table = TomlTable(parse_toml(text, where, SCHEMA), where, KEYS)
    station, chord, twist = (table.numbers(key) for key in ("station_m", "chord_m", "twist_rad"))
    for key in ("title", "family"):
        table.text(key, '"..."', default="")
    result = build_propeller(
        where,
        [f"entry {i}" for i in range(station.size)],
        table.text("name", '"..."'),
        check_blades(table.need("blades", "2") if blades is None else blades, where),
        station,
        chord,
        twist,
        source=table.text("source", '"..."', default=""),
        citation=table.text("citation", '"..."', default=""),
    )
    for stated in (table.number("radius_m", "the tip radius in m"), radius):
        if stated is not None:
            check_radius(result.radius, stated, where)
    if "root_cutout_m" not in table:
        return result
    root = table.number("root_cutout_m", "a length in m")
    return result.with_root_cutout(check_root_cutout(root, station, f"{where}: root_cutout_m"))


def propeller_toml(blade: Propeller) -> str:
    """The text of a file that ``read_propeller_toml`` reads as the same ``blade``."""
    import tomli_w

    fields: dict[str, Any] = {
        "schema": SCHEMA,
        "name": blade.name,
        "blades": blade.blades,
        "radius_m": blade.radius,
        "station_m": blade.station.tolist(),
        "chord_m": blade.chord.tolist(),
        "twist_rad": blade.twist.tolist(),
    }
    if blade.root_cutout is not None:
        fields["root_cutout_m"] = blade.root_cutout
    texts = {"source": blade.source, "citation": blade.citation}
    fields |= {key: text for key, text in texts.items() if text}
    return tomli_w.dumps(fields)
