"""Files of the catalogue: identified constants and populations."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import fields

from propmap.catalogue.expected import Population
from propmap.catalogue.identified import (
    COUNTS,
    ERRORS,
    PAIRS,
    PARAMETERS,
    RANGES,
    TEXTS,
    Identified,
    entry_of,
    pair_name,
)
from propmap.errors import InputError
from propmap.typing import Floats

HEADER = [*TEXTS, *COUNTS, *RANGES, *PARAMETERS, *(pair_name(i, j) for i, j in PAIRS), *ERRORS]


def as_csv(entries: Sequence[Identified]) -> str:
    """Return the text of a file of identified constants, for ``parse_identified``."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(HEADER)
    for one in entries:
        numbers = [
            *(getattr(one, name) for name in RANGES),
            *one.constants,
            *(one.covariance[pair] for pair in PAIRS),
        ]
        plain = [getattr(one, name) for name in (*TEXTS, *COUNTS)]
        errors = [f"{getattr(one, name):.5f}" for name in ERRORS]
        writer.writerow([*plain, *(f"{value:.8g}" for value in numbers), *errors])
    return text.getvalue()


def parse_identified(text: str, where: str) -> list[Identified]:
    """Return the entries in the ``text`` of a file written by ``as_csv``.

    ``where`` names the file in errors.  Raises ``InputError`` for other columns or invalid cells.
    """
    reader = csv.DictReader(io.StringIO(text))
    if reader.fieldnames != HEADER:
        found = "the columns are not those of identified constants"
        raise InputError(found, "write the file anew with `python -m tools.catalogue`", where)
    entries = []
    for line, row in enumerate(reader, start=2):
        try:
            entries.append(entry_of(row))
        except (TypeError, ValueError) as error:
            raise InputError(f"line {line}: {error}", "correct the row", where) from None
    return entries


def as_toml(populations: Mapping[str, Population]) -> str:
    """Return the text of a file for ``propmap.catalogue.expected.parse_populations``."""
    lines = ["# Written by `python -m tools.catalogue`; see propmap.catalogue.expected."]
    for name, one in populations.items():
        lines += ["", f"[{name}]"]
        lines += [f"{f.name} = {_listed(getattr(one, f.name))}" for f in fields(one)]
    return "\n".join(lines) + "\n"


def _listed(values: Floats) -> str:
    if values.ndim == 1:
        return "[" + ", ".join(f"{value:.8e}" for value in values) + "]"
    return "[\n" + "".join(f"  {_listed(row)},\n" for row in values) + "]"
