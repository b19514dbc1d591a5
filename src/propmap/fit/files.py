"""Fit files: TOML that describes a fit, suffices to repeat it, and is a parameter set itself."""

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
from propmap.fit.fit import Coverage, Fitted
from propmap.fit.least_squares import End, FlightErrors, ResidualErrors, by_band, errors
from propmap.fit.parameters import BEYOND_ROTORS, ROTOR, THROTTLE, WING, described, general
from propmap.fit.tunnel import model_with, section_with
from propmap.hover import HoverModel
from propmap.io.sections import looks_like_section_table
from propmap.model.air import Air
from propmap.model.airfoil import Airfoil, SectionCovariance, fitted_uncertainty, read_airfoil
from propmap.model.envelope import Beyond, Envelope
from propmap.model.model import Model
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.typing import Floats


@dataclass(frozen=True, eq=False)
class FitFile:
    """What a fit file holds for further use.

    Attributes
    ----------
    airfoil : Airfoil
        The section law that was found.
    covariance : SectionCovariance or None
        What is known of the parameters of the section law and of the mount that were free; None
        where none was.
    record : FitRecord
        All that the file says of the fit.
    """

    airfoil: Airfoil
    covariance: SectionCovariance | None
    record: FitRecord

    @functools.cached_property
    def model(self) -> Model:
        """The law with the propeller and the air of the data."""
        return Model(self.record.propeller.propeller(), self.airfoil, self.record.air)

    @property
    def values(self) -> dict[str, float]:
        """The parameters of body, wing, sensor, wakes and flights by name."""
        return self.record.body | self.record.wing

    @property
    def curve(self) -> dict[str, float]:
        """Constants of the ``ThrottleCurve``; none where rotor speeds were measured."""
        return {name: self.values[name] for name in THROTTLE if name in self.values}

    @property
    def low_pass(self) -> float:
        """Cut-off of the low-pass that flights passed [Hz]; 0 for none."""
        return float(self.record.settings.get("low_pass", 0.0))

    @property
    def hover_reference(self) -> float | None:
        """Thrust over squares of rotor speeds in the hover of the fit's flights [N s^2], None where
        a flight's own hover plays no part."""
        return float(self.record.settings.get("hover_reference", 0.0)) or None

    def beyond(self, flow: tuple[Floats, Floats, Floats], radius: float) -> Beyond | None:
        """How far points leave the data of the fit; None where that is not known.

        Their ``flow`` are the arrays of ``Envelope.beyond``, ``radius`` is R [m].
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
    """The text of a fit file.

    Parameters
    ----------
    fitted : Fitted
        The fit.
    kind, name : str
        "tunnel", "level flight" or "flight"; the name of the parameter set.
    model : Model
        What was fitted; its section law gave the constants that are no parameters of a fit.
    data : sequence of Path or str
        Files, whose hashes are noted, or names of the catalogue.
    covered, envelope : Coverage, Envelope
        Operating points of the data.
    hover : ndarray, shape (M,)
        The hover model's values of the fitted rows.
    remarks, options : sequence of str, mapping
        Sentences for the reader; further settings by name.
    flights : mapping of str to mapping, optional
        Errors by load and flight, where there are several.

    Returns
    -------
    str
        TOML: a parameter set, with the record of the fit as the table ``fit``.
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
    """Whether a file is a parameter set that carries a fit; ``InputError`` for a bad set."""
    if path.exists() and looks_like_section_table(path):
        return False
    read_airfoil(path, uncertainty=False)
    return "fit" in tomllib.loads(path.read_text(encoding="utf-8"))


def read_fit(path: Path) -> FitFile:
    """Read a fit file.

    Parameters
    ----------
    path : Path
        Path of a file that ``propmap fit`` wrote.

    Raises
    ------
    InputError
        Where the file is no fit, or an entry of it is missing or of another kind.
    """
    law, where = read_airfoil(path, uncertainty=False), str(path)
    table = tomllib.loads(path.read_text(encoding="utf-8")).get("fit")
    if table is None:
        found = "there is no table [fit]: this is a parameter set, not a fit"
        remedy = "give a file written by propmap fit, or name the propeller with --prop"
        raise InputError(found, remedy, where)
    try:
        record = read_record(table)
        covariance = SectionCovariance(tuple(record.free), record.covariance)
        section = [name for name in record.free if name in ROTOR]
        known = fitted_uncertainty(table, tuple(ROTOR))
        law = law.with_parameters(uncertainty=known)
        file = FitFile(law, covariance.of(section) if section else None, record)
        _ = file.model  # Raises where there can be no such blade.
    except InputError as error:
        found = f"the table [fit] is damaged: {error.found}"
        raise InputError(found, error.remedy, where) from None
    return file


def _parameter(fitted: Fitted, k: int) -> FreeParameter:
    choice, sure = fitted.choice, fitted.uncertainty
    name = choice.free[k]
    known, prior = described(name), choice.prior_of(name)
    low, high = None, None
    if fitted.bootstrapped.size:
        low, high = np.percentile(fitted.bootstrapped[:, k], [2.5, 97.5]).tolist()
    return FreeParameter(
        name=name,
        value=fitted.x[k],
        unit=known.unit,
        low=sure.low[k],
        high=sure.high[k],
        verdict=sure.verdicts[k],
        identified=sure.identified[k],
        start=choice.first[k],
        lower=known.lower,
        upper=known.upper,
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


# -------------------------------------------------------------------------------------------------
# The table ``[fit]`` of a fit file: one description for writing and for reading.

BY_NAME = ("parameters", "residuals")  # tables by name in the file, lists in a record


class FreeParameter(msgspec.Struct, frozen=True, omit_defaults=True):
    """One fitted parameter, in ``unit``."""

    name: str
    value: float
    unit: str
    low: float = msgspec.field(name="low_95")  # ends of its 95 % interval
    high: float = msgspec.field(name="high_95")
    verdict: str
    identified: bool  # whether the data determine it
    start: float  # where the first search began
    lower: float  # bounds
    upper: float
    prior: tuple[float, float] | None = None  # mean and standard deviation
    # None where there was no bootstrap
    bootstrap_low: float | None = msgspec.field(name="bootstrap_low_95", default=None)
    bootstrap_high: float | None = msgspec.field(name="bootstrap_high_95", default=None)


class FittedLoad(ResidualErrors, frozen=True):
    """Errors of one load, in ``unit``: over all rows, on rows left out, by speed and by flight."""

    name: str
    unit: str
    cross_validated: float = msgspec.field(name="cross_validated_rms")
    by_speed: dict[str, ResidualErrors]
    by_flight: dict[str, FlightErrors] = msgspec.field(default_factory=dict)

    @property
    def measured_rms(self) -> float:
        """Root mean square of what was measured."""
        return self.rms / self.relative_rms if self.relative_rms > 0.0 else np.nan


class DataSource(msgspec.Struct, frozen=True, omit_defaults=True):
    """Where data are from: a file with its SHA-256, or a name of the catalogue."""

    file: str = ""
    sha256: str = ""
    catalogue: str = ""

    @classmethod
    def of(cls, item: Path | str) -> DataSource:
        """Name a file or folder (a ROS 2 bag is one) with its digest, or data of the catalogue."""
        if not isinstance(item, Path):
            return cls(catalogue=item)
        digest = hashlib.sha256()
        for file in sorted(item.rglob("*")) if item.is_dir() else [item]:
            if file.is_file():
                digest.update(file.read_bytes())
        return cls(item.name, digest.hexdigest())

    @property
    def name(self) -> str:
        """The name as it is shown."""
        return self.file or f"{self.catalogue} of the catalogue"


class FittedPropeller(msgspec.Struct, frozen=True):
    """The propeller of a fit, as in ``Propeller``."""

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
        """The propeller; ``InputError`` where there can be no such blade."""
        shape = (self.station_m, self.chord_m, self.twist_rad)
        return Propeller(self.name, self.blades, *shape, self.root)


class FitRecord(msgspec.Struct, frozen=True, omit_defaults=True):
    """All that a fit file says of its fit of P free parameters."""

    kind: str  # "tunnel", "level flight" or "flight"
    version: str = msgspec.field(name="propmap")
    remarks: list[str]
    free: list[str]
    rows: int  # numbers that were fitted
    # for how many of them the model had no solution
    unsolved: int = msgspec.field(name="unsolved_rows")
    seconds: float
    settings: dict[str, Any]
    fixed: dict[str, float]  # parameters that the user held
    air: Air
    propeller: FittedPropeller
    data: list[DataSource]
    covered: Coverage
    parameters: list[FreeParameter]
    body: dict[str, float]  # all parameters of the body, with the sensor's and the wakes' if any
    wing: dict[str, float]
    covariance: Floats  # (P, P), infinite where the data say nothing
    correlation: Floats  # (P, P)
    singular_values: Floats  # of the sensitivities, relative to the largest, (P,)
    loads: list[FittedLoad] = msgspec.field(name="residuals")
    starts: list[End]  # where the searches ended, best first
    # Errors that the fit left, as standard deviations of C_T and C_P [-], by the names of
    # ``DISCREPANCIES``; empty where an earlier version wrote the file.
    discrepancy: dict[str, float] = msgspec.field(default_factory=dict)
    envelope: Envelope | None = None  # None where an earlier version wrote the file

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
        # Arrays, and numbers of NumPy's, become lists and numbers.
        plain: dict[str, Any] = msgspec.to_builtins(self, enc_hook=lambda array: array.tolist())
        for key in BY_NAME:
            plain[key] = {entry.pop("name"): entry for entry in plain[key]}
        return plain


def read_record(table: Any) -> FitRecord:
    """The record of the table ``[fit]`` from TOML; ``InputError`` names an entry at fault."""
    known = table
    if isinstance(table, Mapping):
        known = {**table, **{key: _listed(table[key]) for key in BY_NAME if key in table}}
    try:
        # Lists become arrays.
        return msgspec.convert(known, FitRecord, dec_hook=lambda _, v: np.array(v, np.float64))
    except msgspec.ValidationError as error:
        fault, _, path = str(error).replace("`", "").partition(" - at $.")
        for key in BY_NAME:
            if found := re.match(rf"{key}\[(\d+)\]", path):
                path = f"{key}.{list(table[key])[int(found[1])]}{path[found.end() :]}"
        place = f"at {path}: " if path else ""
        raise InputError(f"{place}{fault}", "write it again with propmap fit") from None


def _listed(tables: Any) -> Any:
    """Make a list of tables by name; leave anything else as it is."""
    if not isinstance(tables, Mapping):
        return tables
    return [{"name": k, **t} if isinstance(t, Mapping) else t for k, t in tables.items()]


OF_THRUST, OF_TORQUE = ("thrust", "force_z", "vertical_force"), ("torque",)
"""Rows whose errors, over what the hover model says of them, are shares of a static load."""


def discrepancy(fitted: Fitted, found: Model, hover: Floats) -> dict[str, float]:
    """Standard deviations of C_T and C_P that a fit leaves, by name of ``DISCREPANCIES``, with the
    model ``found`` and the hover model's rows ``hover`` (M,); a load not fitted errs by as large a
    share."""
    shares = {}
    for kind, names in (("thrust", OF_THRUST), ("torque", OF_TORQUE)):
        for k, name in enumerate(fitted.rows.names):
            still = hover[fitted.rows.of_load(k)]
            size = float(np.sqrt(np.nanmean(still**2))) if still.size else 0.0
            if name in names and size > 0.0:
                shares[kind] = errors(*fitted.compared(k)).rms / size
    if not shares or not np.isfinite(list(shares.values())).all():
        return {}
    static = HoverModel.of(Rotor(found))
    blade, air = found.propeller, found.air
    thrust = abs(static.k_thrust) * (2.0 * np.pi) ** 2 / (air.density * blade.diameter**4)
    power = abs(static.k_torque) * (2.0 * np.pi) ** 3 / (air.density * blade.diameter**5)
    largest = max(shares.values())
    return {
        "thrust_coefficient": shares.get("thrust", largest) * thrust,
        "power_coefficient": shares.get("torque", largest) * power,
    }
