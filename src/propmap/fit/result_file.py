"""Fit files: TOML that repeats a fit, tells of it, and is a parameter set itself."""

from __future__ import annotations

import functools
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

import propmap
from propmap.errors import InputError
from propmap.fit.coverage import Coverage
from propmap.fit.discrepancy import discrepancy
from propmap.fit.fit_record import (
    FitRecord,
    FittedLoad,
    FittedPropeller,
    FreeParameter,
    Source,
    read_record,
)
from propmap.fit.fitted import Fitted
from propmap.fit.learned_residual import LearnedResidual
from propmap.fit.parameters import (
    BODY,
    FLIGHT,
    ROTOR,
    SENSOR,
    TURNING,
    WAKES,
    WING,
    described,
    general,
)
from propmap.fit.residuals import FlightErrors, by_band, errors
from propmap.fit.tunnel import model_with, section_with
from propmap.io.section_tables import looks_like_section_table
from propmap.model.airfoil import Airfoil, read_airfoil
from propmap.model.drag_factor import drag_factor_accepted
from propmap.model.model import Model
from propmap.model.section_covariance import SectionCovariance
from propmap.model.uncertainty import fitted_uncertainty
from propmap.typing import Floats

BEYOND_ROTORS = BODY | SENSOR | TURNING | WAKES | FLIGHT
"""What the table ``[fit.body]`` has; the rest is the section law, its corrections and the wing."""


@dataclass(frozen=True, eq=False)
class FitFile:
    """What a fit file holds for further use.

    Attributes
    ----------
    airfoil : Airfoil
        The section law that was found.
    covariance : SectionCovariance or None
        Of the parameters of the section law and of the mount that were free; None where none was.
    record : FitRecord
        All that the file tells of the fit.
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
    def low_pass(self) -> float:
        """Cut-off of the low-pass that flights passed [Hz]; 0 for none."""
        return float(self.record.settings.get("low_pass", 0.0))

    @property
    def hover_reference(self) -> float | None:
        """Thrust over squares of rotor speeds in the hover of the fit's flights [N s^2].

        None where a flight's own hover plays no part.
        """
        return float(self.record.settings.get("hover_reference", 0.0)) or None

    @property
    def learned_residual(self) -> LearnedResidual | None:
        """What ``propmap fit flight --residual`` learned besides; None where it did not."""
        table = self.record.settings.get("learned_residual")
        return None if table is None else LearnedResidual.of_table(table)


def fit_text(
    fitted: Fitted,
    *,
    kind: str,
    name: str,
    model: Model,
    data: Sequence[Path | str],
    covered: Coverage,
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
    covered : Coverage
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
        TOML: a parameter set, and what the fit tells of itself as the table ``fit``.
    """
    import tomli_w

    found = model_with(model, fitted.values)
    told = {"name": name, "source": f"fitted by propmap, {kind}"}
    with drag_factor_accepted():
        law = section_with(model.airfoil, fitted.values).with_parameters(
            **told, corrections=tuple(found.correction_texts)
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
        data=[Source.of(item) for item in data],
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
        Of a file that ``propmap fit`` wrote.

    Raises
    ------
    InputError
        Where the file is no fit, or an entry of it is missing or of another kind.
    """
    law, where = read_airfoil(path, uncertainty=False), str(path)
    table = tomllib.loads(path.read_text(encoding="utf-8")).get("fit")
    if table is None:
        raise InputError(
            "there is no table [fit]: this is a parameter set, not a fit",
            "give a file written by propmap fit, or name the propeller with --prop",
            where,
        )
    try:
        record = read_record(table)
        covariance = SectionCovariance(tuple(record.free), record.covariance)
        section = [name for name in record.free if name in ROTOR]
        known = fitted_uncertainty(table, tuple(ROTOR))
        with drag_factor_accepted():
            law = law.with_parameters(uncertainty=known)
        file = FitFile(law, covariance.of(section) if section else None, record)
        _ = file.model  # Raises where there can be no such blade.
    except InputError as error:
        raise InputError(
            f"the table [fit] is damaged: {error.found}", error.remedy, where
        ) from None
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
