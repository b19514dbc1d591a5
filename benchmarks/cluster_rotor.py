"""The rotor and the grid that cluster benchmarks sweep, and what a process has used."""

from __future__ import annotations

import resource

import numpy as np

import propmap
from propmap.rotor import Rotor
from propmap.sweep.points import Grid

SMALL, LARGE = (20, 50, 100), (100, 200, 100)
"""Rotational speeds, flight speeds and angles: 1e5 and 2e6 points."""


def model(physics: str = "paper") -> propmap.Model:
    """An APC 8x6E by the paper's model, or by the recommended one."""
    return propmap.Model(
        propmap.propeller("apc-8x6e"),
        propmap.airfoil("paper-apc"),
        corrections=propmap.model_corrections(physics),
    )


def rotor() -> Rotor:
    """The rotor of the sweeps, by the paper's model: its tasks are short, and overheads show."""
    return Rotor(model())


def grid(shape: tuple[int, int, int]) -> Grid:
    """3000 to 8000 rpm, 0 to 20 m/s, climb to descent."""
    ends = (3000.0, 8000.0), (0.0, 20.0), (0.0, 180.0)
    return Grid(*(np.linspace(*pair, n) for pair, n in zip(ends, shape, strict=True)))


def usage() -> dict[str, float]:
    """Peak of memory [MB] and processor time [s] of this process."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return {"peak_MB": used.ru_maxrss / 1024.0, "processor_s": used.ru_utime + used.ru_stime}
