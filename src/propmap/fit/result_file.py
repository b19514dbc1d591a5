"""Fit files: TOML that repeats a fit, tells of it, and is a parameter set itself."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import propmap
from propmap.errors import InputError
from propmap.fit.fitted import Fitted
from propmap.fit.parameters import BODY, EVERY, SECTION, WING
from propmap.fit.residuals import by_band, errors
from propmap.fit.search import minima
from propmap.model.air import Air
from propmap.model.airfoil import Airfoil, read_airfoil
from propmap.model.propeller import Propeller
from propmap.model.section_covariance import SectionCovariance


@dataclass(frozen=True, eq=False)
class FitFile:
    """What a fit file holds for further use.

    airfoil : the parameter set.  propeller, air : those it was found with.  values : of the
    body's and the wing's parameters, by name.  covariance : of the section law's parameters that
    were free, None where the file has none.  record : the whole table ``fit``.
    """

    airfoil: Airfoil
    propeller: Propeller
    air: Air
    values: Mapping[str, float]
    covariance: SectionCovariance | None
    record: Mapping[str, Any]


def fit_text(
    fitted: Fitted,
    *,
    kind: str,
    name: str,
    propeller: Propeller,
    air: Air,
    base: Airfoil,
    data: Sequence[Path | str],
    covered: Mapping[str, Any],
    hover: NDArray[np.float64],
    remarks: Sequence[str],
    options: Mapping[str, Any],
) -> str:
    """The text of a fit file.

    fitted : the fit.  propeller, air : of the test or the vehicle.
    kind : "tunnel", "level flight" or "flight".  name : of the parameter set.  base : gave the
    constants that are no parameters of a fit.  data : files, whose hashes are noted, or names of
    the catalogue.  covered : what ``coverage`` says of the operating points.  hover : (M,), the
    hover model's values of the fitted rows.  remarks : sentences for the reader.
    options : further settings by name.
    """
    import tomli_w

    section = {n: fitted.values[n] for n in SECTION}
    law = base.with_parameters(**section, name=name, source=f"fitted by propmap, {kind}")
    sure, choice = fitted.uncertainty, fitted.choice
    parameters = {
        n: {
            "value": float(fitted.x[k]),
            "unit": EVERY[n].unit,
            "low_95": float(sure.low[k]),
            "high_95": float(sure.high[k]),
            "verdict": sure.verdicts[k],
            "identified": sure.identified[k],
            "start": float(choice.first[k]),
            "lower": EVERY[n].lower,
            "upper": EVERY[n].upper,
        }
        for k, n in enumerate(choice.free)
    }
    for k, n in enumerate(choice.free):
        if n in choice.priors:
            prior = choice.priors[n]
            parameters[n]["prior"] = [prior.mean, prior.deviation]
        if fitted.bootstrapped.size:
            low, high = np.percentile(fitted.bootstrapped[:, k], [2.5, 97.5])
            parameters[n] |= {"bootstrap_low_95": float(low), "bootstrap_high_95": float(high)}
    spread = choice.column("spread")
    record = {
        "kind": kind,
        "propmap": propmap.__version__,
        "remarks": list(remarks),
        "free": list(choice.free),
        "rows": int(np.count_nonzero(fitted.rows.weight)),
        "unsolved_rows": fitted.minimum.unsolved,
        "seconds": round(fitted.seconds, 3),
        "settings": asdict(fitted.settings) | dict(options),
        "fixed": {n: float(v) for n, v in choice.fixed.items()},
        "air": {"density": air.density, "viscosity": air.viscosity},
        "propeller": {
            "name": propeller.name,
            "blades": propeller.blades,
            "root": propeller.root,
            "station_m": propeller.station.tolist(),
            "chord_m": propeller.chord.tolist(),
            "twist_rad": propeller.twist.tolist(),
        },
        "data": [source_entry(item) for item in data],
        "covered": dict(covered),
        "parameters": parameters,
        "body": {n: fitted.values[n] for n in BODY},
        "wing": {n: fitted.values[n] for n in WING},
        "covariance": [[float(v) for v in row] for row in sure.covariance],
        "correlation": [[float(v) for v in row] for row in sure.correlation],
        "singular_values": sure.singular_values.tolist(),
        "residuals": _residuals(fitted, hover),
        "starts": [
            {
                "start": fitted.minimum.ends[k].start.tolist(),
                "end": fitted.minimum.ends[k].x.tolist(),
                "cost": fitted.minimum.ends[k].cost,
                "minimum": number,
            }
            for number, group in enumerate(minima(fitted.minimum.ends, spread), start=1)
            for k in group
        ],
    }
    return law.to_toml() + "\n" + tomli_w.dumps({"fit": record})


def is_fit(path: Path) -> bool:
    """Whether a parameter set carries a fit; raises ``InputError`` where it is no such set."""
    read_airfoil(path)
    return "fit" in tomllib.loads(path.read_text(encoding="utf-8"))


def read_fit(path: Path) -> FitFile:
    """Read a fit file.

    path : of a file that ``propmap fit`` wrote.
    Raises ``InputError`` where it is none.
    """
    law = read_airfoil(path)
    record = tomllib.loads(path.read_text(encoding="utf-8")).get("fit")
    where = str(path)
    if record is None:
        raise InputError(
            "there is no table [fit]: this is a parameter set, not a fit",
            "give a file written by propmap fit, or name the propeller with --prop",
            where,
        )
    try:
        blade, air = record["propeller"], record["air"]
        propeller = Propeller(
            blade["name"],
            blade["blades"],
            np.array(blade["station_m"]),
            np.array(blade["chord_m"]),
            np.array(blade["twist_rad"]),
            blade["root"],
        )
        values = {n: float(v) for n, v in (record["body"] | record["wing"]).items()}
        medium = Air(air["density"], air["viscosity"])
        return FitFile(law, propeller, medium, values, _covariance(record), record)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"the table [fit] is damaged: {error}", "write it again with propmap fit", where
        ) from None


def _covariance(record: Mapping[str, Any]) -> SectionCovariance | None:
    """Of the free parameters that belong to the section law."""
    names = record.get("free", [])
    section = [name for name in names if name in SECTION]
    if not section or "covariance" not in record:
        return None
    return SectionCovariance(tuple(names), np.array(record["covariance"], float)).of(section)


def _residuals(fitted: Fitted, hover: NDArray[np.float64]) -> dict[str, Any]:
    rows, told = fitted.rows, {}
    for k, name in enumerate(rows.names):
        mine = (rows.load == k) & (rows.weight > 0.0)
        measured = rows.measured[mine]
        model = measured + fitted.residual[mine]
        still = hover[mine]
        whole = errors(model, measured, still)
        told[name] = {
            "unit": rows.units[k],
            "rows": whole.rows,
            "rms": whole.rms,
            "relative_rms": whole.relative_rms,
            "bias": whole.bias,
            "worst": whole.worst,
            "hover_rms": whole.hover_rms,
            "cross_validated_rms": float(fitted.cross_validated[k]),
            "by_speed": {
                band: {
                    "rows": e.rows,
                    "rms": e.rms,
                    "bias": e.bias,
                    "worst": e.worst,
                    "hover_rms": e.hover_rms,
                }
                for band, e in by_band(model, measured, rows.speed[mine], still).items()
            },
        }
    return told


def source_entry(item: Path | str) -> dict[str, str]:
    """How a fit file names its data: a file with its hash, or a name of the catalogue."""
    if isinstance(item, Path):
        return {"file": item.name, "sha256": hashlib.sha256(item.read_bytes()).hexdigest()}
    return {"catalogue": item}
