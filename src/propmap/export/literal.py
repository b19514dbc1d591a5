"""Values as the Python text that makes them again, for exported modules."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np


def literal(value: Any) -> str:
    """The text of an expression that is ``value``: a dataclass, a tuple, an array, a number.

    Classes stand by their names alone; fields that are as by default are left out.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        parts = [
            f"{field.name}={literal(getattr(value, field.name))}"
            for field in dataclasses.fields(value)
            if not _by_default(field, getattr(value, field.name))
        ]
        return f"{type(value).__name__}({', '.join(parts)})"
    if isinstance(value, tuple):
        return f"({''.join(f'{literal(each)}, ' for each in value).strip()})"
    if isinstance(value, np.ndarray):
        return repr(value.tolist())
    return repr(value)


def _by_default(field: Any, value: Any) -> bool:
    if field.default_factory is not dataclasses.MISSING:
        return bool(value == field.default_factory())
    return field.default is not dataclasses.MISSING and bool(value == field.default)
