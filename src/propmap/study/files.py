"""The file that says what a study varies, and the quadratic through its results."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from propmap.errors import InputError, quoted
from propmap.io.csv import read_lines
from propmap.io.toml import TomlTable, parse_toml
from propmap.rotor import Rotor
from propmap.study.run import OPERATION, Study
from propmap.sweep.points import TEXTS
from propmap.typing import Floats

# -------------------------------------------------------------------------------------------------
# Files that say what a study varies.

SCHEMA = 1
INCH = 0.0254

METHODS = ("latin-hypercube", "full-factorial")

KEYS = {
    "diameter_m": ("diameter", 1.0),
    "diameter_in": ("diameter", INCH),
    "pitch_m": ("pitch", 1.0),
    "pitch_in": ("pitch", INCH),
    **{name: (name, 1.0) for name in ("chord_scale", "twist_scale", "blades", *OPERATION)},
}
"""What may stand in a file, its name in ``VARIABLES`` and what to multiply it by."""


@dataclass(frozen=True)
class Surface:
    """The response surface to draw."""

    quantity: str  # of ``TEXTS``
    across: str  # of what varies
    up: str
    # Where on the axes of shared operating points, the nearest value of each; by default the first.
    at: dict[str, float]


@dataclass(frozen=True)
class StudyFile:
    """What a file asks for."""

    title: str
    # As the command line names the first design; an empty airfoil is that known of the propeller.
    propeller: str
    airfoil: str
    varied: dict[str, Floats]  # this and the next three as in ``Study``
    axes: dict[str, Floats]
    designs: int | None
    seed: int
    surface: Surface | None  # None where no two quantities vary

    @property
    def points(self) -> int:
        """Number of operating points of all designs together."""
        levels = [] if self.designs is not None else list(self.varied.values())
        shared = [values.size for values in (*levels, *self.axes.values())]
        return (self.designs or 1) * math.prod(shared)

    def study(self, rotor: Rotor) -> Study:
        """The study, of designs made from that of ``rotor``."""
        return Study(rotor, self.varied, self.axes, self.designs, self.seed)


def read_study(path: Path) -> StudyFile:
    """Read the file at ``path``; ``InputError`` names what is wrong in it."""
    where = str(path)
    fields = parse_toml("\n".join(read_lines(path, "study")), where, SCHEMA)
    known = ("schema", "title", "propeller", "sampling", "vary", "points", "picture")
    top = TomlTable(fields, where, known)
    begin = top.table("propeller", ("name", "airfoil"))
    sampling = top.table("sampling", ("method", "designs", "seed"))
    method = sampling.choice("method", METHODS)
    designs = None
    if method == METHODS[0]:
        designs = _whole(sampling, "designs", "200")
    elif "designs" in sampling:
        raise InputError(
            "designs is given, but a full factorial has all combinations",
            "remove it, or write more values",
            sampling.where,
        )
    varied = _values(top.table("vary", tuple(KEYS)))
    axes = _values(top.table("points", tuple(OPERATION)))
    return StudyFile(
        title=top.text("title", '"..."', f"study of {path.stem}"),
        propeller=begin.text("name", '"apc-8x6e"'),
        airfoil=begin.text("airfoil", '"paper-apc"', ""),
        varied=varied,
        axes=axes,
        designs=designs,
        seed=_whole(sampling, "seed", "1", 1),
        surface=_surface(top, varied, axes),
    )


def _values(table: TomlTable) -> dict[str, Floats]:
    found: dict[str, Floats] = {}
    for key, value in table.entries.items():
        name, unit = KEYS[key]
        if name in found:
            raise InputError(
                f"{name} is given twice", "give it in metres or in inches", table.where
            )
        values = table.numbers(key) if isinstance(value, list) else [table.number(key, "...")]
        found[name] = unit * np.asarray(values, np.float64)
    return found


def _whole(table: TomlTable, key: str, example: str, default: int | None = None) -> int:
    value = table.number(key, example, default)
    if value != int(value) or value < 0:
        raise InputError(f"{key} is {value:g}", f"write a whole number, as {example}", table.where)
    return int(value)


def _surface(top: TomlTable, varied: dict[str, Floats], axes: dict[str, Floats]) -> Surface | None:
    table = top.table("picture", ("quantity", "x", "y", *OPERATION))
    wide = [name for name, values in varied.items() if values.size > 1]
    if len(wide) < 2 and not table.entries:
        return None
    chosen: list[str] = []
    for key, number in (("x", 0), ("y", 1)):
        name = wide[number] if number < len(wide) else ""
        if key in table:
            text = table.text(key, '"diameter"')
            name = KEYS.get(text, (text, 1.0))[0]
        if name not in wide or name in chosen:
            raise InputError(
                f"{key} is {quoted(name)}, which does not vary or is the other axis",
                f"choose two of {', '.join(wide) or 'what varies, which is nothing'}",
                table.where,
            )
        chosen.append(name)
    quantity = table.text("quantity", '"power"', "thrust")
    if quantity not in TEXTS:
        raise InputError(
            f"quantity is {quoted(quantity)}", f"known are {', '.join(TEXTS)}", table.where
        )
    at = {}
    for name in OPERATION:
        if name in table:
            if name not in axes:
                raise InputError(
                    f"{name} is not one of [points]", "leave it out, or give it there", table.where
                )
            at[name] = table.number(name, "...")
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
        Of the terms in the order of ``_terms``.
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
    low, high = (
        np.array([edge(used[name]) for name in names], np.float64) for edge in (np.min, np.max)
    )
    unfitted = ResponseSurface(names, low, high, np.empty(0), np.nan)
    terms = _terms(unfitted._unit(used)) if names else np.ones((int(good.sum()), 1))
    count = terms.shape[1]
    if good.sum() <= count:
        raise InputError(
            f"a quadratic of {len(names)} variables has {count} coefficients, and {good.sum()} "
            "designs have values",
            "ask for more designs",
        )
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
