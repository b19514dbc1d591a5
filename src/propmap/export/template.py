"""Text from the templates in ``templates/``: sources, notes, and the comments in them."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from propmap.export.provenance import identifier, provenance
from propmap.loads import LOADS
from propmap.table.query import LoadTable


def rendered(template: str, table: LoadTable, **values: Any) -> str:
    """Text of a template; ``values`` that are functions serve as filters.

    Every template knows the table, the registry's ``loads``, the name ``p`` of the propeller and
    that name in capitals, ``P``, and the ``lines`` of the provenance.
    """
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"),
        variable_start_string="@",
        variable_end_string="@",
        line_statement_prefix="%%",
        undefined=StrictUndefined,
        keep_trailing_newline=True,
    )
    filters: dict[str, Callable[..., str]] = {
        "c_comment": c_comment,
        "hash_comment": hash_comment,
        "xml_comment": xml_comment,
    }
    environment.filters |= filters | {k: v for k, v in values.items() if callable(v)}
    name = identifier(table)
    common = {"table": table, "loads": LOADS, "p": name, "P": name.upper()}
    found = environment.get_template(f"{template}.j2")
    return found.render(**common, lines=provenance(table), **values)


def c_comment(lines: Sequence[str]) -> str:
    """Lines for the inside of a C comment."""
    return "\n".join(f" * {line.replace('*/', '* /')}".rstrip() for line in lines)


def xml_comment(lines: Sequence[str]) -> str:
    """Lines as an XML comment, inside which two hyphens must not occur."""
    text = "\n".join(f"  {line}" for line in lines)
    return f"<!--\n{re.sub('-(?=-)', '- ', text)}\n-->"


def hash_comment(lines: Sequence[str]) -> str:
    """Lines as a Python comment."""
    return "\n".join(f"# {line}".rstrip() for line in lines)
