"""What a user can set on a view, and how it stands in the address."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from urllib.parse import parse_qsl

from propmap.errors import InputError, quoted

Values = dict[str, Any]
"""What is set, by the names of the controls."""

LONGEST = 400
"""Characters of a text that is set."""


@dataclass(frozen=True)
class Slider:
    """A number within limits.

    Attributes
    ----------
    name, label, unit : str
        In the address, and on the page.
    low, high, step : float
        Limits and the width of a step.
    default : float
        Where it stands at first.
    marked : tuple of 2 float, or None
        A range to be marked, such as an interval of confidence.
    group : str
        Under which it is shown; "" for none.
    """

    name: str
    label: str
    unit: str
    low: float
    high: float
    step: float
    default: float
    marked: tuple[float, float] | None = None
    group: str = ""

    def read(self, given: Any) -> float:
        """The number that is given, brought within the limits; ``InputError`` for none."""
        try:
            value = float(given)
        except (TypeError, ValueError):
            raise InputError(
                f"{self.label} is {quoted(given)}", f"give a number [{self.unit or '-'}]"
            ) from None
        if not math.isfinite(value):
            raise InputError(f"{self.label} is {value}", "give a finite number")
        return min(max(value, self.low), self.high)


@dataclass(frozen=True)
class Text:
    """A line of text, such as a list of angles."""

    name: str
    label: str
    default: str
    group: str = ""

    def read(self, given: Any) -> str:
        """The text that is given; ``InputError`` for what is none or too long."""
        if not isinstance(given, str) or len(given) > LONGEST or not given.isprintable():
            raise InputError(f"{self.label} is {quoted(given)}", f"give up to {LONGEST} characters")
        return given.strip()


@dataclass(frozen=True)
class Choice:
    """One of several ``options``, (value, label) each."""

    name: str
    label: str
    options: tuple[tuple[str, str], ...]
    default: str
    group: str = ""

    def read(self, given: Any) -> str:
        """The option that is given; ``InputError`` for another one."""
        known = [value for value, _ in self.options]
        if given not in known:
            raise InputError(
                f"{self.label} is {quoted(given)}", f"choose one of {', '.join(known)}"
            )
        return str(given)


@dataclass(frozen=True)
class Several:
    """Any of several ``options``, (value, label) each."""

    name: str
    label: str
    options: tuple[tuple[str, str], ...]
    default: tuple[str, ...]
    group: str = ""

    def read(self, given: Any) -> list[str]:
        """The options that are given, in their order; ``InputError`` for another one."""
        if isinstance(given, str):
            given = [part for part in given.split(",") if part]
        known = [value for value, _ in self.options]
        if not isinstance(given, list) or any(one not in known for one in given):
            raise InputError(f"{self.label} is {quoted(given)}", f"choose from {', '.join(known)}")
        return [one for one in known if one in given]


Control = Slider | Text | Choice | Several


def default_of(control: Control) -> Any:
    """What it is set to at first."""
    return list(control.default) if isinstance(control, Several) else control.default


def values_of(controls: Sequence[Control], given: Mapping[str, Any]) -> tuple[Values, list[str]]:
    """What is set, and a line for each control that was given something it cannot be.

    Parameters
    ----------
    controls : sequence of Control
        Of a view.
    given : mapping of str
        By their names; what is missing is at its default.
    """
    values, remarks = {}, []
    for control in controls:
        values[control.name] = default_of(control)
        if given.get(control.name) is None:
            continue
        try:
            values[control.name] = control.read(given[control.name])
        except InputError as error:
            remarks.append(str(error))
    return values, remarks


def of_query(search: str | None) -> dict[str, str]:
    """The parameters of an address by name, of ``?a=1&b=2``."""
    return dict(parse_qsl((search or "").lstrip("?"), keep_blank_values=True, max_num_fields=100))
