"""What a log holds, each signal on its own clock, and the samples that cannot be used."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.typing import Floats

FEWEST_SAMPLES = 10
MOST_DROPPED = 0.05
"""Share of a signal's samples that may be unusable before the log is refused."""


@dataclass(frozen=True, eq=False)
class Signal:
    """Samples (n, k) of k numbers at n times [s], and a name for messages."""

    name: str
    time: Floats
    values: Floats


@dataclass(frozen=True, eq=False)
class Recording:
    """The signals of a log in the frames that the log has: "flu" or "frd", "enu" or "ned".

    ``velocity_in`` is "body" or "world".  The attitude (n, 4) is the unit quaternion w, x, y, z
    that turns body to world axes; the velocity (n, 3) [m/s] is over the ground; rates (n, 3)
    [rad/s] and specific force (n, 3) [m/s^2], if any, are along body axes; rotor speeds
    (n, rotors) [rad/s] are in the order of the log.
    """

    source: str
    body_frame: str
    world_frame: str
    velocity_in: str
    attitude: Signal
    velocity: Signal
    rates: Signal
    rotor_speed: Signal
    specific_force: Signal | None

    def signals(self) -> dict[str, Signal]:
        """By name of the field, those that there are."""
        return {name: value for name, value in vars(self).items() if isinstance(value, Signal)}


def cleaned(recording: Recording) -> Recording:
    """Without the samples that cannot be used; ``source`` then says how many these were.

    Dropped are samples that are not finite, whose quaternion has not length 1, or whose time
    does not rise above that of all before them.  Raises ``InputError`` where that is more than
    5 % of a signal, or where fewer than 10 samples are left.
    """
    dropped: dict[str, int] = {}
    parts: dict[str, Any] = {}
    for name, signal in recording.signals().items():
        _check_count(signal, signal.time.size, recording.source)
        finite = np.isfinite(signal.time) & np.all(np.isfinite(signal.values), axis=1)
        reasons = [("not finite", "export the log again or remove the column", finite)]
        if name == "attitude":
            with np.errstate(over="ignore"):
                length = np.linalg.norm(np.nan_to_num(signal.values, nan=1.0), axis=1)
            unit = np.abs(length - 1.0) < 0.05
            remedy = "check which of its columns or fields are qw, qx, qy, qz"
            reasons.append(("no unit quaternion", remedy, unit | ~finite))
        usable = np.all([good for _, _, good in reasons], axis=0)
        rising = ~usable
        rising[usable] = _rising(signal.time[usable])
        reasons.append(("with a time that does not rise", "sort by time or cut the log", rising))
        for reason, remedy, good in reasons:
            lost = int(np.sum(~good))
            if lost > MOST_DROPPED * good.size:
                raise InputError(
                    f"{lost} of {good.size} samples of {signal.name} are {reason}",
                    remedy,
                    recording.source,
                )
            if lost:
                # Columns of one table lose the same rows: these are not counted twice.
                dropped[reason] = max(dropped.get(reason, 0), lost)
        good = usable & rising
        _check_count(signal, int(good.sum()), recording.source)
        parts[name] = Signal(signal.name, signal.time[good], signal.values[good])
    remark = ", ".join(f"{count} samples {reason}" for reason, count in dropped.items())
    source = f"{recording.source} (dropped: {remark})" if remark else recording.source
    return replace(recording, source=source, **parts)


def _rising(time: Floats) -> NDArray[np.bool_]:
    """Which times are above all that come before them."""
    before = np.concatenate([[-np.inf], np.maximum.accumulate(time)[:-1]])
    return np.asarray(time > before)


def _check_count(signal: Signal, count: int, source: str) -> None:
    if count < FEWEST_SAMPLES:
        raise InputError(
            f"{signal.name} has {count} samples, expected at least {FEWEST_SAMPLES}",
            "give a log with some seconds of flight",
            source,
        )
