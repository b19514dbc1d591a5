"""The note that goes with an export: what the target can represent, and at what cost."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import Any

from propmap.export.provenance import provenance
from propmap.export.samples import SIMPLE, Errors
from propmap.export.template import rendered
from propmap.loads import LOADS
from propmap.table.query import LoadTable

SHARES = ", ".join(load.share for load in LOADS.values())


def note(table: LoadTable, target: str, found: Sequence[Errors] = (), **values: Any) -> str:
    """The text of a note.

    Parameters
    ----------
    table : LoadTable
        The map.
    target : str
        Names the template, ``README-<target>.txt.j2``.
    found : sequence of Errors
        What the target's model costs; none where nothing is simplified.
    **values
        For the template.
    """
    text = rendered(f"README-{target}.txt", table, simple=SIMPLE, **values)
    parts = [f"propmap export: {target}", *map(_fill, text.strip().split("\n\n"))]
    if found:
        parts.append(_fill(f"Error against the map, at the same omega: {SHARES}."))
        parts += [error_table(errors) for errors in found]
    else:
        parts.append("Nothing is simplified: the errors are those of the map.")
    parts.append("\n".join(provenance(table)))
    return "\n\n".join(parts) + "\n"


def error_table(errors: Errors) -> str:
    """Lines of plain text, a row per load."""
    rows = [f"over {errors.where} ({errors.points} points)"]
    rows.append(f"  {'':12s}{'rms':>10s}{'worst':>10s}")
    for name, rms, worst in zip(LOADS, errors.rms.tolist(), errors.worst.tolist(), strict=True):
        rows.append(f"  {name:12s}{rms:>10.2%}{worst:>10.2%}")
    return "\n".join(rows)


def _fill(paragraph: str) -> str:
    return textwrap.fill(paragraph, 88, break_on_hyphens=False, break_long_words=False)
