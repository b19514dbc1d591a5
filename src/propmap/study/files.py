"""The file that says what a study varies, and the quadratic through its results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.structs import asdict

from propmap.errors import InputError, quoted
from propmap.io.toml import Number, Text, TomlTable, checked, read_toml
from propmap.rotor import Rotor
from propmap.study.run import OPERATION, Study
from propmap.sweep.points import TEXTS
from propmap.typing import Floats
from propmap.units import INCH

STUDY_SCHEMA = 1

KEYS = {
    "diameter_m": ("diameter", 1.0),
    "diameter_in": ("diameter", INCH),
    "pitch_m": ("pitch", 1.0),
    "pitch_in": ("pitch", INCH),
    **{name: (name, 1.0) for name in ("chord_scale", "twist_scale", "blades", *OPERATION)},
}  # what may stand in [vary], its name in ``VARIABLES`` and what to multiply it by


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
            found = "designs is given, but a full factorial has all combinations"
            raise InputError(found, "remove it, or write more values")


class _Picture(TomlTable):
    quantity: Annotated[str, '"power"'] | None = None
    x: Annotated[str, '"diameter"'] | None = None
    y: Annotated[str, '"diameter"'] | None = None
    rpm: Annotated[Number, "the value at which to cut"] | None = None
    speed_mps: Annotated[Number, "the value at which to cut"] | None = None
    beta_deg: Annotated[Number, "the value at which to cut"] | None = None


class _StudyFile(TomlTable):
    propeller: _StudyPropeller
    sampling: _Sampling
    title: Annotated[str, '"..."'] | None = None
    vary: dict[str, Any] = msgspec.field(default_factory=dict)  # a ``_Vary``, but the order counts
    points: _Points = msgspec.field(default_factory=_Points)
    picture: _Picture = msgspec.field(default_factory=_Picture)


@dataclass(frozen=True)
class Surface:
    """Which ``quantity`` of ``TEXTS`` to draw ``across`` and ``up`` two of what varies, and where
    on the axes of shared operating points, at the nearest values; by default at the first."""

    quantity: str
    across: str
    up: str
    at: dict[str, float]


@dataclass(frozen=True)
class StudyFile:
    """What a file says: names as on the command line, and what ``Study`` takes."""

    title: str
    propeller: str  # of the first design, as on the command line
    airfoil: str  # empty for that known of the propeller
    varied: dict[str, Floats]
    axes: dict[str, Floats]
    designs: int | None
    seed: int
    surface: Surface | None  # None where no two quantities vary

    def study(self, rotor: Rotor) -> Study:
        """The study, of designs made from that of ``rotor``."""
        return Study(rotor, self.varied, self.axes, self.designs, self.seed)


def read_study(path: Path) -> StudyFile:
    """Read the file at ``path``; ``InputError`` names what is wrong in it."""
    where = str(path)
    file = read_toml(path, _StudyFile, STUDY_SCHEMA, "study")
    given = asdict(checked(file.vary, _Vary, f"{where}: [vary]"))
    varied: dict[str, Floats] = {}
    for key in file.vary:
        name, unit = KEYS[key]
        if name in varied:
            found = f"{name} is given twice"
            raise InputError(found, "give it in metres or in inches", f"{where}: [vary]")
        varied[name] = unit * np.atleast_1d(np.asarray(given[key], np.float64))
    shared = {name: values for name, values in asdict(file.points).items() if values is not None}
    axes = {name: np.atleast_1d(np.asarray(v, np.float64)) for name, v in shared.items()}
    return StudyFile(
        title=f"study of {path.stem}" if file.title is None else file.title,
        propeller=file.propeller.name,
        airfoil=file.propeller.airfoil,
        varied=varied,
        axes=axes,
        designs=file.sampling.designs,
        seed=file.sampling.seed,
        surface=_surface(file.picture, varied, axes, f"{where}: [picture]"),
    )


def _surface(
    picture: _Picture, varied: dict[str, Floats], axes: dict[str, Floats], where: str
) -> Surface | None:
    wide = [name for name, values in varied.items() if values.size > 1]
    if len(wide) < 2 and picture == _Picture():
        return None
    chosen: list[str] = []
    for number, (key, text) in enumerate((("x", picture.x), ("y", picture.y))):
        name = wide[number] if number < len(wide) else ""
        if text is not None:
            name = KEYS.get(text, (text, 1.0))[0]
        if name not in wide or name in chosen:
            found = f"{key} is {quoted(name)}, which does not vary or is the other axis"
            remedy = f"choose two of {', '.join(wide) or 'what varies, which is nothing'}"
            raise InputError(found, remedy, where)
        chosen.append(name)
    quantity = picture.quantity or "thrust"
    if quantity not in TEXTS:
        raise InputError(f"quantity is {quoted(quantity)}", f"known are {', '.join(TEXTS)}", where)
    at = {n: value for n in OPERATION if (value := getattr(picture, n)) is not None}
    for name in at:
        if name not in axes:
            found = f"{name} is not one of [points]"
            raise InputError(found, "leave it out, or give it there", where)
    return Surface(quantity, chosen[0], chosen[1], at)


# -------------------------------------------------------------------------------------------------
# A quadratic through a study's results, and how well it predicts designs that it has not seen.


@dataclass(frozen=True, eq=False)
class ResponseSurface:
    """A second-order polynomial of what varies.

    Attributes
    ----------
    names : tuple of str
        What varies.
    low, high : ndarray, shape (k,)
        Least and largest of each.
    coefficients : ndarray
        Coefficients of the terms in the order of ``_terms``.
    left_out_rms : float
        Root mean square error at designs left out of the fit one at a time, in the quantity's unit.
    """

    names: tuple[str, ...]
    low: Floats
    high: Floats
    coefficients: Floats
    left_out_rms: float

    def __call__(self, rows: Mapping[str, Floats]) -> Floats:
        """Values (n,) at designs; ``rows`` has values (n,) of each of ``names``."""
        return np.asarray(_terms(self._unit(rows)) @ self.coefficients)

    def middle(self) -> dict[str, float]:
        """The middle of the range of each of ``names``."""
        return dict(zip(self.names, (0.5 * (self.low + self.high)).tolist(), strict=True))

    def _unit(self, rows: Mapping[str, Floats]) -> Floats:
        """Scale what varies (n, k) to -1 to 1."""
        values = np.stack([np.asarray(rows[name], np.float64) for name in self.names], axis=1)
        return np.asarray(2.0 * (values - self.low) / (self.high - self.low) - 1.0)


def response_surface(rows: Mapping[str, Floats], values: Floats) -> ResponseSurface:
    """Fit a quadratic by least squares.

    Parameters
    ----------
    rows : mapping of str to ndarray, shape (n,)
        What varies.
    values : ndarray, shape (n,)
        The quantity; designs where it is NaN are left out.

    Raises
    ------
    InputError
        For fewer designs than the quadratic has coefficients.
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
        found += f", and {good.sum()} designs have values"
        raise InputError(found, "ask for more designs")
    # Where a variable has two levels its square says nothing; the least coefficients are taken.
    inverse = np.linalg.pinv(terms)
    coefficients = inverse @ values[good]
    # A residual over 1 - leverage is that of the fit without the point.
    leverage = np.minimum(np.einsum("ij,ji->i", terms, inverse), 1.0 - 1e-9)
    error = (values[good] - terms @ coefficients) / (1.0 - leverage)
    return ResponseSurface(names, low, high, coefficients, float(np.sqrt(np.mean(error**2))))


def _terms(unit: Floats) -> Floats:
    """1, each variable, and each product of two of them, (n, t)."""
    count, k = unit.shape
    products = [unit[:, i] * unit[:, j] for i in range(k) for j in range(i, k)]
    return np.column_stack([np.ones(count), unit, *products])
