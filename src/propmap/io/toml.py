"""TOML files, converted to structs and checked by the types of the structs."""

from __future__ import annotations

import difflib
import os
import re
import tomllib
from collections.abc import Iterator
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin, get_type_hints

import msgspec

from propmap.errors import InputError, quoted, refuse_other_toml
from propmap.io.csv import read_lines

# -------------------------------------------------------------------------------------------------
# The content of a file is a struct with one field per key: type, limits, and an example for
# messages.  msgspec converts the file; this module rewrites the errors of msgspec.


class TomlTable(msgspec.Struct, forbid_unknown_fields=True):
    """A table of a TOML file; ``Annotated`` texts are examples of the values for messages."""


HUGE = 1e300
Number = Annotated[float, msgspec.Meta(ge=-HUGE, le=HUGE)]  # a finite number
Text = Annotated[str, msgspec.Meta(pattern=r"\S")]  # not empty
Vector = tuple[Number, Number, Number]

Made = TypeVar("Made", bound=msgspec.Struct)

WORDS = {
    "float": "a number",
    "int": "a whole number",
    "str": "text",
    "array": "a list",
    "object": "a table",
}


def read_toml(path: str | os.PathLike[str], kind: type[Made], schema: int, what: str) -> Made:
    """Return the file at ``path`` as a struct of type ``kind``; messages name a ``what`` file."""
    where, lines = os.fspath(path), read_lines(path, what)
    try:
        fields = tomllib.loads("\n".join(lines))
    # Besides TOMLDecodeError, a ValueError, tomllib raises a plain ValueError for numbers with
    # thousands of digits, and a RecursionError for deep nesting.
    except (ValueError, RecursionError) as error:
        remedy = "correct the syntax"
        if not any(line.lstrip().startswith("schema") for line in lines):  # another program's file
            keys = [key.name for key in msgspec.structs.fields(kind) if key.required]
            remedy = f"give a {what} file in TOML, with schema, {', '.join(keys)}"
        raise InputError(f"not TOML: {error}", remedy, where) from None
    found = fields.pop("schema", None)
    if found != schema or isinstance(found, bool):
        fault = f"schema is {quoted(found)}, expected {schema}"
        remedy = f"write schema = {schema}, or update propmap if the file is newer"
        raise InputError(fault, remedy, where)
    refuse_other_toml(fields, get_type_hints(kind), f"{what} file", where)
    return checked(fields, kind, where)


def checked(entries: dict[str, Any], kind: type[Made], where: str) -> Made:
    """Return the ``entries`` of a file or table as a struct; messages name the place ``where``."""
    try:
        return msgspec.convert(entries, kind)
    except msgspec.ValidationError as error:
        raise _in_words(error, entries, kind, where) from None


def _in_words(error: msgspec.ValidationError, value: Any, hint: Any, where: str) -> InputError:
    """Return the error with place, found and expected value, and what to write."""
    said, _, path = str(error).rpartition(" - at `$")
    said, path = (said, path) if said else (path, "")
    table, key, names, item = "", "", "", False
    for name, number in re.findall(r"\.([^.\[`]+)|\[(\d+)\]", path):
        if name:
            hint, value = get_type_hints(_struct(hint), include_extras=True)[name], value[name]
            key, names, item = name, f"{names}.{name}".lstrip("."), False
        else:
            value, item = value[int(number)], True
        if isinstance(value, dict):
            table = f": [[{names}]] {int(number) + 1}" if number else f": [{names}]"
            key = ""
    where += table
    if isinstance(error.__cause__, InputError):
        return InputError(error.__cause__.found, error.__cause__.remedy, where)
    if field := re.search("field `(.*)`", said):
        key, known = field[1], get_type_hints(_struct(hint), include_extras=True)
        if "missing" in said:
            shown = example(known[key])
            remedy = f"add {key} = {shown}" if shown else f"add [{key}]"
            return InputError(f"no {key}", remedy, where)
        close = difflib.get_close_matches(key, known, n=1)
        remedy = (f"did you mean {close[0]}? " if close else "") + f"known keys: {', '.join(known)}"
        return InputError(f"unknown key {quoted(key)}", remedy, where)
    wanted = re.sub(
        "`(.*?)`", lambda m: " or ".join(WORDS[w] for w in m[1].split(" | ") if w != "null"), said
    )
    wanted = re.split(", got| matching", wanted)[0].removeprefix("Expected ")
    if "e+300" in said or "out of range" in said or value != value:
        wanted = "a finite number"
    shown = example(hint)
    if said.startswith("Invalid enum"):
        wanted = shown
    found = f"{key} {'has' if item else 'is'} {quoted(value)}, expected {wanted}"
    table = f"[[{key}]]" if wanted == "a list" else f"[{key}]"
    return InputError(found, f"write {key} = {shown}" if shown else f"write {table}", where)


def _parts(hint: Any) -> Iterator[Any]:
    """Yield a type and the types that it contains, outermost first."""
    yield hint
    if get_origin(hint) is not Literal:
        for part in get_args(hint):
            yield from _parts(part)


def _struct(hint: Any) -> type[msgspec.Struct]:
    return next(p for p in _parts(hint) if isinstance(p, type) and issubclass(p, msgspec.Struct))


def example(hint: Any) -> str:
    """Return an example of the value for a key of this type; empty without any."""
    for part in _parts(hint):
        if isinstance(part, str):
            return part
        if get_origin(part) is Literal:
            return " or ".join(f'"{choice}"' for choice in get_args(part))
    return ""


Place = Annotated[list[float], "[...], write a number for each station"]


class PropellerFile(TomlTable):
    """The content of a propeller file in the format of the catalogue."""

    name: Annotated[Text, '"..."']
    radius_m: Annotated[Number, "the tip radius in m"]
    station_m: Place
    chord_m: Place
    twist_rad: Place
    blades: Any = None  # checked by the reader, because an option may replace it
    root_cutout_m: Annotated[Number, "a length in m"] | None = None
    title: str = ""
    family: str = ""
    source: str = ""
    citation: str = ""
