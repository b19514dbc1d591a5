"""Load tables: built and certified with the model, then queried without it.

Importing this package, loading a table and querying it need only NumPy and the core.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from propmap.table.interpolation import STATUSES as STATUSES
from propmap.table.query import Gradient as Gradient
from propmap.table.query import Inverse as Inverse
from propmap.table.query import LoadTable as LoadTable
from propmap.table.query import TableLoads as TableLoads

if TYPE_CHECKING:
    from propmap.table.build import build_table as build_table
    from propmap.table.certificate import Certificate as Certificate
    from propmap.table.jax_query import JaxTable as JaxTable
    from propmap.table.verification import certify as certify

_LAZY = {
    "Certificate": "certificate",
    "JaxTable": "jax_query",
    "build_table": "build",
    "certify": "verification",
}
__all__ = sorted(["STATUSES", "Gradient", "Inverse", "LoadTable", "TableLoads", *_LAZY])


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(importlib.import_module(f"propmap.table.{_LAZY[name]}"), name)
    raise AttributeError(f"module 'propmap.table' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_LAZY])
