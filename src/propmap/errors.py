"""Exceptions for unusable inputs and missing extras, and helpers for their messages."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from importlib.util import find_spec


class InputError(ValueError):
    """Error for an input that cannot be used, with a message of one printable line.

    Attributes
    ----------
    found : str
        The wrong value and the expected value.
    remedy : str
        The action that corrects the input.
    where : str
        The file, line or field; the message begins with it.
    """

    def __init__(self, found: str, remedy: str = "", where: str = "") -> None:
        self.found, self.remedy, self.where = found, remedy, where
        message = f"{where}: {found}" if where else found
        # File names may contain line breaks and control characters, which are removed.
        words = " ".join((f"{message}; {remedy}" if remedy else message).split())
        super().__init__("".join(c if c.isprintable() else "?" for c in words))


class MissingExtraError(InputError, ImportError):
    """Error for an extra that is not installed, with the command that installs it."""


EXTRAS = {
    "cluster": "distributed xarray zarr",
    "explore": "dash plotly",
    "figures": "matplotlib",
    "jax": "jax",
    "logs": "pandas pymavlink pyulog rosbags",
    "mujoco": "mujoco",
    "netcdf": "h5netcdf xarray",
    "parquet": "pandas pyarrow",
}
"""Imported packages, by the extra of ``pyproject.toml`` that installs them."""


def require(extra: str) -> None:
    """Raise ``MissingExtraError`` if a package of an ``extra`` is not installed."""
    missing = [name for name in EXTRAS[extra].split() if find_spec(name) is None]
    if missing:
        found = f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} not installed"
        raise MissingExtraError(found, f"run: pip install 'propmap[{extra}]'")


TOML_FILES = {  # kinds of TOML files and their use, by a key that only this kind contains
    "rotors": ("a vehicle file", "use it with --vehicle, or as the argument of propmap trim"),
    "station_m": ("a geometry file", "use it as the argument PROP of a command"),
    "fit": ("a fit", "use it with --airfoil, or as the argument of propmap check"),
    "c_l1": ("a parameter set", "use it with --airfoil"),
}


def refuse_other_toml(keys: Collection[str], own: Collection[str], what: str, where: str) -> None:
    """Raise ``InputError`` if ``keys`` are from a file other than a ``what``, with ``own`` keys."""
    for key, (kind, use) in TOML_FILES.items():
        if key in keys and key not in own:
            raise InputError(f"this is {kind}, not a {what}", use, where)


@contextmanager
def located(where: str) -> Iterator[None]:
    """Put ``where`` in front of the place of an ``InputError`` that the block raises."""
    try:
        yield
    except InputError as error:
        place = ": ".join(filter(None, (where, error.where.removeprefix(": "))))
        raise InputError(error.found, error.remedy, place) from None


def quoted(value: object, limit: int = 40) -> str:
    """Return ``value`` in quotes, cut to ``limit`` characters, for a message."""
    text = str(value)
    return repr(text if len(text) <= limit else text[: limit - 3] + "...")
