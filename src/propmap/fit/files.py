"""Fit files: parameter sets in TOML that also contain everything needed to repeat the fit."""

from __future__ import annotations

import functools
import hashlib
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

import propmap
from propmap.errors import InputError
from propmap.fit.fit import OF_THRUST, OF_TORQUE, Coverage, Fitted
from propmap.fit.least_squares import End, FlightErrors, ResidualErrors, by_band, errors
from propmap.fit.parameters import BEYOND_ROTORS, ROTOR, THROTTLE, WING, described, general, known
from propmap.fit.tunnel import model_with, section_with
from propmap.hover import HoverModel
from propmap.io.sections import looks_like_section_table
from propmap.model.air import Air
from propmap.model.airfoil import (
    Airfoil,
    SectionCovariance,
    fitted_uncertainty,
    other_version,
    read_airfoil,
)
from propmap.model.envelope import Beyond, Envelope
from propmap.model.model import Model
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.typing import Floats


@dataclass(frozen=True, eq=False)
class FitFile:
    """Contents of a fit file.

    Attributes
    ----------
    airfoil : Airfoil
        Identified section law.
    covariance : SectionCovariance or None
        Covariance of the free parameters of the rotor: section law, untwist, installation.  None
        for a fit without such parameters.
    record : FitRecord
        Data, settings and results of the fit.
    """

    airfoil: Airfoil
    covariance: SectionCovariance | None
    record: FitRecord

    @functools.cached_property
    def model(self) -> Model:
        """Model of the section law with the propeller and the air of the data."""
        return Model(self.record.propeller.propeller(), self.airfoil, self.record.air)

    @property
    def values(self) -> dict[str, float]:
        """Parameters of body, wing, sensor, wakes and flights by name."""
        return self.record.body | self.record.wing

    @property
    def curve(self) -> dict[str, float]:
        """Constants of the ``ThrottleCurve``; empty for a fit to measured rotor speeds."""
        return {name: self.values[name] for name in THROTTLE if name in self.values}

    @property
    def low_pass(self) -> float:
        """Cut-off frequency of the low-pass filter of the flights [Hz]; 0 for no filter."""
        return float(self.record.settings.get("low_pass", 0.0))

    @property
    def hover_reference(self) -> float | None:
        """Thrust / sum of squared rotor speeds in hover, for thrust scale 1 [N s^2].

        None for a fit that does not use the hover of its flights.
        """
        return float(self.record.settings.get("hover_reference", 0.0)) or None

    def beyond(self, flow: tuple[Floats, Floats, Floats], radius: float) -> Beyond | None:
        """Return how far points are outside the data of the fit; None without an envelope.

        ``flow`` contains omega, axial and inplane of ``Envelope.beyond``, and ``radius`` is R [m].
        """
        known = self.record.envelope
        return None if known is None else known.beyond(*flow, radius)


def fit_text(
    fitted: Fitted,
    *,
    kind: str,
    name: str,
    model: Model,
    data: Sequence[Path | str],
    covered: Coverage,
    envelope: Envelope,
    hover: Floats,
    remarks: Sequence[str],
    options: Mapping[str, Any],
    flights: Mapping[str, Mapping[str, FlightErrors]] | None = None,
) -> str:
    """Return the text of a fit file.

    Parameters
    ----------
    fitted : Fitted
        Result of the fit.
    kind, name : str
        Kind of the fit, "tunnel", "level flight" or "flight"; name of the parameter set.
    model : Model
        Fitted model; its section law provides the constants that a fit cannot vary.
    data : sequence of Path or str
        Files, stored with their hashes, or names of the catalogue.
    covered, envelope : Coverage, Envelope
        Coverage and envelope of the operating points of the data.
    hover : ndarray, shape (M,)
        Loads of the hover model for the fitted rows.
    remarks, options : sequence of str, mapping
        Sentences for the reader; further settings by name.
    flights : mapping of str to mapping, optional
        Errors by load and flight, for a fit to several flights.

    Returns
    -------
    str
        TOML text of a parameter set, with the record of the fit in the table ``fit``.
    """
    import tomli_w

    found = model_with(model, fitted.values)
    about = {"name": name, "source": f"fitted by propmap, {kind}"}
    law = section_with(model.airfoil, fitted.values).with_parameters(
        **about, corrections=tuple(found.correction_texts)
    )
    sure, choice = fitted.uncertainty, fitted.choice
    record = FitRecord(
        kind=kind,
        version=propmap.__version__,
        remarks=list(remarks),
        free=list(choice.free),
        rows=int(np.count_nonzero(fitted.rows.weight)),
        unsolved=fitted.minimum.unsolved,
        seconds=round(fitted.seconds, 3),
        settings=asdict(fitted.settings) | dict(options),
        fixed=dict(choice.fixed),
        air=model.air,
        propeller=FittedPropeller.of(model.propeller),
        data=[DataSource.of(item) for item in data],
        covered=covered,
        parameters=[_parameter(fitted, k) for k in range(len(choice.free))],
        body={n: value for n, value in fitted.values.items() if general(n) in BEYOND_ROTORS},
        wing={n: fitted.values[n] for n in WING},
        covariance=sure.covariance,
        correlation=sure.correlation,
        singular_values=sure.singular_values,
        loads=[_load(fitted, k, hover, flights or {}) for k in range(len(fitted.rows.names))],
        starts=sorted(fitted.minimum.ends, key=lambda end: end.minimum),
        discrepancy=discrepancy(fitted, found, hover),
        envelope=envelope,
    )
    return law.to_toml() + "\n" + tomli_w.dumps({"fit": record.table()})


def is_fit(path: Path) -> bool:
    """Return whether a file is a parameter set with a fit; ``InputError`` for a bad set."""
    if path.exists() and looks_like_section_table(path):
        return False
    read_airfoil(path, uncertainty=False)
    return "fit" in tomllib.loads(path.read_text(encoding="utf-8"))


def read_fit(path: Path) -> FitFile:
    """Read a fit file.

    Parameters
    ----------
    path : Path
        Path of a file from ``propmap fit``.

    Raises
    ------
    InputError
        For a file without a fit, and for an entry that is missing or has the wrong type.
    """
    law, where = read_airfoil(path, uncertainty=False), str(path)
    table = tomllib.loads(path.read_text(encoding="utf-8")).get("fit")
    if table is None:
        found = "there is no table [fit]: this is a parameter set, not a fit"
        remedy = "give a file written by propmap fit, or name the propeller with --prop"
        raise InputError(found, remedy, where)
    try:
        record = read_record(table)
        for name in (*record.free, *record.fixed, *record.body, *record.wing):
            known(name)  # raises an InputError for a parameter of another version
        covariance = SectionCovariance(tuple(record.free), record.covariance)
        section = [name for name in record.free if name in ROTOR]
        uncertainty = fitted_uncertainty(table, tuple(ROTOR))
        law = law.with_parameters(uncertainty=uncertainty)
        file = FitFile(law, covariance.of(section) if section else None, record)
        _ = file.model  # raises an InputError for an impossible blade
    except InputError as error:
        found = f"the table [fit] cannot be read: {error.found}"
        raise InputError(found, other_version(table) or error.remedy, where) from None
    return file


def _parameter(fitted: Fitted, k: int) -> FreeParameter:
    choice, sure = fitted.choice, fitted.uncertainty
    name = choice.free[k]
    about, prior = described(name), choice.prior_of(name)
    low, high = None, None
    if fitted.bootstrapped.size:
        low, high = np.percentile(fitted.bootstrapped[:, k], [2.5, 97.5]).tolist()
    return FreeParameter(
        name=name,
        value=fitted.x[k],
        unit=about.unit,
        low=sure.low[k],
        high=sure.high[k],
        verdict=sure.verdicts[k],
        identified=sure.identified[k],
        start=choice.first[k],
        lower=about.lower,
        upper=about.upper,
        prior=(prior.mean, prior.deviation) if prior else None,
        bootstrap_low=low,
        bootstrap_high=high,
    )


def _load(
    fitted: Fitted, k: int, hover: Floats, flights: Mapping[str, Mapping[str, FlightErrors]]
) -> FittedLoad:
    rows = fitted.rows
    mine, (model, measured) = rows.of_load(k), fitted.compared(k)
    return FittedLoad(
        name=rows.names[k],
        unit=rows.units[k],
        cross_validated=fitted.cross_validated[k],
        by_speed=by_band(model, measured, rows.speed[mine], hover[mine]),
        by_flight=dict(flights.get(rows.names[k], {})),
        **msgspec.structs.asdict(errors(model, measured, hover[mine])),
    )


# --- The table ``[fit]`` of a fit file; the same classes write and read it -----------------------

BY_NAME = ("parameters", "residuals")  # fields of ``FitRecord``: lists here, tables in the file


class FreeParameter(msgspec.Struct, frozen=True, omit_defaults=True):
    """One fitted parameter, with numbers in ``unit``."""

    name: str
    value: float
    unit: str
    low: float = msgspec.field(name="low_95")  # ends of the 95 % interval
    high: float = msgspec.field(name="high_95")
    verdict: str
    identified: bool  # whether the data determine the parameter
    start: float  # start of the first search
    lower: float  # bounds
    upper: float
    prior: tuple[float, float] | None = None  # mean and standard deviation
    # None for a fit without bootstrap
    bootstrap_low: float | None = msgspec.field(name="bootstrap_low_95", default=None)
    bootstrap_high: float | None = msgspec.field(name="bootstrap_high_95", default=None)


class FittedLoad(ResidualErrors, frozen=True):
    """Errors of one load in ``unit``: over all rows, cross-validated, by speed and by flight."""

    name: str
    unit: str
    cross_validated: float = msgspec.field(name="cross_validated_rms")
    by_speed: dict[str, ResidualErrors]
    by_flight: dict[str, FlightErrors] = msgspec.field(default_factory=dict)

    @property
    def measured_rms(self) -> float:
        """Root mean square of the measured load."""
        return self.rms / self.relative_rms if self.relative_rms > 0.0 else np.nan


class DataSource(msgspec.Struct, frozen=True, omit_defaults=True):
    """Source of data: a file with its SHA-256, or a name of the catalogue."""

    file: str = ""
    sha256: str = ""
    catalogue: str = ""

    @classmethod
    def of(cls, item: Path | str) -> DataSource:
        """Return the source of a file or folder (such as a ROS 2 bag) or of catalogue data."""
        if not isinstance(item, Path):
            return cls(catalogue=item)
        digest = hashlib.sha256()
        for file in sorted(item.rglob("*")) if item.is_dir() else [item]:
            if file.is_file():
                digest.update(file.read_bytes())
        return cls(item.name, digest.hexdigest())

    @property
    def name(self) -> str:
        """Name for reports."""
        return self.file or f"{self.catalogue} of the catalogue"


class FittedPropeller(msgspec.Struct, frozen=True):
    """Propeller of a fit; see ``Propeller`` for the fields."""

    name: str
    blades: int
    root: float
    station_m: Floats
    chord_m: Floats
    twist_rad: Floats

    @classmethod
    def of(cls, blade: Propeller) -> FittedPropeller:
        """Return the properties of a propeller that determine its loads."""
        shape = (blade.station, blade.chord, blade.twist)
        return cls(blade.name, blade.blades, blade.root, *shape)

    def propeller(self) -> Propeller:
        """Return the propeller; raise ``InputError`` for an impossible blade."""
        shape = (self.station_m, self.chord_m, self.twist_rad)
        return Propeller(self.name, self.blades, *shape, self.root)


class FitRecord(msgspec.Struct, frozen=True, omit_defaults=True):
    """Record of a fit of P free parameters, as stored in a fit file."""

    kind: str  # "tunnel", "level flight" or "flight"
    version: str = msgspec.field(name="propmap")
    remarks: list[str]
    free: list[str]
    rows: int  # number of fitted measurements
    # number of these measurements for which the model had no solution
    unsolved: int = msgspec.field(name="unsolved_rows")
    seconds: float
    settings: dict[str, Any]
    fixed: dict[str, float]  # parameters that the user fixed
    air: Air
    propeller: FittedPropeller
    data: list[DataSource]
    covered: Coverage
    parameters: list[FreeParameter]
    body: dict[str, float]  # parameters of ``BEYOND_ROTORS``
    wing: dict[str, float]
    covariance: Floats  # (P, P), infinite variances of parameters that the data do not determine
    correlation: Floats  # (P, P)
    singular_values: Floats  # of the sensitivities, divided by the largest, (P,)
    loads: list[FittedLoad] = msgspec.field(name="residuals")
    starts: list[End]  # ends of all searches, best first
    # Standard deviations of the errors of C_T and C_P that the fit leaves [-], by the names of
    # ``DISCREPANCIES``; empty in files of earlier versions.
    discrepancy: dict[str, float] = msgspec.field(default_factory=dict)
    envelope: Envelope | None = None  # None in files of earlier versions

    def __post_init__(self) -> None:
        count = len(self.parameters)
        if [p.name for p in self.parameters] != self.free:
            raise ValueError("the parameters differ from the list free")
        square = {self.covariance.shape, self.correlation.shape} == {(count, count)}
        if not square or self.singular_values.shape != (count,):
            raise ValueError(f"the matrices do not have the size of {count} parameters")
        if not (self.loads and self.starts):
            raise ValueError("residuals or starts are empty")

    @property
    def minima(self) -> int:
        """Number of different minima that the searches found."""
        return max(end.minimum for end in self.starts)

    def table(self) -> dict[str, Any]:
        """Return plain data for a TOML file."""
        # The hook converts arrays and numbers of NumPy to lists and numbers.
        plain: dict[str, Any] = msgspec.to_builtins(self, enc_hook=lambda array: array.tolist())
        for key in BY_NAME:
            plain[key] = {entry.pop("name"): entry for entry in plain[key]}
        return plain


def read_record(table: Any) -> FitRecord:
    """Return the record of a table ``[fit]`` from TOML; ``InputError`` names the wrong entry."""
    known = table
    if isinstance(table, Mapping):
        known = {**table, **{key: _listed(table[key]) for key in BY_NAME if key in table}}
    try:
        # The hook converts lists to arrays.
        return msgspec.convert(known, FitRecord, dec_hook=lambda _, v: np.array(v, np.float64))
    except msgspec.ValidationError as error:
        fault, _, path = str(error).replace("`", "").partition(" - at $.")
        for key in BY_NAME:
            if found := re.match(rf"{key}\[(\d+)\]", path):
                path = f"{key}.{list(table[key])[int(found[1])]}{path[found.end() :]}"
        place = f"at {path}: " if path else ""
        raise InputError(f"{place}{fault}", "run `propmap fit` again") from None


def _listed(tables: Any) -> Any:
    """Convert a mapping of tables to a list with keys as ``name``; keep other values unchanged."""
    if not isinstance(tables, Mapping):
        return tables
    return [{"name": k, **t} if isinstance(t, Mapping) else t for k, t in tables.items()]


def discrepancy(fitted: Fitted, found: Model, hover: Floats) -> dict[str, float]:
    """Return standard deviations of the errors of C_T and C_P after a fit, by ``DISCREPANCIES``.

    ``found`` is the fitted model, and ``hover`` (M,) contains the loads of the hover model.  A load
    that was not fitted gets the relative error of the other load.
    """
    shares = {}
    for kind, names in (("thrust", OF_THRUST), ("torque", OF_TORQUE)):
        for k, name in enumerate(fitted.rows.names):
            still = hover[fitted.rows.of_load(k)]
            size = 0.0 if still.size == 0 else float(np.sqrt(np.nanmean(still**2)))
            if name in names and size > 0.0:
                shares[kind] = errors(*fitted.compared(k)).rms / size
    if not shares or not np.isfinite(list(shares.values())).all():
        return {}
    static = HoverModel.from_rotor(Rotor(found))
    blade, air = found.propeller, found.air
    thrust = abs(static.k_thrust) * (2.0 * np.pi) ** 2 / (air.density * blade.diameter**4)
    power = abs(static.k_torque) * (2.0 * np.pi) ** 3 / (air.density * blade.diameter**5)
    largest = max(shares.values())
    return {
        "thrust_coefficient": shares.get("thrust", largest) * thrust,
        "power_coefficient": shares.get("torque", largest) * power,
    }
