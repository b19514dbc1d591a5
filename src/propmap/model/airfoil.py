"""Section laws: lift and drag of a blade section from constants or tables, and their covariance."""

from __future__ import annotations

import functools
import json
import math
import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from propmap import __version__
from propmap.errors import InputError, located, refuse_other_toml
from propmap.model.corrections import agreed, as_texts
from propmap.model.envelope import Envelope
from propmap.model.propeller import monotone_cubics
from propmap.typing import ByValue, Floats

LAW_SCHEMA = 1
SETS = Path(__file__).parents[1] / "catalogue" / "airfoils"
LIFT_LAWS = ("blended", "plate", "simplified")
PLATE = 0.44
"""Constant p of sin(a)/(1 - p + p sin(a)), the normal force of a plate over its value across the
flow [-]: S. F. Hoerner, Fluid-Dynamic Drag, 1965, chapter III."""


class Constant(NamedTuple):
    """A constant of the section law, with its limits in ``Airfoil`` and its settings for fits."""

    unit: str
    meaning: str
    limits: tuple[float, float]
    fit: tuple[float, float, float, float] | None = None
    """Initial value (x0 of (18) if the paper has one), lower and upper bound of fits, and standard
    deviation over propellers; None for a constant that is not fitted."""
    population: str = ""
    """Axis on which propellers are normally distributed, "log" or "linear"; empty for a constant
    that is the same for all propellers."""
    filed_if_zero: bool = True
    """False for a term beyond the paper, which files omit if it is zero."""


CONSTANTS = {
    "c_l1": Constant(
        "1/rad", "lift slope in attached flow", (0.0, 20.0), (math.tau, 0.5, 12.0, 1.0), "log"
    ),
    "c_l2": Constant("-", "lift after stall", (0.0, 10.0), (2.0, 0.0, 6.0, 0.5), "log"),
    "c_d": Constant("-", "pressure drag", (0.0, 20.0), (0.0, 0.0, 10.0, 1.0), "log"),
    "alpha_0": Constant("rad", "stall angle", (0.02, 1.5), (0.47, 0.1, 0.9, 0.06), "log"),
    "zero_lift_angle": Constant(
        "rad", "zero-lift angle", (-0.5, 0.5), (0.0, -0.25, 0.15, 0.03), "linear"
    ),
    "c_d0": Constant("-", "constant drag", (0.0, 1.0), (0.01, 0.0, 0.2, 0.02), "log"),
    "c_p": Constant("-", "skin friction", (0.0, 10.0)),
    "sharpness": Constant("1/rad", "sharpness of stall, M", (5.0, 500.0)),
    "reynolds_camber": Constant(
        "rad", "change of the zero-lift angle with ln Re", (-0.2, 0.2), (0.0, -0.1, 0.1, 0.02),
        "linear", filed_if_zero=False,
    ),
    "reynolds_lift": Constant(
        "-", "power of Re in the slope of the attached lift", (-1.0, 1.0), (0.0, -0.3, 0.6, 0.1),
        "linear", filed_if_zero=False,
    ),
    "reynolds_drag": Constant(
        "-", "power of Re in the pressure drag of attached flow", (-1.5, 1.0),
        (0.0, -1.2, 0.4, 0.2), "linear", filed_if_zero=False,
    ),
    "drag_angle": Constant(
        "rad", "angle of least pressure drag, from the zero-lift angle", (-0.5, 0.5),
        (0.0, -0.2, 0.3, 0.03), "linear", filed_if_zero=False,
    ),
}  # fmt: skip
"""The constants of ``Airfoil`` by name, in the order of its fields."""

GROWING = "growing"  # the core's law with the two powers of Re, for rotors whose powers are not 0
GROWTHS = frozenset(("reynolds_lift", "reynolds_drag"))
PAPER_FOUR = ("c_l1", "c_l2", "c_d", "alpha_0")  # the constants that (18) identifies


class SectionLaw:
    """Base class of the section laws, from constants or from tables."""

    name: str
    corrections: tuple[str, ...] | None

    def core_law(self) -> dict[str, Any]:
        """Return the law in the form that the compiled core reads, by name."""
        raise NotImplementedError

    def coefficients(self, alpha: ArrayLike, reynolds: ArrayLike) -> tuple[Floats, Floats]:
        """Return lift and drag coefficients: eqs. (3) and (4), or interpolation in a table.

        Parameters
        ----------
        alpha : array_like, shape (...)
            Angle of attack from the chord line [rad].
        reynolds : array_like, shape (...)
            Reynolds number [-], broadcast with ``alpha``.  In an ``Airfoil`` it also replaces the
            Reynolds number of the rotation in the term of ``reynolds_camber``.  Outside its
            Reynolds numbers, a ``SectionTable`` uses the nearest row.

        Returns
        -------
        lift, drag : ndarray, shape (...)
            C_L and C_D [-].
        """
        from propmap import core

        at = np.broadcast_arrays(np.asarray(alpha, np.float64), np.asarray(reynolds, np.float64))
        flat = (np.ascontiguousarray(a.ravel()) for a in at)
        lift, drag = core.section_coefficients(self.core_law(), *flat)
        return lift.reshape(at[0].shape), drag.reshape(at[0].shape)

    def with_corrections(self, texts: Sequence[str]) -> Self:
        """Return the law with the corrections ``texts``.

        Corrections that the law already has must agree with ``texts``.
        """
        law: Any = self
        return replace(law, corrections=agreed(self.name, self.corrections, texts))


@dataclass(frozen=True)
class Airfoil(SectionLaw):
    """Constants of the blade-section law, eqs. (3) and (4).

    Attributes
    ----------
    c_l1 : float
        Slope of the attached lift [1/rad].
    c_l2 : float
        Amplitude of the separated lift [-].  For ``lift_law`` "simplified" it is c_l.  For "plate"
        it is the normal-force coefficient at 90 degrees from the angle of zero lift.
    c_d : float
        Amplitude of the pressure drag [-].
    alpha_0 : float
        Angle of attack at the middle of the stall blend [rad].
    zero_lift_angle : float
        Angle of attack of zero lift [rad], negative for ordinary camber, 0 in the paper.  Eqs. (3)
        and (4) are evaluated at alpha - zero_lift_angle.
    c_d0, c_p, sharpness : float
        The paper's constants c_d0 [-], c_p [-] and M [1/rad].
    reynolds_camber : float
        Change of the zero-lift angle per unit of ln(Re / 5e4) [rad], about -0.02 for small
        propellers, 0 in the paper.  Re = rho Omega y c / mu is the Reynolds number of the rotation,
        limited to 1e4 to 1.2e5.
    reynolds_lift, reynolds_drag : float
        Exponents [-] of Re / 5e4, with the same Re.  The power with ``reynolds_lift`` multiplies
        c_l1.  The power with ``reynolds_drag`` multiplies c_d and c_d0 in attached flow.  The
        exponents are about 0.12 and -0.35 for small propellers, and 0 in the paper.
    drag_angle : float
        Angle at which the pressure drag is least, measured from zero_lift_angle [rad]: c_d
        sin^2(alpha - zero_lift_angle - drag_angle) in (4).  About 0.07 for small propellers, 0 in
        the paper.
    lift_law : str
        "blended": eq. (3).  "plate": eq. (3) with the separated lift of a plate, whose normal force
        is sin(a)/(0.56 + 0.44 sin(a)) times its value at 90 degrees.  "simplified": footnote 1,
        C_L = c_l2 sin(a) cos(a).
    corrections : tuple of str or None
        Corrections with which the constants were fitted, as texts for ``propmap.correction``.  A
        ``Model`` with this airfoil applies them.  None if they are not known.
    name, source : str
        Name of the set, and source of its numbers.
    uncertainty : SectionUncertainty or None
        Covariance of the constants; None if it is not known.  Ignored in comparisons.

    Raises
    ------
    InputError
        For a constant that is not a number or out of its range.
    """

    c_l1: float
    c_l2: float
    c_d: float
    alpha_0: float
    zero_lift_angle: float = 0.0
    c_d0: float = 0.01
    c_p: float = 1.328
    sharpness: float = 50.0
    reynolds_camber: float = 0.0
    reynolds_lift: float = 0.0
    reynolds_drag: float = 0.0
    drag_angle: float = 0.0
    lift_law: str = "blended"
    name: str = "unnamed"
    source: str = ""
    corrections: tuple[str, ...] | None = None
    uncertainty: SectionUncertainty | None = field(default=None, compare=False, repr=False)

    parameters: ClassVar[tuple[str, ...]] = tuple(CONSTANTS)
    """Names of the parameters with derivatives of the loads."""

    def __post_init__(self) -> None:
        for constant, (unit, _, (low, high), *_) in CONSTANTS.items():
            value = getattr(self, constant)
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise InputError(f"{constant} is {value!r}: give a number [{unit}]")
            if not (math.isfinite(value) and low <= value <= high):
                hint = " (angles are in radians)" if unit == "rad" and abs(value) > high else ""
                raise InputError(
                    f"{constant} is {value}: it must lie between {low} and {high} [{unit}]{hint}"
                )
            object.__setattr__(self, constant, float(value))
        for text in ("name", "source"):
            if not isinstance(getattr(self, text), str):
                raise InputError(f"{text} is {getattr(self, text)!r}: it must be text")
        if self.lift_law not in LIFT_LAWS:
            raise InputError(f"lift_law is {self.lift_law!r}: it must be one of {LIFT_LAWS}")
        object.__setattr__(self, "corrections", as_texts(self.corrections))

    @property
    def has_attached_lift(self) -> bool:
        """Whether the law has attached lift; the law of footnote 1 has none."""
        return self.lift_law != "simplified" and self.c_l1 > 0.0

    def core_law(self) -> dict[str, Any]:
        """Return the law in the form that the compiled core reads: its numbers by name."""
        attached = 0.0 if self.lift_law == "simplified" else 1.0
        plate = 0.0 if self.lift_law != "plate" else PLATE
        numbers = {name: getattr(self, name) for name in self.parameters}
        kind = GROWING if any(numbers[name] for name in GROWTHS) else "blended"
        return {"kind": kind, "attached": attached, "plate": plate, **numbers}

    def with_parameters(self, **changes: Any) -> Airfoil:
        """Return a copy with ``changes`` by name.  The covariance, no longer valid, is left out."""
        return replace(self, **{"uncertainty": None, **changes})

    def to_toml(self) -> str:
        """Return the text of a parameter file with this set."""
        text = self._text(FILED)
        if self.uncertainty is None:
            return text
        import tomli_w

        return f"{text}\n{tomli_w.dumps({'uncertainty': self.uncertainty.as_dict()})}"

    def metadata(self) -> dict[str, Any]:
        """Return the constants by name."""
        return {name: getattr(self, name) for name in FILED if name != "corrections"}

    def fingerprint(self) -> str:
        """Return the SHA-256 hash of the parameter file without corrections."""
        import hashlib

        return hashlib.sha256(self._text([*self.metadata()]).encode()).hexdigest()

    def _text(self, names: Sequence[str]) -> str:
        """Return a parameter file with these fields, except terms beyond the paper that are 0."""
        lines = [f"schema = {LAW_SCHEMA}"]
        for name in names:
            value = getattr(self, name)
            needed = name not in CONSTANTS or CONSTANTS[name].filed_if_zero or value != 0.0
            if value is not None and needed:
                # JSON and TOML write strings alike, except for the character DEL.
                toml = json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
                lines.append(f"{name} = {toml}")
        return "\n".join(lines) + "\n"


FILED = tuple(f.name for f in fields(Airfoil) if f.name != "uncertainty")  # fields in files


def parameter_set(name_or_path: str | Path) -> Airfoil:
    """Return a named set of constants, such as "paper-apc", or a set from a TOML file."""
    text = str(name_or_path)
    if text.lower() in airfoil_names():
        return read_airfoil(SETS / f"{text.lower()}.toml")
    path = Path(text)
    if path.suffix == ".toml" or path.exists() or "/" in text:
        return read_airfoil(path)
    import difflib

    close = difflib.get_close_matches(text.lower(), airfoil_names(), n=2)
    known = ", ".join(close or airfoil_names())
    raise InputError(
        f"airfoil {text!r}: no such parameter set or file; known sets: {known}; "
        "or give the path of a .toml file or of a section table"
    )


def airfoil_names() -> list[str]:
    """Return the names of the bundled parameter sets."""
    return sorted(file.stem for file in SETS.glob("*.toml"))


def read_airfoil(path: Path, *, uncertainty: bool = True) -> Airfoil:
    """Read a parameter file, with the covariance from its fit if ``uncertainty``.

    Raise an ``InputError`` that names the file and the field.
    """
    with located(str(path)):
        try:
            table = tomllib.loads(path.read_bytes().decode("utf-8"))
        except FileNotFoundError:
            raise InputError("no such file", "give the path of an existing .toml file") from None
        except OSError as error:
            raise InputError(f"cannot be read ({error.strerror})", "give a .toml file") from None
        except UnicodeDecodeError:
            raise InputError("not a text file", "give a parameter set in TOML") from None
        # Besides TOMLDecodeError, a ValueError, tomllib raises a plain ValueError for numbers with
        # thousands of digits, and a RecursionError for deep nesting.
        except (ValueError, RecursionError) as error:
            remedy = "`propmap airfoils show paper-apc` prints an example"
            raise InputError(f"not valid TOML ({error})", remedy) from None
        schema = table.pop("schema", LAW_SCHEMA)
        if schema != LAW_SCHEMA:
            found = f"schema is {schema!r}, this version reads {LAW_SCHEMA}"
            raise InputError(found, "upgrade propmap")
        refuse_other_toml(table, (*FILED, "fit"), "parameter set", "")
        # Other tables belong to other programs, but an unknown top-level key is likely a typo.
        extra = sorted(k for k, v in table.items() if k not in FILED and not isinstance(v, dict))
        repeat = other_version(table.get("fit"))
        if extra:
            known_fields = f"known fields: {', '.join(sorted(FILED))}"
            raise InputError(f"unknown field {extra[0]!r}", repeat or known_fields)
        required = [name for name in PAPER_FOUR if name not in table]
        if required == ["c_l1"] and table.get("lift_law") == "simplified":
            table["c_l1"], required = 0.0, []
        if required:
            remedy = repeat or f"add a line '{required[0]} = ...'"
            raise InputError(f"{required[0]} is missing", remedy)
        fit = table.get("fit") if uncertainty else None
        known = fitted_uncertainty(fit, (*CONSTANTS, "mount_area", "untwist"))
        known = known or filed_uncertainty(table.get("uncertainty"))
        return Airfoil(**{k: v for k, v in table.items() if k in FILED}, uncertainty=known)


LARGEST = 10.0  # coefficients above this limit indicate an error of the file [-]
CLOSEST = 0.999 * math.radians(0.01)  # smallest allowed difference of two angles [rad]

SectionFunction = Callable[[Floats, Floats], tuple[ArrayLike, ArrayLike]]
"""Function that returns C_L and C_D (N,) at angles of attack [rad] and Reynolds numbers (N,)."""

MOST_ANGLES = 4000  # largest number of angles at which a function is sampled


@dataclass(frozen=True, eq=False, repr=False)
class SectionTable(ByValue, SectionLaw):
    """C_L and C_D of a blade section from -180 to 180 degrees, for one or more Reynolds numbers.

    Attributes
    ----------
    angle : ndarray, shape (K,)
        Angle of attack from the chord line [rad], increasing from -pi to pi.
    reynolds : ndarray, shape (R,)
        Reynolds numbers, increasing.
    lift, drag : ndarray, shape (R, K)
        C_L and C_D [-], equal at -pi and pi.
    corrections : tuple of str or None
        Corrections that a ``Model`` with this table applies, as texts for ``propmap.correction``;
        None if they are not known.
    name, source : str
        Name of the table, and source of its numbers.
    sampling_error : float
        Largest difference of C_L or C_D found between the table and the function from which it was
        sampled [-]; 0 for a table that was not sampled.

    Raises
    ------
    InputError
        For arrays of inconsistent shapes, or values that no section has.
    """

    angle: Floats
    reynolds: Floats
    lift: Floats
    drag: Floats
    name: str = "unnamed"
    source: str = ""
    corrections: tuple[str, ...] | None = None
    sampling_error: float = field(default=0.0, compare=False)

    parameters: ClassVar[tuple[str, ...]] = ("zero_lift_angle",)
    """Names of the parameters with derivatives of the loads."""

    def __post_init__(self) -> None:
        for array in ("angle", "reynolds", "lift", "drag"):
            values = np.array(getattr(self, array), dtype=np.float64)
            if not np.isfinite(values).all():
                raise InputError(f"{array} has a value that is not finite: remove it")
            values.flags.writeable = False
            object.__setattr__(self, array, values)
        shape = (self.reynolds.size, self.angle.size)
        if self.lift.shape != shape or self.drag.shape != shape:
            remedy = f"give a row of {shape[1]} angles for each of {shape[0]} Reynolds numbers"
            found = f"lift has shape {self.lift.shape} and drag {self.drag.shape}"
            raise InputError(found, remedy)
        object.__setattr__(self, "corrections", as_texts(self.corrections))
        self._check_axes()
        self._check_figures()

    def _check_axes(self) -> None:
        if self.angle.size < 8 or not (np.diff(self.angle) > 0.0).all():
            raise InputError("the table needs at least eight angles that increase: sort its rows")
        ends = self.angle[[0, -1]]
        if not np.allclose(ends, [-math.pi, math.pi], atol=1e-6):
            low, high = np.degrees(ends).round(2).tolist()
            found = f"angles run from {low} to {high} deg, expected -180 to 180"
            raise InputError(found, "extend the table, for example by Viterna's method")
        if np.diff(self.angle).min() < CLOSEST:
            raise InputError("two angles are less than 0.01 deg apart: remove one of them")
        object.__setattr__(self, "angle", np.array([-math.pi, *self.angle[1:-1], math.pi]))
        if not (self.reynolds > 0.0).all() or not (np.diff(self.reynolds) > 0.0).all():
            raise InputError("Reynolds numbers must be positive and increase: sort the table")

    def _check_figures(self) -> None:
        for name, values in (("lift", self.lift), ("drag", self.drag)):
            worst = float(np.abs(values).max())
            if worst > LARGEST:
                found = f"{name} coefficient of {worst:g}, expected at most {LARGEST:g}"
                raise InputError(found, "check the table's columns")
            gap = np.abs(values[:, 0] - values[:, -1]).max()
            if gap > 1e-6:
                found = f"{name} differs by {gap:g} between -180 and 180 deg, the same angle"
                raise InputError(found, "give both angles the same coefficient")
        if (self.drag < 0.0).any():
            raise InputError("a drag coefficient is negative: check the table's columns")
        if not abs(self._zero_lift_angle()) < math.radians(30.0):
            found = "the lift does not rise through zero between -30 and 30 deg"
            raise InputError(found, "give angles from the chord line, positive nose up")

    def _zero_lift_angle(self) -> float:
        """Return the angle nearest to zero at which lift rises through zero [rad]; else inf."""
        lift, rise = self.lift[self.reynolds.size // 2], np.diff(self.angle)
        k = np.flatnonzero((lift[:-1] <= 0.0) & (lift[1:] > 0.0))
        zeros = self.angle[k] - lift[k] / (lift[k + 1] - lift[k]) * rise[k]
        return float(min(zeros, key=abs, default=math.inf))

    @classmethod
    def from_function(
        cls,
        function: SectionFunction,
        reynolds: ArrayLike,
        *,
        tolerance: float = 1e-3,
        name: str = "unnamed",
        source: str = "",
    ) -> SectionTable:
        """Return a table sampled from your own section law, for use in a rotor.

        Angles halfway between neighbors are added until the table agrees with the function within
        the tolerance.  The rotor uses only the table.

        Parameters
        ----------
        function : callable
            ``function(alpha, reynolds)`` returns C_L and C_D (N,) for angles of attack from the
            chord line [rad], between -pi and pi, and Reynolds numbers, both (N,).
        reynolds : array_like, shape (R,)
            Reynolds numbers of the table, increasing.
        tolerance : float
            Largest allowed difference of C_L and C_D at these Reynolds numbers [-].
        name, source : str
            As in ``SectionTable``.

        Returns
        -------
        SectionTable
            The table.  Its ``sampling_error`` includes errors between two Reynolds numbers.

        Raises
        ------
        InputError
            For a function that does not return two arrays of N finite numbers.  For a tolerance
            that 4000 angles do not reach, for example at a jump.  As in ``SectionTable``.
        """
        rows = np.atleast_1d(np.asarray(reynolds, np.float64))

        def sampled(alpha: Floats, at: Floats) -> Floats:
            """Return C_L and C_D (2, R, K)."""
            every = np.broadcast_arrays(alpha[None, :], at[:, None])
            found = function(*(np.ravel(a) for a in every))
            try:
                both = np.asarray(np.stack([np.asarray(c, np.float64) for c in found]))
                return both.reshape(2, at.size, alpha.size)
            except (TypeError, ValueError):
                seen = f"the section law returns {found!r:.80} for {alpha.size * at.size} angles"
                remedy = "return C_L and C_D as two arrays with one number per angle"
                raise InputError(seen, remedy) from None

        def made(alpha: Floats, error: float = 0.0) -> SectionTable:
            lift, drag = sampled(alpha, rows)
            # -pi and pi are the same angle.
            lift[:, -1], drag[:, -1] = lift[:, 0], drag[:, 0]
            return cls(alpha, rows, lift, drag, name=name, source=source, sampling_error=error)

        def errors(table: SectionTable, alpha: Floats, at: Floats) -> Floats:
            got = np.stack(table.coefficients(alpha[None, :], at[:, None]))
            return np.asarray(np.abs(got - sampled(alpha, at)).max(axis=(0, 1)))

        near = np.radians(np.arange(-40.0, 40.5, 1.0))
        far = np.radians(np.arange(-180.0, 181.0, 5.0))
        alpha = np.unique(np.concatenate([far[np.abs(far) > near[-1]], near]))
        while True:
            table, middle = made(alpha), 0.5 * (alpha[:-1] + alpha[1:])
            error = errors(table, middle, rows)
            wide = np.diff(alpha) > 2.0 * CLOSEST
            more = middle[(error > tolerance) & wide]
            if not more.size or alpha.size + more.size > MOST_ANGLES:
                break
            alpha = np.unique(np.concatenate([alpha, more]))
        if not error.max() <= tolerance:
            worst = math.degrees(middle[int(np.argmax(error))])
            found = f"a table of {alpha.size} angles differs from the section law by "
            found += f"{error.max():.2g} at {worst:.2f} deg, expected at most {tolerance:g}"
            raise InputError(found, "make the law continuous there, or give a larger tolerance")
        between = np.sqrt(rows[:-1] * rows[1:])
        whole = max(error.max(), 0.0 if between.size == 0 else errors(table, alpha, between).max())
        return replace(table, sampling_error=float(whole))

    def core_law(self) -> dict[str, Any]:
        """Return the law in the form that the compiled core reads: numbers and arrays by name."""
        return dict(_core_table(self))

    def metadata(self) -> dict[str, Any]:
        """Return name, source and Reynolds numbers, without the coefficients."""
        return {"name": self.name, "source": self.source, "reynolds": self.reynolds.tolist()}

    def fingerprint(self) -> str:
        """Return the SHA-256 hash of the arrays as little-endian f8."""
        import hashlib

        arrays = (self.angle, self.reynolds, self.lift, self.drag)
        flat = np.concatenate([a.ravel() for a in arrays])
        return hashlib.sha256(flat.astype("<f8").tobytes()).hexdigest()

    def __repr__(self) -> str:
        return (
            f"SectionTable({self.name!r}, {self.angle.size} angles, "
            f"Re {self.reynolds[0]:.3g} to {self.reynolds[-1]:.3g})"
        )


@functools.lru_cache(maxsize=16)
def _core_table(table: SectionTable) -> dict[str, Any]:
    """Return a ``table`` as the numbers and arrays of ``SectionTable`` in the core."""
    zero, log_re = table._zero_lift_angle(), np.log(table.reynolds)
    turned = np.remainder(table.angle[:-1] - zero + math.pi, math.tau) - math.pi
    # The angle opposite to zero lift is a knot.  Rounding must not add a second one next to it.
    inside = np.flatnonzero(np.abs(turned) < math.pi - 1e-9)
    inside = inside[np.argsort(turned[inside])]
    knots = np.concatenate([[-math.pi], turned[inside], [math.pi]])
    opposite = np.remainder(zero + math.tau, math.tau) - math.pi
    both = np.stack([table.lift, table.drag])
    ends = np.array([[[np.interp(opposite, table.angle, row)] for row in rows] for rows in both])
    both = np.concatenate([ends, both[..., inside], ends], axis=-1)
    # Derivatives with respect to ln(Re) are zero at the lowest and the highest Reynolds number.
    by_log_re = np.zeros_like(both)
    if log_re.size > 2:
        slopes = monotone_cubics(log_re, np.swapaxes(both, 1, 2))[..., 1:, 1]
        by_log_re[:, 1:-1] = np.swapaxes(slopes, 1, 2)
    cubics = monotone_cubics(knots, np.stack([both, by_log_re], axis=1))
    rows = np.moveaxis(cubics.reshape(4, log_re.size, -1, 4), 0, 2)
    steps = np.linspace(-math.pi, math.pi, 4 * knots.size, endpoint=False)
    # Stall is the first peak of lift on either side of zero lift; the largest peak may be the one
    # near 45 deg.  Flow is attached at all Reynolds numbers up to the angle ``attached``, where
    # lift reaches 0.9 of its value at stall.
    after, last = int(np.searchsorted(knots, 0.0)), knots.size - 1
    stall, attached = [], math.pi
    for lift in both[0].tolist():
        ups = (k for k in range(after, last) if lift[k] > max(lift[k + 1], 0.0))
        downs = (k for k in range(after - 1, 0, -1) if lift[k] < min(lift[k - 1], 0.0))
        up = next(ups, last)
        stall.append(knots[[up, next(downs, 0)]])
        k = next((k for k in range(after, up) if lift[k] >= 0.9 * lift[up]), up)
        near = slice(k - 1 if k > after else k, k + 1)
        attached = min(attached, np.interp(0.9 * lift[up], lift[near], knots[near]))
    attached = max(attached, CLOSEST)
    slope = np.mean([np.interp(attached, knots, row) for row in both[0]]) / attached
    stall_up, stall_down = np.ascontiguousarray(np.transpose(stall))
    return {
        "kind": "tabulated",
        "zero_lift_angle": zero,
        "knots": knots,
        "first": np.searchsorted(knots, steps, side="right") - 1,
        "rows": rows.ravel(),
        "log_re": log_re,
        "stall_up": stall_up,
        "stall_down": stall_down,
        "attached_slope": float(slope),
    }


# --- Covariance of the section constants, and the errors that remain with the best constants -----

DISCREPANCIES = ("thrust_coefficient", "power_coefficient")  # coefficients of an axial test


@dataclass(frozen=True, eq=False)
class SectionUncertainty:
    """Uncertainty of a set of section constants.

    Attributes
    ----------
    covariance : SectionCovariance
        Covariance of the constants.  For a blade that was not measured, it includes the uncertainty
        of chord and twist, as changes of the constants with the same effect on the loads.
    thrust_coefficient, power_coefficient : float
        Standard deviations of the errors of C_T and C_P that remain with the best constants [-].
    another_tunnel : bool
        Whether the constants were measured in a tunnel that differs from the tunnel or flight of
        interest.  If so, the bands include the differences between tunnels, see ``propmap.bands``.
    with_blade : SectionCovariance or None
        Covariance that the constants would have with a measured blade; None if it was measured.
    envelope : Envelope or None
        Range of the operating points of the fit; None if it is not known.

    Raises
    ------
    InputError
        For a standard deviation that is negative or not a number.
    """

    covariance: SectionCovariance
    thrust_coefficient: float = 0.0
    power_coefficient: float = 0.0
    another_tunnel: bool = True
    with_blade: SectionCovariance | None = None
    envelope: Envelope | None = None

    def __post_init__(self) -> None:
        for name in DISCREPANCIES:
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(f"{name} is {value}", "give a standard deviation, 0 or more")
        if self.with_blade is not None and self.with_blade.names != self.covariance.names:
            found = f"the constants are {self.with_blade.names} and {self.covariance.names}"
            raise InputError(found, "give both covariances for the same constants")

    def without(self, name: str) -> SectionUncertainty:
        """Return the uncertainty if the constant ``name`` is known exactly."""
        names = [each for each in self.covariance.names if each != name]
        kept = self.covariance.of(names)
        blade = None if self.with_blade is None else self.with_blade.of(names)
        return replace(self, covariance=kept, with_blade=blade)

    def as_dict(self) -> dict[str, Any]:
        """Return plain data that ``filed_uncertainty`` reads."""
        return {
            "names": list(self.covariance.names),
            "covariance": self.covariance.matrix.tolist(),
            **{name: getattr(self, name) for name in DISCREPANCIES},
            "another_tunnel": self.another_tunnel,
            **({} if self.with_blade is None else {"with_blade": self.with_blade.matrix.tolist()}),
        }


def filed_uncertainty(table: Any) -> SectionUncertainty | None:
    """Return the uncertainty from a table ``[uncertainty]`` by ``SectionUncertainty.as_dict``."""
    if table is None:
        return None
    try:
        names, other = tuple(map(str, table["names"])), bool(table["another_tunnel"])
        _ = table["covariance"]
        matrices: Any = {
            key: SectionCovariance(names, np.array(table[key], np.float64))
            for key in ("covariance", "with_blade")
            if key in table
        }
        left: Any = {name: float(table[name]) for name in DISCREPANCIES}
    except (KeyError, TypeError, ValueError) as error:
        found = f"the table [uncertainty] is damaged ({error})"
        raise InputError(found, "remove the table, or write the file again") from None
    return SectionUncertainty(**matrices, **left, another_tunnel=other)


def fitted_uncertainty(table: Any, names: Collection[str]) -> SectionUncertainty | None:
    """Return the uncertainty of the free parameters ``names`` from the table ``[fit]`` of a fit."""
    if not isinstance(table, Mapping):
        return None
    try:
        free, left = table["free"], table.get("discrepancy", {})
        matrix = np.array(table["covariance"], np.float64).reshape(len(free), len(free))
        every = SectionCovariance(tuple(free), matrix)
        kept = [name for name in free if name in names]
        shares: Any = {name: float(left[name]) for name in DISCREPANCIES if name in left}
        ends: Any = {name: tuple(map(float, v)) for name, v in table.get("envelope", {}).items()}
        covered = Envelope(**ends) if ends else None
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        found = f"the table [fit] cannot be read: covariance or envelope ({error})"
        raise InputError(found, other_version(table) or "run `propmap fit` again") from None
    kept_of = every.of(kept)
    return SectionUncertainty(kept_of, **shares, another_tunnel=False, envelope=covered)


def other_version(fit: Any) -> str:
    """Return the remedy if another version of propmap wrote the table ``fit``; "" otherwise."""
    version = fit.get("propmap") if isinstance(fit, Mapping) else None
    if not isinstance(version, str) or version == __version__:
        return ""
    written = f"the file was written by propmap {version} (this is {__version__})"
    return f"{written}: run `propmap fit` again"


LARGEST_VARIANCE = 1e30  # larger variances make the standard deviations of loads overflow


@dataclass(frozen=True, eq=False)
class SectionCovariance:
    """Covariance of P parameters of ``Airfoil``.

    Attributes
    ----------
    names : tuple of str
        Names of the parameters.
    matrix : ndarray, shape (P, P)
        Covariance in the units of the parameters.  The variance of a parameter that the data do not
        determine is infinite.

    Raises
    ------
    InputError
        For a matrix of another shape, or one that is not a covariance.
    """

    names: tuple[str, ...]
    matrix: Floats

    def __post_init__(self) -> None:
        count = len(self.names)
        if self.matrix.shape != (count, count):
            found = f"the covariance of {count} parameters has shape {self.matrix.shape}"
            raise InputError(found, f"give {count} rows of {count} numbers")
        for name, variance in zip(self.names, np.diag(self.matrix).tolist(), strict=True):
            if not variance >= 0.0:
                found = f"the variance of {name} is {variance}"
                raise InputError(found, "give 0 or more, or infinity for an unknown parameter")
        known = self.determined.matrix if self.unknown else self.matrix
        if not known.size:
            return
        if not np.isfinite(known).all() or np.linalg.eigvalsh(known)[0] < -1e-6 * known.max():
            raise InputError("the covariance has a negative variance", "fit again")
        if np.abs(known).max() > LARGEST_VARIANCE:
            raise InputError(f"a variance is {np.abs(known).max():.3g}", "fit again")
        if not np.allclose(known, known.T, rtol=1e-6, atol=1e-9 * np.abs(known).max()):
            raise InputError("the covariance is not symmetric", "fit again")

    @property
    def unknown(self) -> tuple[str, ...]:
        """Names of the parameters with infinite variance."""
        variances = np.diag(self.matrix)
        return tuple(n for n, v in zip(self.names, variances, strict=True) if not np.isfinite(v))

    @property
    def determined(self) -> SectionCovariance:
        """Covariance of the parameters with finite variance."""
        return self.of([name for name in self.names if name not in self.unknown])

    def of(self, names: list[str]) -> SectionCovariance:
        """Return the covariance of the parameters ``names``."""
        kept = [self.names.index(name) for name in names]
        return SectionCovariance(tuple(names), self.matrix[np.ix_(kept, kept)])

    def as_dict(self) -> dict[str, Any]:
        """Return plain data, with None for infinite values."""
        rows = [[v if np.isfinite(v) else None for v in row] for row in self.matrix.tolist()]
        return {"names": list(self.names), "matrix": rows}
