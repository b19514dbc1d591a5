"""``propmap predict``: loads at one operating point or at those of a file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.cli.options import (
    Bands,
    RotorChoice,
    StdBySource,
    say_doubts_on_points,
    say_not_counted,
    say_reynolds,
    single_point,
    takes_rotor,
)
from propmap.cli.output import (
    Format,
    FormatOption,
    TextOutput,
    chosen_format,
    emit,
    emit_rows,
    grid,
    json_text,
    show,
)
from propmap.errors import InputError
from propmap.io.csv import OperatingPoints, read_points, std_columns
from propmap.loads import LOADS
from propmap.model.airfoil import SOURCES

if TYPE_CHECKING:
    from rich.table import Table

    from propmap.baselines.hover import HoverModel
    from propmap.results import Loads
    from propmap.rotor import Rotor
    from propmap.typing import Floats


@takes_rotor
def predict(
    choice: RotorChoice,
    rpm: Annotated[float | None, typer.Option("--rpm", help="Rotational speed [1/min].")] = None,
    speed: Annotated[
        float | None, typer.Option("--speed", help="Speed through the air [m/s].")
    ] = None,
    beta: Annotated[
        float | None,
        typer.Option("--beta", help="Velocity to axis [deg]: 0 climb, 90 edgewise, 180 descent."),
    ] = None,
    height: Annotated[
        float | None,
        typer.Option(
            "--height", help="Of the disk above level ground [m]; by default far from it."
        ),
    ] = None,
    points: Annotated[
        Path | None,
        typer.Option(
            "--points",
            metavar="FILE.csv",
            help="Points: rpm, speed_mps, beta_deg, and height_m if there is ground.",
        ),
    ] = None,
    format_: FormatOption = None,
    output: TextOutput = None,
    bands: Bands = True,
    std_by_source: StdBySource = False,
) -> None:
    """All six loads and the power at operating points, and how sure they are."""
    where = _points(rpm, speed, beta, points, height=height)
    chosen = chosen_format(format_, output)
    rotor = choice.rotor()
    say_reynolds(rotor.model, *where.si)
    say_doubts_on_points(rotor.model, *where.si)
    loads = where.loads(rotor)
    spread = std_columns(loads, by_source=std_by_source) if bands else {}
    if spread:
        say_not_counted(rotor.model)
        if where.further:
            typer.echo("note: the deviations leave out what the ground's factor errs by", err=True)
    if chosen is Format.table:
        _show_table(output, rotor, where, loads, spread, one=points is None)
    elif points is None and chosen is Format.json:
        emit(json_text(where.rows(loads, spread)[0]), output)
    else:
        emit_rows([*where.columns, *spread], where.rows(loads, spread), chosen, output)


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
        return read_points(file)[0]
    if rpm is None or speed is None or beta is None:
        missing = next(option for option, value in given.items() if value is None)
        raise InputError(f"{missing} is missing", "give --rpm, --speed and --beta, or --points")
    return single_point(rpm, speed, beta, **further)


def _show_table(
    output: Path | None,
    rotor: Rotor,
    where: OperatingPoints,
    loads: Loads,
    spread: Mapping[str, Floats],
    *,
    one: bool,
) -> None:
    from propmap.baselines.hover import HoverModel
    from propmap.report.words import motor_note

    hover = HoverModel.of(rotor)
    note = motor_note(rotor, loads, *where.si[1:])
    blade = rotor.model.propeller
    show(
        output,
        f"{blade.name}, {blade.blades} blades, R = {blade.radius:.4g} m; airfoil "
        f"{rotor.model.law_title}; rho = {rotor.model.air.density:.4g} kg/m^3",
        _one_point(where, loads, spread, hover)
        if one
        else _many_points(where, loads, spread, hover),
        *([f"note: {note}"] if note else []),
    )


def _one_point(
    where: OperatingPoints, loads: Loads, spread: Mapping[str, Floats], hover: HoverModel
) -> Table:
    (rpm,), (speed,), (beta,) = where.rpm, where.speed_mps, where.beta_deg
    still = {name: float(values[0]) for name, values in hover.loads(where.si[0]).items()}
    kinds = [
        what for what in ("std", *(f"std_{s}" for s in SOURCES)) if f"power_{what}_W" in spread
    ]

    def deviations(columns: Iterable[str]) -> list[str]:
        return [f"{spread[column][0]:.2g}" for column in columns]

    rows = [
        *(
            (
                load.label,
                _digits(getattr(loads, name)[0]),
                *deviations(load.column_of(what) for what in kinds),
                _digits(still[name]),
                load.unit,
            )
            for name, load in LOADS.items()
        ),
        (
            "power",
            _digits(loads.power[0]),
            *deviations(f"power_{what}_W" for what in kinds),
            _digits(still["torque"] * where.si[0][0]),
            "W",
        ),
    ]
    none = [""] * len(kinds)
    rows += [
        ("mean inflow", _digits(loads.mean_inflow[0]), *none, "", "m/s"),
        ("reverse flow", _digits(100.0 * loads.reverse_flow[0]), *none, "", "% of the disk"),
        ("roots of (11)", str(loads.roots[0]), *none, "", ""),
        ("status", str(loads.status[0]), *none, "", ""),
    ]
    title = f"{rpm:g} rpm, {speed:g} m/s, beta {beta:g} deg"
    title += "".join(f", {name} {values[0]:g} m" for name, values in where.further.items())
    heads = [what.replace("std_", "by ").replace("std", "std. dev.") for what in kinds]
    caption = "within two standard deviations with a probability of 95 %" if kinds else ""
    return grid("|".join(("<", "propmap", *heads, "hover model", "<unit")), rows, title, caption)


def _many_points(
    where: OperatingPoints, loads: Loads, spread: Mapping[str, Floats], hover: HoverModel
) -> Table:
    still, columns = hover.loads(where.si[0]), {}
    for name, load in LOADS.items():
        columns[f"{load.head} [{load.unit}]"] = getattr(loads, name)
        if not load.inplane:
            if spread:
                columns[f"s({load.head}) [{load.unit}]"] = spread[load.column_of("std")]
            columns[f"{load.head} h [{load.unit}]"] = still[name]
    columns |= {"P [W]": loads.power, "reverse [%]": 100.0 * loads.reverse_flow}
    rows = []
    for i, status in enumerate(loads.status.tolist()):
        given = [where.rpm[i], where.speed_mps[i], where.beta_deg[i]]
        given += [values[i] for values in where.further.values()]
        cells = [f"{v:g}" for v in given] + [_digits(column[i]) for column in columns.values()]
        rows.append([*cells, str(loads.roots[i]), status])
    caption = "T h, Q h: thrust and torque of the hover model"
    if spread:
        caption += "; s: standard deviations, those of the other loads with --format csv"
    more = (f"{name} [m]" for name in where.further)
    heads = "|".join(("rpm", "V [m/s]", "beta [deg]", *more, *columns, "roots", "<status"))
    return grid(heads, rows, caption=caption)


def _digits(value: float) -> str:
    return f"{value:.4g}"
