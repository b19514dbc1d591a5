"""``propmap predict``: loads at one operating point or at those of a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.cli.operating_points import COLUMNS, RPM, OperatingPoints, single_point
from propmap.cli.output import (
    Format,
    FormatOption,
    TextOutput,
    check_output,
    chosen_format,
    csv_text,
    emit,
    json_text,
    show,
)
from propmap.cli.points_file import read_points
from propmap.cli.rotor_options import RotorChoice, say_reynolds, takes_rotor
from propmap.errors import InputError
from propmap.loads import LOADS

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from propmap.baselines.hover import HoverModel
    from propmap.rotor import Loads, Rotor


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
    points: Annotated[
        Path | None,
        typer.Option("--points", metavar="FILE.csv", help="Points: rpm, speed_mps, beta_deg."),
    ] = None,
    format_: FormatOption = None,
    output: TextOutput = None,
) -> None:
    """Thrust, rotor drag, torque, rolling moment and power at operating points."""
    where = _points(rpm, speed, beta, points)
    if output is not None:
        check_output(output)
    chosen = chosen_format(format_, output)
    rotor = choice.rotor(where.count)
    say_reynolds(rotor.model, *where.si)
    loads = where.loads(rotor)
    if chosen is Format.table:
        _show_table(output, rotor, where, loads, one=points is None)
        return
    rows = where.rows(loads)
    if chosen is Format.json:
        emit(json_text(rows if points is not None else rows[0]), output)
    else:
        emit(csv_text(COLUMNS, rows), output)


def _points(
    rpm: float | None, speed: float | None, beta: float | None, file: Path | None
) -> OperatingPoints:
    given = {"--rpm": rpm, "--speed": speed, "--beta": beta}
    if file is not None:
        both = [option for option, value in given.items() if value is not None]
        if both:
            raise InputError(f"both --points and {both[0]} are given", "give one or the other")
        return read_points(file).points
    if rpm is None or speed is None or beta is None:
        missing = next(option for option, value in given.items() if value is None)
        raise InputError(f"{missing} is missing", "give --rpm, --speed and --beta, or --points")
    return single_point(rpm, speed, beta)


def _show_table(
    output: Path | None, rotor: Rotor, where: OperatingPoints, loads: Loads, *, one: bool
) -> None:
    from propmap.baselines.hover import HoverModel

    hover = HoverModel.of(rotor)
    table = _one_point(where, loads, hover) if one else _many_points(where, loads, hover)

    def draw(console: Console) -> None:
        blade = rotor.model.propeller
        console.print(
            f"{blade.name}, {blade.blades} blades, R = {blade.radius:.4g} m; "
            f"airfoil {rotor.model.law_title}; rho = {rotor.model.air.density:.4g} kg/m^3"
        )
        console.print(table)

    show(output, draw)


def _one_point(where: OperatingPoints, loads: Loads, hover: HoverModel) -> Table:
    from rich.table import Table

    (rpm,), (speed,), (beta,) = where.rpm, where.speed_mps, where.beta_deg
    omega = rpm * RPM
    still = hover.loads(omega)
    rows = [
        *(
            (load.label, getattr(loads, name)[0], load.unit, _digits(float(still[name])))
            for name, load in LOADS.items()
        ),
        ("power", loads.power[0], "W", _digits(float(still["torque"]) * omega)),
        ("mean inflow", loads.mean_inflow[0], "m/s", ""),
        ("reverse flow", 100.0 * loads.reverse_flow[0], "% of the disk", ""),
    ]
    table = Table(title=f"{rpm:g} rpm, {speed:g} m/s, beta {beta:g} deg", title_justify="left")
    table.add_column("")
    table.add_column("propmap", justify="right")
    table.add_column("hover model", justify="right")
    table.add_column("unit")
    for name, value, unit, baseline in rows:
        table.add_row(name, _digits(value), baseline, unit)
    table.add_row("roots of (11)", str(loads.roots[0]), "", "")
    table.add_row("status", str(loads.status[0]), "", "")
    return table


def _many_points(where: OperatingPoints, loads: Loads, hover: HoverModel) -> Table:
    from rich.table import Table

    table = Table(caption="T h, Q h: thrust and torque of the hover model", caption_justify="left")
    still = hover.loads(where.rpm * RPM)
    columns = {}
    for name, load in LOADS.items():
        columns[f"{load.head} [{load.unit}]"] = getattr(loads, name)
        if not load.inplane:
            columns[f"{load.head} h [{load.unit}]"] = still[name]
    columns |= {"P [W]": loads.power, "reverse [%]": 100.0 * loads.reverse_flow}
    for head in ("rpm", "V [m/s]", "beta [deg]", *columns, "roots"):
        table.add_column(head, justify="right")
    table.add_column("status", no_wrap=True)
    for i, status in enumerate(loads.status.tolist()):
        given = (where.rpm[i], where.speed_mps[i], where.beta_deg[i])
        cells = [f"{v:g}" for v in given] + [_digits(column[i]) for column in columns.values()]
        table.add_row(*cells, str(loads.roots[i]), status)
    return table


def _digits(value: float) -> str:
    return f"{value:.4g}"
