"""Operating points as options of the command line."""

from __future__ import annotations

import itertools

import numpy as np

from propmap.errors import InputError
from propmap.io.csv import OperatingPoints, check_value
from propmap.typing import Floats


def single_point(rpm: float, speed: float, beta: float, **further: float | None) -> OperatingPoints:
    """One checked operating point, with what of ``further`` variables is not None."""
    values = {"rpm": rpm, "speed": speed, "beta": beta}
    more = {name: value for name, value in further.items() if value is not None}
    checked = {k: np.array([check_value(k, v)]) for k, v in (values | more).items()}
    rpm_, speed_, beta_ = (checked.pop(name) for name in values)
    return OperatingPoints(rpm_, speed_, beta_, checked)


def parse_axis(option: str, quantity: str, text: str, count: int | None = None) -> Floats:
    """Rising values (n,) from "6000", "10,20" or "A:B:N", N values from A to B.

    ``option`` is its name in messages, ``count`` N where "A:B" is written, None to ask for it.
    """
    parts = text.split(":")
    form = "A:B:N" if count is None else "A:B or A:B:N"
    remedy = f"write a number, a list such as 10,20, or {form} (N values from A to B)"
    try:
        if len(parts) == 1:
            values = np.array([float(part) for part in text.split(",")])
        elif len(parts) == 3 or (len(parts) == 2 and count is not None):
            number = int(parts[2]) if len(parts) == 3 else int(count or 0)
            if not 2 <= number <= 1_000_000:
                raise InputError(f"{option} {text}: N is {number}", "use 2 to 1000000 values")
            values = np.linspace(float(parts[0]), float(parts[1]), number)
        else:
            raise ValueError
    except InputError:
        raise
    except (ValueError, OverflowError):
        raise InputError(f"{option} {text!r} cannot be read", remedy) from None
    for value in values.tolist():
        check_value(quantity, value)
    if any(b <= a for a, b in itertools.pairwise(values.tolist())):
        raise InputError(f"{option} {text}: the values do not rise", "write each once, rising")
    return values
