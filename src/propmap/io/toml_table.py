"""A table of a TOML file whose entries are checked as they are taken."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from typing import Any

from propmap.errors import InputError, quoted


class TomlTable:
    """Entries by name; whatever is wrong with one raises ``InputError`` that names it.

    Parameters
    ----------
    entries : mapping
        As ``tomllib`` gives them.
    where : str
        File and table, for the messages.
    known : sequence of str
        The keys that may occur; any other is refused, with a close one proposed.
    """

    def __init__(self, entries: Mapping[str, Any], where: str, known: Sequence[str]) -> None:
        self.entries, self.where = entries, where
        for key in entries:
            if key not in known:
                close = difflib.get_close_matches(key, known, n=1)
                hint = f"did you mean {close[0]}? " if close else ""
                raise InputError(
                    f"unknown key {quoted(key)}",
                    f"{hint}known are {', '.join(known)}",
                    where,
                )

    def __contains__(self, key: str) -> bool:
        return key in self.entries

    def need(self, key: str, example: str) -> Any:
        """The entry as it stands; ``example`` is what to write where there is none."""
        if key not in self.entries:
            raise InputError(f"no {key}", f"add {key} = {example}", self.where)
        return self.entries[key]

    def text(self, key: str, example: str) -> str:
        """A text that is not empty."""
        value = self.need(key, example)
        if not isinstance(value, str) or not value.strip():
            raise InputError(
                f"{key} is {quoted(value)}, expected text", f"write {key} = {example}", self.where
            )
        return value

    def choice(self, key: str, choices: Sequence[str]) -> str:
        """One of the ``choices``."""
        listed = " or ".join(f'"{choice}"' for choice in choices)
        value = self.need(key, listed)
        if value not in choices:
            raise InputError(
                f"{key} is {quoted(value)}, expected {listed}",
                f"write {key} = {listed}",
                self.where,
            )
        return str(value)

    def number(self, key: str, example: str, default: float | None = None) -> float:
        """A finite number."""
        if key not in self.entries and default is not None:
            return default
        return self._number(self.need(key, example), key, f"write {key} = {example}")

    def vector(self, key: str, example: str) -> tuple[float, float, float]:
        """Three finite numbers."""
        values = self.need(key, example)
        remedy = f"write {key} = {example}"
        if not isinstance(values, list) or len(values) != 3:
            raise InputError(f"{key} is {quoted(values)}, expected 3 numbers", remedy, self.where)
        x, y, z = (self._number(value, key, remedy) for value in values)
        return x, y, z

    def texts(self, key: str, count: int | None, example: str) -> tuple[str, ...]:
        """``count`` texts, or one or more where it is None."""
        values = self.need(key, example)
        good = isinstance(values, list) and all(isinstance(v, str) and v for v in values)
        if not good or len(values) != (count or max(len(values), 1)):
            expected = f"{count} names" if count else "a list of names"
            raise InputError(
                f"{key} is {quoted(values)}, expected {expected}",
                f"write {key} = {example}",
                self.where,
            )
        return tuple(values)

    def table(self, key: str, known: Sequence[str]) -> TomlTable:
        """The table ``[key]`` inside this one; empty where there is none.

        A key with a dot, such as "log.columns", names the table in full; the part after the
        last dot is looked up.
        """
        value = self.entries.get(key.rpartition(".")[2], {})
        if not isinstance(value, dict):
            raise InputError(
                f"{key} is {quoted(value)}, expected a table", f"write [{key}]", self.where
            )
        file = self.where.partition(": [")[0]
        return TomlTable(value, f"{file}: [{key}]", known)

    def tables(self, key: str, known: Sequence[str]) -> list[TomlTable]:
        """The tables ``[[key]]`` inside this one, in their order."""
        values = self.entries.get(key, [])
        if not isinstance(values, list) or not all(isinstance(value, dict) for value in values):
            raise InputError(
                f"{key} is {quoted(values)}, expected tables", f"write [[{key}]]", self.where
            )
        return [
            TomlTable(value, f"{self.where}: [[{key}]] {k}", known)
            for k, value in enumerate(values, start=1)
        ]

    def _number(self, value: Any, key: str, remedy: str) -> float:
        try:
            number = math.nan if isinstance(value, bool | str) else float(value)
        except (TypeError, OverflowError):
            number = math.nan
        if not math.isfinite(number):
            raise InputError(
                f"{key} has {quoted(value)}, expected a finite number", remedy, self.where
            )
        return number
