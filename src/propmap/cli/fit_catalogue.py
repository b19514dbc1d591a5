"""``propmap fit catalogue``: section constants of all propellers of the UIUC database."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from propmap.catalogue.identified import Identified, as_csv, parse_identified
from propmap.cli.output import check_output, grid, show, write_text


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
) -> None:
    """Identify the section constants of every propeller of the UIUC database, with a prior.

    Those whose blade is in the catalogue are fitted, in about a second each.  The file is written
    after each of them: started again, the command goes on where it was.
    """
    from propmap.fit.population.catalogue import identify_all
    from propmap.fit.population.misfiled import refiled
    from propmap.io.uiuc_database import read_uiuc_database

    check_output(output, (".csv",))
    every = refiled(read_uiuc_database(loads))
    known = {}
    if output.exists():
        earlier = parse_identified(output.read_text(encoding="utf-8"), str(output))
        known = {one.key: one for one in earlier}

    def done(found: list[Identified]) -> None:
        last = found[-1]
        typer.echo(
            f"{len(found)} {last.propeller}, {last.blades} blades: "
            f"C_T {last.thrust_rms:.4f}, C_P {last.power_rms:.4f}; {last.verdict}",
            err=True,
        )
        rest = {one.key for one in found}
        kept = [one for key, one in known.items() if key not in rest]
        write_text(as_csv([*found, *kept]), output)

    found = identify_all(every, known, done)
    write_text(as_csv(found), output)
    _tell(found)


def _tell(found: list[Identified]) -> None:
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
    spread = [
        (name, *(f"{value:.3f}" for value in row))
        for name, row in zip(PARAMETERS, np.stack(all_in_all.spread, axis=1), strict=True)
    ]
    show(
        None,
        f"{all_in_all.propellers} propellers",
        grid("<rms over all rows|median|90 % below", errors),
        grid("<the ten worst|C_T|C_P|<verdict", worst),
        grid("<ln, or value; drag angle from chord|mean|between families|within", spread),
    )
