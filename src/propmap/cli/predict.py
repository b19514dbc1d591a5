"""``propmap predict``: loads at one operating point or at those of a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.cli.operating_points import COLUMNS, OperatingPoints, single_point
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
from propmap.cli.plausibility import say_doubts_on_points
from propmap.cli.points_file import read_points
from propmap.cli.rotor_options import RotorChoice, say_reynolds, takes_rotor
from propmap.errors import InputError
from propmap.loads import LOADS

if TYPE_CHECKING:
    from rich.table import Table

    from propmap.baselines.hover import HoverModel
    from propmap.results import Loads
    from propmap.rotor import Rotor


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
    """All six loads and the power at operating points."""
    where = _points(rpm, speed, beta, points)
    chosen = chosen_format(format_, output)
    rotor = choice.rotor(where.count)
    say_reynolds(rotor.model, *where.si)
    say_doubts_on_points(rotor.model, *where.si)
    loads = where.loads(rotor)
    if chosen is Format.table:
        _show_table(output, rotor, where, loads, one=points is None)
    elif points is None and chosen is Format.json:
        emit(json_text(where.rows(loads)[0]), output)
    else:
        emit_rows(COLUMNS, where.rows(loads), chosen, output)


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
    from propmap.report.mounted_motor import motor_note

    hover = HoverModel.of(rotor)
    note = motor_note(rotor, loads, *where.si[1:])
    blade = rotor.model.propeller
    show(
        output,
        f"{blade.name}, {blade.blades} blades, R = {blade.radius:.4g} m; airfoil "
        f"{rotor.model.law_title}; rho = {rotor.model.air.density:.4g} kg/m^3",
        _one_point(where, loads, hover) if one else _many_points(where, loads, hover),
        *([f"note: {note}"] if note else []),
    )


def _one_point(where: OperatingPoints, loads: Loads, hover: HoverModel) -> Table:
    (rpm,), (speed,), (beta,) = where.rpm, where.speed_mps, where.beta_deg
    still = {name: float(values[0]) for name, values in hover.loads(where.si[0]).items()}
    rows = [
        *(
            (load.label, _digits(getattr(loads, name)[0]), _digits(still[name]), load.unit)
            for name, load in LOADS.items()
        ),
        ("power", _digits(loads.power[0]), _digits(still["torque"] * where.si[0][0]), "W"),
        ("mean inflow", _digits(loads.mean_inflow[0]), "", "m/s"),
        ("reverse flow", _digits(100.0 * loads.reverse_flow[0]), "", "% of the disk"),
        ("roots of (11)", str(loads.roots[0]), "", ""),
        ("status", str(loads.status[0]), "", ""),
    ]
    title = f"{rpm:g} rpm, {speed:g} m/s, beta {beta:g} deg"
    return grid("<|propmap|hover model|<unit", rows, title)


def _many_points(where: OperatingPoints, loads: Loads, hover: HoverModel) -> Table:
    still, columns = hover.loads(where.si[0]), {}
    for name, load in LOADS.items():
        columns[f"{load.head} [{load.unit}]"] = getattr(loads, name)
        if not load.inplane:
            columns[f"{load.head} h [{load.unit}]"] = still[name]
    columns |= {"P [W]": loads.power, "reverse [%]": 100.0 * loads.reverse_flow}
    rows = []
    for i, status in enumerate(loads.status.tolist()):
        given = (where.rpm[i], where.speed_mps[i], where.beta_deg[i])
        cells = [f"{v:g}" for v in given] + [_digits(column[i]) for column in columns.values()]
        rows.append([*cells, str(loads.roots[i]), status])
    caption = "T h, Q h: thrust and torque of the hover model"
    heads = "|".join(("rpm", "V [m/s]", "beta [deg]", *columns, "roots", "<status"))
    return grid(heads, rows, caption=caption)


def _digits(value: float) -> str:
    return f"{value:.4g}"
