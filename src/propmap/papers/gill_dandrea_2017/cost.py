"""What a map call and an identification cost on this machine."""

from __future__ import annotations

import os
import platform
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from propmap.fit.fit import Fitted, fit
from propmap.model.airfoil import parameter_set
from propmap.model.model import Model
from propmap.papers.gill_dandrea_2017.blades import TUNNEL_PROPELLER, blade
from propmap.rotor import Rotor
from propmap.units import RPM

POINT = (6000.0 * RPM, 10.0, np.radians(60.0))
"""[rad/s], [m/s], [rad] of the call that is timed."""

REPEATS = 21
BATCH = 256


@dataclass(frozen=True)
class Times:
    """Times [s]; they differ from run to run and from machine to machine.

    Attributes
    ----------
    one_point, per_point : float
        Medians: a call for one operating point, and the share of one in a batch.
    level, tunnel : float
        Identifications from 20 level flights and from the tunnel rows.
    machine, cores : str, int
        Where.
    """

    one_point: float
    per_point: float
    level: float
    tunnel: float
    machine: str
    cores: int


def measured_times(level: Fitted, tunnel: Fitted) -> Times:
    """Time map calls, and these identifications again, with nothing beside them."""
    rotor = Rotor(Model(blade(TUNNEL_PROPELLER), parameter_set("paper-apc")))
    batch = [np.full(BATCH, value) for value in POINT]
    again = [fit(one.rows, one.choice, one.settings).seconds for one in (level, tunnel)]
    return Times(
        one_point=_median(lambda: rotor.loads(*POINT)),
        per_point=_median(lambda: rotor.loads(*batch)) / BATCH,
        level=again[0],
        tunnel=again[1],
        machine=f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
        cores=os.cpu_count() or 1,
    )


def _median(call: Callable[[], object]) -> float:
    call()
    seconds = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - begin)
    return statistics.median(seconds)
