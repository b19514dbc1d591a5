"""``propmap check``: a parameter set against measurements it has not seen."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
import numpy as np
import typer

from propmap.catalogue.lookup import airfoil
from propmap.cli.options import (
    Corrections,
    ModelOption,
    say_doubts,
    say_expected,
    say_reynolds,
    with_physics,
)
from propmap.cli.output import (
    Format,
    FormatOption,
    TextOutput,
    chosen_format,
    emit,
    grid,
    json_text,
    show,
)
from propmap.errors import InputError
from propmap.io.csv import csv_text
from propmap.model.corrections import in_words
from propmap.model.model import Air, Model
from propmap.model.plausibility import doubts_on_blade

if TYPE_CHECKING:
    from rich.table import Table

    from propmap.fit.comparison import SpeedErrors
    from propmap.fit.learned_residual import AddedForce
    from propmap.model.airfoil import Airfoil, SectionTable


def check(
    fit: Annotated[Path, typer.Argument(metavar="FIT.toml", help="Fit, parameter set or table.")],
    data: Annotated[
        list[str], typer.Argument(metavar="DATA...", help="Tunnel data, or flight logs.")
    ],
    vehicle: Annotated[
        Path | None,
        typer.Option("--vehicle", metavar="VEHICLE.toml", help="Vehicle, for flight logs."),
    ] = None,
    prop: Annotated[
        str | None,
        typer.Option("--prop", metavar="PROP", help="Propeller, where the file has no [fit]."),
    ] = None,
    model: ModelOption = None,
    correction: Corrections = None,
    format_: FormatOption = None,
    output: TextOutput = None,
) -> None:
    """Errors per load and band of speed, beside the hover model's."""
    chosen = chosen_format(format_, output)
    law = with_physics(airfoil(fit), model, correction)
    found, learned = _compare(fit, law, data, vehicle, prop)
    if chosen is Format.table:
        tables = [_table(found, law)]
        if learned:
            tables.append(_table(learned, law, ", with the learned residual"))
        show(output, *tables)
        return
    loads = {
        name: _numbers(c.all) | {"by_speed": {band: _numbers(e) for band, e in c.by_speed.items()}}
        for name, c in found.items()
    }
    if chosen is Format.json:
        rows = max((c.all.rows for c in found.values()), default=0)
        told = {"corrections": list(law.corrections or ()), "rows": rows, "loads": loads}
        if learned:
            told["with_learned_residual"] = {n: _numbers(c.all) for n, c in learned.items()}
        emit(json_text(told), output)
        return
    columns = ("load", "band", "rows", "rms", "relative_rms", "bias", "worst", "hover_rms")
    bands = [
        {"load": name, "band": band} | numbers
        for name, load in loads.items()
        for band, numbers in {"all": load, **load["by_speed"]}.items()
    ]
    emit(csv_text(columns, bands), output)


def _compare(
    fit: Path, law: Airfoil | SectionTable, data: list[str], vehicle: Path | None, prop: str | None
) -> tuple[dict[str, SpeedErrors], dict[str, SpeedErrors]]:
    """Errors of the physics, and of it with a learned residual where the fit has one."""
    from propmap.catalogue.lookup import propeller
    from propmap.fit.comparison import compare_forces, compare_tunnel, flight_forces, values_for
    from propmap.fit.files import is_fit, read_fit

    fitted = read_fit(fit) if is_fit(fit) else None
    if vehicle is not None:
        from propmap.cli.fit_flight import read_flights
        from propmap.fit.flight import wing_values
        from propmap.vehicle.files import read_vehicle

        if prop is not None:
            raise InputError("--prop is given with a vehicle, which has its own", "leave it out")
        file = read_vehicle(vehicle)
        paths = [Path(item) for item in data]
        cutoff = fitted.low_pass if fitted else 0.0
        flights = read_flights(paths, file, "balance", seconds=2.0, samples=2**31, low_pass=cutoff)
        values, told = wing_values(file.vehicle), list[str]()
        if fitted:
            values, told = values_for(fitted, file.vehicle, flights.log, paths)
        forces = flight_forces(file.vehicle, flights.log, law, values)
        for text in (*flights.remarks, *told):
            typer.echo(f"note: {text}", err=True)
        errors = compare_forces(file.vehicle, flights.log, forces)
        learned = fitted.learned_residual if fitted else None
        if learned is None:
            return errors, {}
        added = learned.at(file.vehicle, flights.log)
        with_it = np.concatenate([forces.model[:, :3] + added.force, forces.model[:, 3:]], axis=1)
        typer.echo(f"note: {_envelope(added)}", err=True)
        corrected = compare_forces(file.vehicle, flights.log, replace(forces, model=with_it))
        return errors, corrected
    from propmap.fit.tunnel import doubts_on_tunnel, read_tunnel

    if fitted is None and prop is None:
        raise InputError(
            "which propeller is not said: the file has no table [fit]", "add --prop NAME", str(fit)
        )
    air = fitted.model.air if fitted else Air()
    blade = fitted.model.propeller if fitted and prop is None else propeller(prop or "")
    model = Model(blade, law, air)
    measured = read_tunnel(data, blade, air)
    say_reynolds(model, measured.omega, measured.speed, measured.beta)
    if prop is not None:
        say_expected(prop)
    say_doubts([*doubts_on_blade(blade), *doubts_on_tunnel(data, blade, air)])
    return compare_tunnel(model, measured), {}


def _envelope(added: AddedForce) -> str:
    """Where a learned residual acts, in words."""
    faded, off = (float(np.mean(added.status == word)) for word in ("faded", "off"))
    return (
        "the fit has a learned residual, told apart from the physics; outside the flights that it "
        f"was trained on it fades at {100.0 * faded:.1f} % of the samples and is off at "
        f"{100.0 * off:.1f} %"
    )


def _numbers(errors: Any) -> dict[str, Any]:
    return {k: None if np.isnan(v) else v for k, v in msgspec.structs.asdict(errors).items()}


def _table(found: dict[str, SpeedErrors], law: Airfoil | SectionTable, besides: str = "") -> Table:
    rows = [
        (
            name if band == "all" else "",
            band,
            str(e.rows),
            f"{e.rms:.4g}",
            f"{100.0 * e.relative_rms:.1f} %",
            f"{e.bias:+.3g}",
            f"{e.worst:+.3g}",
            f"{e.hover_rms:.4g}",
        )
        for name, c in found.items()
        for band, e in {"all": c.all, **c.by_speed}.items()
    ]
    added = f", with {in_words(law.corrections or ())}{besides}"
    heads = "<load|<speed|rows|rms|relative|bias|worst|hover model's rms"
    return grid(heads, rows, f"Model minus measurement{added}")
