"""The study file in TOML, and the quadratic response surface of a study's results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.structs import asdict

from propmap.errors import InputError
from propmap.io.toml import Number, Text, TomlTable, checked, read_toml
from propmap.rotor import Rotor
from propmap.study.run import OPERATION, Study
from propmap.typing import Floats
from propmap.units import INCH

STUDY_SCHEMA = 1

KEYS = {
    "diameter_m": ("diameter", 1.0),
    "diameter_in": ("diameter", INCH),
    "pitch_m": ("pitch", 1.0),
    "pitch_in": ("pitch", INCH),
    **{name: (name, 1.0) for name in ("chord_scale", "twist_scale", "blades", *OPERATION)},
}  # keys of [vary]: name in ``VARIABLES``, and factor to its unit


Values = Annotated[Number | list[Number], "a number, or [...]"]


class _Points(TomlTable):
    rpm: Values | None = None
    speed_mps: Values | None = None
    beta_deg: Values | None = None


class _Vary(_Points):
    diameter_m: Values | None = None
    diameter_in: Values | None = None
    pitch_m: Values | None = None
    pitch_in: Values | None = None
    chord_scale: Values | None = None
    twist_scale: Values | None = None
    blades: Values | None = None


class _StudyPropeller(TomlTable):
    name: Annotated[Text, '"apc-8x6e"']
    airfoil: Annotated[str, '"paper-apc"'] = ""


class _Sampling(TomlTable):
    method: Literal["latin-hypercube", "full-factorial"]
    designs: Annotated[int, Meta(ge=0), "200"] | None = None
    seed: Annotated[int, Meta(ge=0), "1"] = 1

    def __post_init__(self) -> None:
        if self.method == "latin-hypercube" and self.designs is None:
            raise InputError("no designs", "add designs = 200")
        if self.method != "latin-hypercube" and self.designs is not None:
            found = "designs is given, but a full factorial always has all combinations"
            raise InputError(found, "remove designs, or give more values in [vary]")


class _StudyFile(TomlTable):
    propeller: _StudyPropeller
    sampling: _Sampling
    vary: dict[str, Any] = msgspec.field(default_factory=dict)  # a ``_Vary`` that keeps the order
    points: _Points = msgspec.field(default_factory=_Points)


@dataclass(frozen=True)
class StudyFile:
    """Content of a study file: names as on the command line, and the arguments of ``Study``."""

    propeller: str  # baseline design, as on the command line
    airfoil: str  # empty for the default section constants of the propeller
    varied: dict[str, Floats]
    axes: dict[str, Floats]
    designs: int | None
    seed: int

    def study(self, rotor: Rotor) -> Study:
        """Return the study, with ``rotor`` as the baseline design."""
        return Study(rotor, self.varied, self.axes, self.designs, self.seed)


def read_study(path: Path) -> StudyFile:
    """Read the file at ``path``; raise ``InputError`` with the wrong entry."""
    where = str(path)
    file = read_toml(path, _StudyFile, STUDY_SCHEMA, "study")
    given = asdict(checked(file.vary, _Vary, f"{where}: [vary]"))
    varied: dict[str, Floats] = {}
    for key in file.vary:
        name, unit = KEYS[key]
        if name in varied:
            found = f"{name} is given twice"
            raise InputError(found, "give it in meters or in inches", f"{where}: [vary]")
        varied[name] = unit * np.atleast_1d(np.asarray(given[key], np.float64))
    shared = {name: values for name, values in asdict(file.points).items() if values is not None}
    axes = {name: np.atleast_1d(np.asarray(v, np.float64)) for name, v in shared.items()}
    return StudyFile(
        propeller=file.propeller.name,
        airfoil=file.propeller.airfoil,
        varied=varied,
        axes=axes,
        designs=file.sampling.designs,
        seed=file.sampling.seed,
    )


# -------------------------------------------------------------------------------------------------
# A quadratic response surface of a study's results, and its error at designs left out of the fit.


@dataclass(frozen=True, eq=False)
class ResponseSurface:
    """A second-order polynomial of the variables of a study.

    Attributes
    ----------
    names : tuple of str
        Variables.
    low, high : ndarray, shape (k,)
        Least and largest value of each variable.
    coefficients : ndarray
        Coefficients of the terms: the constant, each variable, and each product of two variables,
        including squares.  The variables are scaled to -1 to 1.
    left_out_rms : float
        Root mean square error at designs left out of the fit one at a time, in the quantity's unit.
    """

    names: tuple[str, ...]
    low: Floats
    high: Floats
    coefficients: Floats
    left_out_rms: float

    def __call__(self, rows: Mapping[str, Floats]) -> Floats:
        """Return values (n,) at n designs; ``rows`` has values (n,) of each of ``names``."""
        return np.asarray(_terms(self._unit(rows)) @ self.coefficients)

    def middle(self) -> dict[str, float]:
        """Return the middle of the range of each of ``names``."""
        return dict(zip(self.names, (0.5 * (self.low + self.high)).tolist(), strict=True))

    def _unit(self, rows: Mapping[str, Floats]) -> Floats:
        """Return the variables (n, k) scaled from -1 to 1."""
        values = np.stack([np.asarray(rows[name], np.float64) for name in self.names], axis=1)
        return np.asarray(2.0 * (values - self.low) / (self.high - self.low) - 1.0)


def response_surface(rows: Mapping[str, Floats], values: Floats) -> ResponseSurface:
    """Fit a quadratic response surface by least squares.

    Parameters
    ----------
    rows : mapping of str to ndarray, shape (n,)
        Values of each variable at the n designs.
    values : ndarray, shape (n,)
        Quantity to fit; designs with NaN are left out.

    Raises
    ------
    InputError
        Unless there are more designs than coefficients of the quadratic.
    """
    good = np.isfinite(values)
    used = {n: np.asarray(v)[good] for n, v in rows.items() if np.ptp(v[good] if good.any() else v)}
    names = tuple(used)
    low, high = (np.array([edge(v) for v in used.values()], float) for edge in (np.min, np.max))
    unfitted = ResponseSurface(names, low, high, np.empty(0), np.nan)
    terms = _terms(unfitted._unit(used)) if names else np.ones((int(good.sum()), 1))
    count = terms.shape[1]
    if good.sum() <= count:
        found = f"a quadratic of {len(names)} variables has {count} coefficients"
        found += f", but only {good.sum()} designs have values"
        raise InputError(found, "give more designs")
    # A variable with two levels does not determine its square: use the minimum-norm solution.
    inverse = np.linalg.pinv(terms)
    coefficients = inverse @ values[good]
    # The residual over 1 - leverage is the residual of a fit without the point.
    leverage = np.minimum(np.einsum("ij,ji->i", terms, inverse), 1.0 - 1e-9)
    error = (values[good] - terms @ coefficients) / (1.0 - leverage)
    return ResponseSurface(names, low, high, coefficients, float(np.sqrt(np.mean(error**2))))


def _terms(unit: Floats) -> Floats:
    """Return the terms 1, each variable, and each product of two variables, (n, t)."""
    count, k = unit.shape
    products = [unit[:, i] * unit[:, j] for i in range(k) for j in range(i, k)]
    return np.column_stack([np.ones(count), unit, *products])
