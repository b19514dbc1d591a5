"""``propmap predict``: loads at one operating point, or at the operating points of a file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
from typer import Option

from propmap.bands import SOURCES
from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.errors import InputError
from propmap.io.csv import OperatingPoints, read_points, std_columns
from propmap.loads import LOADS
from propmap.model.model import installation_note

if TYPE_CHECKING:
    from rich.table import Table

    from propmap.results import Loads
    from propmap.typing import Floats


@opt.takes_choices
def predict(
    choice: opt.RotorChoice,
    rpm: Annotated[
        float | None,
        Option(
            help="Rotational speed in rpm; negative for a propeller that turns backward, with the "
            "trailing edges first."
        ),
    ] = None,
    speed: Annotated[float | None, Option(help="Airspeed in m/s (default: 0).")] = None,
    beta: Annotated[
        float | None,
        Option(
            help=f"{opt.BETA_HELP} in degrees: 0 climb, 90 edgewise flight, 180 descent "
            "(default: 0)."
        ),
    ] = None,
    height: Annotated[
        float | None,
        Option(help="Height of the disk above level ground in m (default: no ground effect)."),
    ] = None,
    ceiling: Annotated[
        float | None,
        Option(help="Distance of a level ceiling above the disk in m (default: no ceiling)."),
    ] = None,
    points: Annotated[
        Path | None,
        Option(
            metavar="FILE.csv",
            help="Operating points: columns rpm, speed_mps, beta_deg, and optionally height_m and "
            "ceiling_m.",
        ),
    ] = None,
    format_: out.FormatOption = None,
    output: out.TextOutput = None,
    bands: opt.Bands = True,
    std_by_source: opt.StdBySource = False,
) -> None:
    """Predict the loads and power of a propeller at operating points."""
    opt.check_bands(bands, std_by_source)
    where = _points(rpm, speed, beta, points, height=height, ceiling=ceiling)
    chosen = out.chosen_format(format_, output)
    rotor = choice.rotor()
    omega, speeds, angles = where.si
    opt.note_points(rotor.model, omega, speeds, angles)
    loads = rotor.loads(omega, speeds, angles, **where.further)
    if count := int(np.count_nonzero((loads.roots > 1) & (omega >= 0.0))):
        out.note(
            f"multiple_roots in {count} of {omega.size} points: near stall the momentum balance "
            "has several solutions; propmap uses the largest one, which has attached flow"
        )
    spread = std_columns(loads, by_source=std_by_source) if bands else {}
    if spread:
        opt.note_not_counted(rotor.model)
        opt.note_untested_bands(rotor.model, np.abs(omega), speeds, angles)
    if chosen != "table":
        rows = where.rows(loads, spread)
        whole = None if points else rows[0]
        out.emit_rows([*where.columns, *spread], rows, chosen, output, whole=whole)
        return

    from propmap.hover import HoverModel

    hover = HoverModel.from_rotor(rotor).loads(np.where(omega < 0.0, np.nan, omega))
    hover["power"] = hover["torque"] * omega
    blade = rotor.model.propeller
    out.show(
        output,
        f"{blade.name}, {blade.summary}; airfoil "
        f"{rotor.model.law_title}; rho = {rotor.model.air.density:.4g} kg/m^3",
        (_many_points if points else _one_point)(where, loads, spread, hover),
        *([f"note: {installation_note(rotor.model)}"] if np.any(loads.drag) else []),
    )


def _points(
    rpm: float | None,
    speed: float | None,
    beta: float | None,
    file: Path | None,
    **further: float | None,
) -> OperatingPoints:
    given = {"--rpm": rpm, "--speed": speed, "--beta": beta}
    if file is not None:
        more = {f"--{name}": value for name, value in further.items()}
        both = [option for option, value in (given | more).items() if value is not None]
        if both:
            raise InputError(f"both --points and {both[0]} are given", "give one or the other")
        found, _, remarks = read_points(file)
        out.note(*remarks)
        return found
    if rpm is None:
        raise InputError("--rpm is missing", "give --rpm, or a file with --points")
    return opt.single_point(rpm, speed or 0.0, beta or 0.0, **further)


def _one_point(
    where: OperatingPoints, loads: Loads, spread: Mapping[str, Floats], hover: Mapping[str, Floats]
) -> Table:
    """Return a table with a row per load and a column per kind of standard deviation."""
    sources = ["std", *(f"std_{source}" for source in SOURCES)]
    kinds = [kind for kind in sources if f"power_{kind}_W" in spread]
    units = {name: load.unit for name, load in LOADS.items()} | {"power": "W"}
    rows = []
    for name, unit in units.items():
        load = LOADS.get(name)
        columns = [load.column_of(kind) if load else f"power_{kind}_W" for kind in kinds]
        own, given = (
            out.digits(getattr(loads, name)[0]),
            [f"{spread[one][0]:.2g}" for one in columns],
        )
        rows.append((load.label if load else name, own, *given, out.digits(hover[name][0]), unit))
    none = [""] * len(kinds)
    rows += [
        ("mean inflow", out.digits(loads.mean_inflow[0]), *none, "", "m/s"),
        ("reverse flow", out.digits(100.0 * loads.reverse_flow[0]), *none, "", "% of the disk"),
        ("inflow solutions", str(loads.roots[0]), *none, "", ""),
        ("status", str(loads.status[0]), *none, "", ""),
    ]
    title = f"{where.rpm[0]:g} rpm, {where.speed_mps[0]:g} m/s, beta {where.beta_deg[0]:g} deg"
    title += "".join(f", {name} {values[0]:g} m" for name, values in where.further.items())
    heads = [kind.replace("std_", "by ").replace("std", "std. dev.") for kind in kinds]
    caption = "95 % band: two standard deviations on either side" if kinds else ""
    return out.grid(
        "|".join(("<", "propmap", *heads, "hover model", "<unit")), rows, title, caption
    )


def _many_points(
    where: OperatingPoints, loads: Loads, spread: Mapping[str, Floats], hover: Mapping[str, Floats]
) -> Table:
    """Return a table with a row per operating point."""
    columns = {}
    for name, load in LOADS.items():
        columns[f"{load.head} [{load.unit}]"] = getattr(loads, name)
        if not load.inplane:
            if spread:
                columns[f"s({load.head}) [{load.unit}]"] = spread[load.column_of("std")]
            columns[f"{load.head} h [{load.unit}]"] = hover[name]
    columns |= {"P [W]": loads.power, "reverse [%]": 100.0 * loads.reverse_flow}
    rows = []
    for i, status in enumerate(loads.status.tolist()):
        given = (where.rpm, where.speed_mps, where.beta_deg, *where.further.values())
        cells = [f"{values[i]:g}" for values in given]
        cells += [out.digits(column[i]) for column in columns.values()]
        rows.append([*cells, str(loads.roots[i]), status])
    caption = "T h, Q h: thrust and torque of the hover model"
    if spread:
        caption += "; s: standard deviations; for the other loads see --format csv"
    more = (f"{name} [m]" for name in where.further)
    heads = "|".join(("rpm", "V [m/s]", "beta [deg]", *more, *columns, "roots", "<status"))
    return out.grid(heads, rows, caption=caption)
