"""What propmap raises when an input cannot be used, and what it warns of."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


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
