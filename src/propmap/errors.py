"""What propmap raises when an input cannot be used, and what it warns of."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec


class InputError(ValueError):
    """An input that cannot be used, described in one printable line.

    Attributes
    ----------
    found : str
        What was found and what was expected.
    remedy : str
        What to do about it.
    where : str
        The file, line or field; put in front of the message.
    """

    def __init__(self, found: str, remedy: str = "", where: str = "") -> None:
        self.found, self.remedy, self.where = found, remedy, where
        message = f"{where}: {found}" if where else found
        # Without line breaks and control characters, which file names may contain.
        words = " ".join((f"{message}; {remedy}" if remedy else message).split())
        super().__init__("".join(c if c.isprintable() else "?" for c in words))


class MissingExtraError(InputError, ImportError):
    """An extra that is not installed, with the command that installs it."""


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
"""Packages that are imported, by the extra of ``pyproject.toml`` that brings them."""


def require(extra: str) -> None:
    """Raise ``MissingExtraError`` where a package of an ``extra`` is not installed."""
    missing = [name for name in EXTRAS[extra].split() if find_spec(name) is None]
    if missing:
        found = f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} not installed"
        raise MissingExtraError(found, f"run: pip install 'propmap[{extra}]'")


@contextmanager
def located(where: str) -> Iterator[None]:
    """Put ``where`` in front of the place that an ``InputError`` of the block names, if any."""
    try:
        yield
    except InputError as error:
        place = ": ".join(filter(None, (where, error.where)))
        raise InputError(error.found, error.remedy, place) from None


def quoted(value: object, limit: int = 40) -> str:
    """``value`` in quotes, cut to ``limit`` characters, for use in a message."""
    text = str(value)
    return repr(text if len(text) <= limit else text[: limit - 3] + "...")
