"""``propmap fit catalogue``: section constants of all propellers of the UIUC database."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from propmap.catalogue.identified import Identified, as_csv, parse_identified
from propmap.cli.options import Cluster, workers_of
from propmap.cli.output import check_output, grid, show, write_text

if TYPE_CHECKING:
    from propmap.catalogue.expected import Population

LEAST_FAMILIES = 8
"""Below this number there is no saying how constants are spread over propellers."""


def fit_catalogue(
    loads: Annotated[
        Path, typer.Argument(metavar="LOADS", help="The database's loads.csv, all propellers.")
    ],
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            metavar="FILE",
            help="CSV of constants; results in it of the same data are kept.",
        ),
    ],
    cluster: Cluster = None,
) -> None:
    """Identify the section constants of every propeller of the UIUC database, with a prior.

    Those whose blade is in the catalogue come first; from them, the spread over propellers goes
    into population.toml beside FILE. It is the prior of the others, which are fitted with the mean
    blade of their family or of all. Each takes some tenths of a second. FILE is written after every
    four: started again, the command goes on where it was.
    """
    from propmap.catalogue.expected import as_toml
    from propmap.fit.population.catalogue import identify_all, identify_without_blade
    from propmap.fit.population.misfiled import refiled
    from propmap.fit.population.populations import populations_of
    from propmap.io.uiuc import read_uiuc_database

    check_output(output, (".csv",))
    every = refiled(read_uiuc_database(loads))
    known = {}
    if output.exists():
        earlier = parse_identified(output.read_text(encoding="utf-8"), str(output))
        known = {one.key: one for one in earlier}

    measured: list[Identified] = []

    def done(before: list[Identified], new: list[Identified]) -> None:
        for number, one in enumerate(new, start=len(before) + 1):
            typer.echo(
                f"{number} {one.propeller}, {one.blades} blades: "
                f"C_T {one.thrust_rms:.4f}, C_P {one.power_rms:.4f}; {one.verdict}",
                err=True,
            )
        so_far = [*measured, *before, *new]
        rest = {one.key for one in so_far}
        kept = [one for key, one in known.items() if key not in rest]
        write_text(as_csv([*so_far, *kept]), output)

    with workers_of(cluster) as workers:
        measured = identify_all(every, known, done, workers)
        if len({one.family for one in measured}) < LEAST_FAMILIES:
            write_text(as_csv(measured), output)
            _tell(measured, None)
            return
        populations = populations_of(measured, workers)
        others = identify_without_blade(every, measured, populations, known, done, workers)
    write_text(as_csv([*measured, *others]), output)
    write_text(as_toml(populations), output.with_name("population.toml"))
    _tell(measured, populations["measured"])


def _tell(found: list[Identified], population: Population | None) -> None:
    import numpy as np

    from propmap.catalogue.identified import PARAMETERS
    from propmap.fit.population.summary import summary

    all_in_all = summary(found)
    errors = [
        (name, f"{median:.4f}", f"{tail:.4f}")
        for name, (median, tail) in (("C_T", all_in_all.thrust), ("C_P", all_in_all.power))
    ]
    worst = [
        (one.tested, f"{one.thrust_rms:.4f}", f"{one.power_rms:.4f}", one.verdict)
        for one in all_in_all.worst
    ]
    told = [
        f"{all_in_all.propellers} propellers with a measured blade",
        grid("<rms over all rows|median|90 % below", errors),
        grid("<the ten worst|C_T|C_P|<verdict", worst),
    ]
    if population is not None:
        columns = (
            population.mean,
            *population.trend.T,
            np.sqrt(np.diag(population.between)),
            np.sqrt(np.diag(population.within)),
        )
        spread = [
            (name, *(f"{value:.3f}" for value in row))
            for name, *row in zip(PARAMETERS, *columns, strict=True)
        ]
        head = "<ln, or value; drag angle from chord|mean|by ln D|by P/D|between families|within"
        told.append(grid(head, spread))
    show(None, *told)
