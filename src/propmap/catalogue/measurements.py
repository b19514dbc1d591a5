"""Measured loads that come with propmap, one TOML file each in ``measurements/``."""

from __future__ import annotations

import difflib
import functools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from propmap.errors import InputError, quoted
from propmap.io.toml import parse_toml
from propmap.loads import LOADS
from propmap.typing import Floats

SCHEMA = 1
SUFFIX = ".toml"
_FOLDER = Path(__file__).parent / "measurements"


@dataclass(frozen=True, eq=False)
class Measurement:
    """Loads of one propeller at n operating points, as published.

    Attributes
    ----------
    name, propeller : str
        Names of the measurement and of the propeller in the catalogue.
    kind : str
        "measured" points, points "digitised" from a figure, or a published "fit".
    air_density : float
        [kg/m^3].
    note, citation : str
        What was done to the figures, and whom to cite.
    omega, speed, beta : ndarray, shape (n,)
        The operating points [rad/s], [m/s], [rad].
    loads : mapping of str to ndarray, shape (n,)
        Those published, by their names in ``propmap.loads.LOADS`` [N], [N m].
    """

    name: str
    propeller: str
    kind: str
    air_density: float
    note: str
    citation: str
    omega: Floats
    speed: Floats
    beta: Floats
    loads: Mapping[str, Floats]


def measurement_names() -> list[str]:
    """The names of all measurements, in alphabetical order."""
    return sorted(file.stem for file in _FOLDER.glob(f"*{SUFFIX}"))


@functools.lru_cache(maxsize=32)
def measurement(name: str) -> Measurement:
    """The measurement called ``name``, in upper or lower case; ``InputError`` if none is."""
    key, known = name.strip().lower(), measurement_names()
    if key not in known:
        close = difflib.get_close_matches(key, known, n=3, cutoff=0.3) or known
        raise InputError(
            f"{quoted(name)} is not a measurement of the catalogue",
            f"choose one of {', '.join(close)}",
        )
    file = _FOLDER / f"{key}{SUFFIX}"
    fields = parse_toml(file.read_text(encoding="utf-8"), f"measurement {key}", SCHEMA)

    def array(column: str) -> Floats:
        values = np.array(fields[column], dtype=np.float64)
        values.flags.writeable = False
        return values

    return Measurement(
        name=key,
        propeller=fields["propeller"],
        kind=fields["kind"],
        air_density=float(fields["air_density"]),
        note=fields["note"],
        citation=fields["citation"],
        omega=array("omega_rad_s"),
        speed=array("speed_m_s"),
        beta=array("beta_rad"),
        loads={n: array(load.column) for n, load in LOADS.items() if load.column in fields},
    )
