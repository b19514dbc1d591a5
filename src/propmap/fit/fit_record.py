"""The table ``[fit]`` of a fit file: one description for writing and for reading."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from propmap.errors import InputError
from propmap.fit.coverage import Coverage
from propmap.fit.residuals import Errors, FlightErrors
from propmap.fit.search import End
from propmap.model.air import Air
from propmap.model.propeller import Propeller
from propmap.typing import Floats

BY_NAME = ("parameters", "residuals")
"""In the file these are tables by name, in a record lists whose entries hold their name."""


class FreeParameter(msgspec.Struct, frozen=True, omit_defaults=True):
    """One fitted parameter, in ``unit``.

    Attributes
    ----------
    low, high, bootstrap_low, bootstrap_high : float
        Ends of its 95 % intervals; None where there was no bootstrap.
    verdict, identified : str, bool
        Whether the data determine it.
    start, lower, upper : float
        Where the first search began, and the bounds.
    prior : tuple of 2 float, or None
        Mean and standard deviation.
    """

    name: str
    value: float
    unit: str
    low: float = msgspec.field(name="low_95")
    high: float = msgspec.field(name="high_95")
    verdict: str
    identified: bool
    start: float
    lower: float
    upper: float
    prior: tuple[float, float] | None = None
    bootstrap_low: float | None = msgspec.field(name="bootstrap_low_95", default=None)
    bootstrap_high: float | None = msgspec.field(name="bootstrap_high_95", default=None)


class FittedLoad(Errors, frozen=True):
    """Errors of one load, in ``unit``: over all rows, on rows left out, by speed and by flight."""

    name: str
    unit: str
    cross_validated: float = msgspec.field(name="cross_validated_rms")
    by_speed: dict[str, Errors]
    by_flight: dict[str, FlightErrors] = msgspec.field(default_factory=dict)

    @property
    def measured_rms(self) -> float:
        """Root mean square of what was measured."""
        return self.rms / self.relative_rms if self.relative_rms > 0.0 else np.nan


class Source(msgspec.Struct, frozen=True, omit_defaults=True):
    """Where data are from: a file with its SHA-256, or a name of the catalogue."""

    file: str = ""
    sha256: str = ""
    catalogue: str = ""

    @classmethod
    def of(cls, item: Path | str) -> Source:
        """A file's path, or a name of the catalogue."""
        if isinstance(item, Path):
            return cls(item.name, hashlib.sha256(item.read_bytes()).hexdigest())
        return cls(catalogue=item)

    @property
    def name(self) -> str:
        """As it is shown."""
        return self.file or f"{self.catalogue} of the catalogue"


class FittedPropeller(msgspec.Struct, frozen=True):
    """The propeller of a fit; lengths [m] and angles [rad] as in ``Propeller``."""

    name: str
    blades: int
    root: float
    station_m: Floats
    chord_m: Floats
    twist_rad: Floats

    @classmethod
    def of(cls, blade: Propeller) -> FittedPropeller:
        """The part of a propeller that its loads depend on."""
        shape = (blade.station, blade.chord, blade.twist)
        return cls(blade.name, blade.blades, blade.root, *shape)

    def propeller(self) -> Propeller:
        """The propeller; raises ``InputError`` where there can be no such blade."""
        shape = (self.station_m, self.chord_m, self.twist_rad)
        return Propeller(self.name, self.blades, *shape, self.root)


class FitRecord(msgspec.Struct, frozen=True):
    """What a fit file tells of its fit of P free parameters.

    Attributes
    ----------
    kind, version : str
        "tunnel", "level flight" or "flight"; propmap's version.
    rows, unsolved : int
        Numbers that were fitted, and for how many of them the model had no solution.
    fixed, body, wing : dict of str to float
        Parameters that the user held; all of the body's, with the sensor's and the wakes' if any,
        and of the wing's.
    covariance, correlation : ndarray, shape (P, P)
        A variance is infinite where the data say nothing.
    singular_values : ndarray, shape (P,)
        Of the sensitivities, relative to the largest.
    starts : list of End
        Where the searches ended, best first.
    discrepancy : dict of str to float
        Errors that the fit left, as standard deviations of C_T and C_P [-], by the names of
        ``model.uncertainty.DISCREPANCIES``; empty where an earlier version wrote the file.
    """

    kind: str
    version: str = msgspec.field(name="propmap")
    remarks: list[str]
    free: list[str]
    rows: int
    unsolved: int = msgspec.field(name="unsolved_rows")
    seconds: float
    settings: dict[str, Any]
    fixed: dict[str, float]
    air: Air
    propeller: FittedPropeller
    data: list[Source]
    covered: Coverage
    parameters: list[FreeParameter]
    body: dict[str, float]
    wing: dict[str, float]
    covariance: Floats
    correlation: Floats
    singular_values: Floats
    loads: list[FittedLoad] = msgspec.field(name="residuals")
    starts: list[End]
    discrepancy: dict[str, float] = msgspec.field(default_factory=dict)

    def __post_init__(self) -> None:
        count = len(self.parameters)
        if [p.name for p in self.parameters] != self.free:
            raise ValueError("parameters are not those that are free")
        square = {self.covariance.shape, self.correlation.shape} == {(count, count)}
        if not square or self.singular_values.shape != (count,):
            raise ValueError(f"the matrices are not of {count} parameters")
        if not (self.loads and self.starts):
            raise ValueError("residuals or starts are empty")

    @property
    def minima(self) -> int:
        """How many different minima the starts ended in."""
        return max(end.minimum for end in self.starts)

    def table(self) -> dict[str, Any]:
        """Plain data for a TOML file."""
        told: dict[str, Any] = msgspec.to_builtins(self, enc_hook=_plain)
        for key in BY_NAME:
            told[key] = {entry.pop("name"): entry for entry in told[key]}
        return told


def read_record(table: Any) -> FitRecord:
    """The record of the table ``[fit]`` as TOML gives it.

    Raises
    ------
    InputError
        Naming the entry where one is missing or is of another kind.
    """
    known = table
    if isinstance(table, Mapping):
        known = {**table, **{key: _listed(table[key]) for key in BY_NAME if key in table}}
    try:
        return msgspec.convert(known, FitRecord, dec_hook=_array)
    except msgspec.ValidationError as error:
        fault, _, path = str(error).replace("`", "").partition(" - at $.")
        for key in BY_NAME:
            if found := re.match(rf"{key}\[(\d+)\]", path):
                path = f"{key}.{list(table[key])[int(found[1])]}{path[found.end() :]}"
        place = f"at {path}: " if path else ""
        raise InputError(f"{place}{fault}", "write it again with propmap fit") from None


def _listed(tables: Any) -> Any:
    """Tables by name as a list of tables with a name; anything else as it is."""
    if not isinstance(tables, Mapping):
        return tables
    return [{"name": k, **t} if isinstance(t, Mapping) else t for k, t in tables.items()]


def _plain(array: Any) -> Any:
    """An array, or a number of NumPy's, for TOML."""
    return array.tolist()


def _array(_: Any, value: Any) -> Floats:
    """An array from TOML."""
    return np.array(value, np.float64)
