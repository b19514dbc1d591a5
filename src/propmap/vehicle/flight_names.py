"""Short names of flights, from those of their files."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import PurePath

TIME_OF_DAY = 6
"""Digits at the end of a stamp such as 20210218171908."""


def flight_names(sources: Sequence[str]) -> tuple[str, ...]:
    """As much of the ends of the files' names as tells them apart; numbers where nothing does.

    Parameters
    ----------
    sources : sequence of str
        Paths of the logs.
    """
    parts = [_words(PurePath(source).stem) for source in sources]
    for count in range(1, max(map(len, parts), default=1) + 1):
        names = tuple("-".join(words[-count:]) for words in parts)
        if len(set(names)) == len(names):
            return names
    return tuple(str(k + 1) for k in range(len(parts)))


def _words(stem: str) -> list[str]:
    words = re.findall(r"[^\W_]+", stem) or ["flight"]
    stamp = re.fullmatch(rf"\d{{8}}(\d{{{TIME_OF_DAY}}})", words[-1])
    return [*words[:-1], words[-1][:8], stamp[1]] if stamp else words
