"""Identify the section constants of every propeller of the UIUC database, with a prior.

The command first identifies the propellers whose blade is in the catalogue. It writes their
distribution to population.toml in the folder of FILE. This distribution is the prior of the other
propellers, which are fitted with the mean blade of their family or of all propellers. A fit takes
a few tenths of a second. The command writes FILE after every four propellers and resumes after an
interruption.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from propmap.catalogue.expected import Population, parse_populations
from propmap.catalogue.identified import PARAMETERS, Identified
from propmap.cli.options import workers_of
from propmap.cli.output import check_output, grid, show, write_text
from propmap.errors import InputError
from tools.catalogue.database import read_uiuc_database, refiled
from tools.catalogue.entries import identify_all, identify_without_blade
from tools.catalogue.files import as_csv, as_toml, parse_identified
from tools.catalogue.population import populations_of
from tools.catalogue.verdict import summary

LEAST_FAMILIES = 8
"""Minimum number of families for an estimate of the distribution over propellers."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser("python -m tools.catalogue", description=__doc__)
    parser.add_argument("loads", type=Path, help="the database's loads.csv, all propellers")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FILE",
        help="CSV of constants; its results from the same data are kept",
    )  # fmt: skip
    parser.add_argument("--cluster", help="a Dask cluster, as for propmap sweep")
    given = parser.parse_args(arguments)
    try:
        identify_database(given.loads, given.output, given.cluster)
    except InputError as error:
        parser.error(str(error))


def identify_database(loads: Path, output: Path, cluster: str | None) -> None:
    """Identify all propellers, write both files, and print the errors of the fits.

    The files are ``output`` and population.toml in the same folder.
    """
    check_output(output, (".csv",))
    every = refiled(read_uiuc_database(loads))
    known = {}
    if output.exists():
        earlier = parse_identified(output.read_text(encoding="utf-8"), str(output))
        known = {one.key: one for one in earlier}
    measured: list[Identified] = []

    def done(before: list[Identified], new: list[Identified]) -> None:
        for number, one in enumerate(new, start=len(before) + 1):
            print(
                f"{number} {one.propeller}, {one.blades} blades: "
                f"C_T {one.thrust_rms:.4f}, C_P {one.power_rms:.4f}; {one.verdict}",
                file=sys.stderr,
            )
        so_far = [*measured, *before, *new]
        keys = {one.key for one in so_far}
        kept = [one for key, one in known.items() if key not in keys]
        write_text(as_csv([*so_far, *kept]), output)

    with workers_of(cluster) as workers:
        # Later steps use constants rounded as in the file, so a resumed run gives the same results.
        measured = parse_identified(as_csv(identify_all(every, known, done, workers)), str(output))
        if len({one.family for one in measured}) < LEAST_FAMILIES:
            write_text(as_csv(measured), output)
            _show(measured, None)
            return
        populations = parse_populations(as_toml(populations_of(measured, workers)))
        others = identify_without_blade(every, measured, populations, known, done, workers)
    write_text(as_csv([*measured, *others]), output)
    write_text(as_toml(populations), output.with_name("population.toml"))
    _show(measured, populations["measured"])


def _show(found: list[Identified], population: Population | None) -> None:
    all_in_all = summary(found)
    errors = [
        (name, f"{median:.4f}", f"{tail:.4f}")
        for name, (median, tail) in (("C_T", all_in_all.thrust), ("C_P", all_in_all.power))
    ]
    worst = [
        (one.tested, f"{one.thrust_rms:.4f}", f"{one.power_rms:.4f}", one.verdict)
        for one in all_in_all.worst
    ]
    parts = [
        f"{all_in_all.propellers} propellers with a measured blade",
        grid("<rms over all rows|median|90 % below", errors),
        grid("<the ten worst|C_T|C_P|<verdict", worst),
    ]
    if population is not None:
        deviations = (np.sqrt(np.diag(part)) for part in (population.between, population.within))
        columns = (population.mean, *population.trend.T, *deviations)
        spread = [
            (name, *(f"{value:.3f}" for value in row))
            for name, *row in zip(PARAMETERS, *columns, strict=True)
        ]
        head = "<ln, or value; drag angle from chord|mean|by ln D|by P/D|between families|within"
        parts.append(grid(head, spread))
    show(None, *parts)


if __name__ == "__main__":
    main()
