"""TOML files whose entries are checked as they are taken."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from propmap.errors import InputError, quoted
from propmap.typing import Floats


def parse_toml(text: str, where: str, schema: int) -> dict[str, Any]:
    """The fields of a TOML ``text``, from ``where``, if its ``schema`` is as expected."""
    try:
        fields = tomllib.loads(text)
    # A number of thousands of digits is a plain ValueError, deep nesting a RecursionError.
    except (ValueError, RecursionError) as error:
        raise InputError(f"not TOML: {error}", "correct the syntax", where) from None
    if fields.get("schema") != schema or isinstance(fields.get("schema"), bool):
        raise InputError(
            f"schema is {quoted(fields.get('schema'))}, expected {schema}",
            f"write schema = {schema}, or update propmap if the file is newer",
            where,
        )
    return fields


class TomlTable:
    """Entries by name; whatever is wrong with one raises ``InputError`` that names it.

    In all methods ``example`` is what to write instead of a bad entry, or where there is none.

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
                import difflib

                close = difflib.get_close_matches(key, known, n=1)
                hint = f"did you mean {close[0]}? " if close else ""
                raise InputError(
                    f"unknown key {quoted(key)}", f"{hint}known are {', '.join(known)}", where
                )

    def __contains__(self, key: str) -> bool:
        return key in self.entries

    def need(self, key: str, example: str) -> Any:
        """The entry as it stands."""
        if key not in self.entries:
            raise InputError(f"no {key}", f"add {key} = {example}", self.where)
        return self.entries[key]

    def text(self, key: str, example: str, default: str | None = None) -> str:
        """A text; where there is no ``default``, not an empty one."""
        value = self.need(key, example) if default is None else self.entries.get(key, default)
        if not isinstance(value, str) or not (value.strip() or default is not None):
            raise self._wrong(key, "text", example)
        return value

    def choice(self, key: str, choices: Sequence[str]) -> str:
        """One of the ``choices``."""
        listed = " or ".join(f'"{choice}"' for choice in choices)
        value = self.need(key, listed)
        if value not in choices:
            raise self._wrong(key, listed, listed)
        return str(value)

    def number(self, key: str, example: str, default: float | None = None) -> float:
        """A finite number."""
        value = self.need(key, example) if default is None else self.entries.get(key, default)
        return self._number(key, value, f"write {key} = {example}")

    def numbers(self, key: str) -> Floats:
        """A list of numbers as float64."""
        values = self.need(key, "...")
        if not isinstance(values, list):
            raise self._wrong(key, "a list of numbers", "[...]")
        return np.array([self._number(key, v, "write a number", finite=False) for v in values])

    def vector(self, key: str, example: str) -> tuple[float, float, float]:
        """Three finite numbers."""
        values = self.need(key, example)
        if not isinstance(values, list) or len(values) != 3:
            raise self._wrong(key, "3 numbers", example)
        x, y, z = (self._number(key, value, f"write {key} = {example}") for value in values)
        return x, y, z

    def texts(self, key: str, count: int | None, example: str) -> tuple[str, ...]:
        """``count`` texts, or one or more where it is None."""
        values = self.need(key, example)
        good = isinstance(values, list) and all(isinstance(v, str) and v for v in values)
        if not good or len(values) != (count or max(len(values), 1)):
            raise self._wrong(key, f"{count} names" if count else "a list of names", example)
        return tuple(values)

    def optional(
        self, key: str, good: Callable[[Any], bool], expected: str, remedy: str
    ) -> Any | None:
        """The entry if it is ``good``, or None where there is none."""
        value = self.entries.get(key)
        if value is not None and not good(value):
            raise InputError(f"{key} is {quoted(value)}, expected {expected}", remedy, self.where)
        return value

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

    def _wrong(self, key: str, expected: str, example: str) -> InputError:
        found = f"{key} is {quoted(self.entries[key])}, expected {expected}"
        return InputError(found, f"write {key} = {example}", self.where)

    def _number(self, key: str, value: Any, remedy: str, *, finite: bool = True) -> float:
        # A TOML integer may be too long for a float.
        try:
            if isinstance(value, int | float) and not isinstance(value, bool):
                number = float(value)
                if math.isfinite(number) or not finite:
                    return number
        except OverflowError:
            pass
        wanted = "a finite number" if finite else "a number"
        raise InputError(f"{key} has {quoted(value)}, expected {wanted}", remedy, self.where)
