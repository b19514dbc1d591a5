"""The section law: constants or tables, how uncertain they are, and its coefficients."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from propmap.errors import InputError, located
from propmap.model.corrections import agreed, as_texts
from propmap.model.envelope import Envelope
from propmap.typing import ByValue, Floats

LAW_SCHEMA = 1
SETS = Path(__file__).parents[1] / "catalogue" / "airfoils"
LIFT_LAWS = ("blended", "plate", "simplified")
PLATE = 0.44
"""p in sin(a)/(1 - p + p sin(a)), a plate's normal force over that across the flow [-]: S. F.
Hoerner, Fluid-Dynamic Drag, 1965, chapter III."""


class Constant(NamedTuple):
    """A constant of the section law: what ``Airfoil`` accepts, and how fits treat it."""

    unit: str
    meaning: str
    limits: tuple[float, float]
    fit: tuple[float, float, float, float] | None = None
    """First guess (x0 of (18) where the paper has one), lower and upper bound of fits, and by how
    much propellers differ; None where it is not fitted."""
    population: str = ""
    """How its distribution over propellers is normal, "log" or "linear"; empty where it is held."""
    filed_if_zero: bool = True
    """False for a term beyond the paper, which files leave out where it does not act."""


CONSTANTS = {
    "c_l1": Constant(
        "1/rad", "slope of the attached lift", (0.0, 20.0), (math.tau, 0.5, 12.0, 1.0), "log"
    ),
    "c_l2": Constant("-", "lift after stall", (0.0, 10.0), (2.0, 0.0, 6.0, 0.5), "log"),
    "c_d": Constant("-", "pressure drag", (0.0, 20.0), (0.0, 0.0, 10.0, 1.0), "log"),
    "alpha_0": Constant("rad", "angle of stall", (0.02, 1.5), (0.47, 0.1, 0.9, 0.06), "log"),
    "zero_lift_angle": Constant(
        "rad", "angle of zero lift", (-0.5, 0.5), (0.0, -0.25, 0.15, 0.03), "linear"
    ),
    "c_d0": Constant("-", "constant drag", (0.0, 1.0), (0.01, 0.0, 0.2, 0.02), "log"),
    "c_p": Constant("-", "skin friction", (0.0, 10.0)),
    "sharpness": Constant("1/rad", "sharpness of stall, M", (5.0, 500.0)),
    "reynolds_camber": Constant(
        "rad", "growth of the angle of zero lift with ln Re", (-0.2, 0.2), (0.0, -0.1, 0.1, 0.02),
        "linear", filed_if_zero=False,
    ),
    "drag_angle": Constant(
        "rad", "angle of least pressure drag above that of zero lift", (-0.5, 0.5),
        (0.0, -0.2, 0.3, 0.03), "linear", filed_if_zero=False,
    ),
}  # fmt: skip
"""The constants of ``Airfoil`` by name, in the order of its fields: the one table of them."""

PAPER_FOUR = ("c_l1", "c_l2", "c_d", "alpha_0")  # what (18) identifies


class SectionLaw:
    """What constants and tables of a blade section have in common."""

    name: str
    corrections: tuple[str, ...] | None

    def core_law(self) -> dict[str, Any]:
        """Give the law as the compiled core takes it, by name."""
        raise NotImplementedError

    def coefficients(self, alpha: ArrayLike, reynolds: ArrayLike) -> tuple[Floats, Floats]:
        """Lift and drag of the section by itself: eqs. (3) and (4), or between a table's figures.

        Parameters
        ----------
        alpha : array_like, shape (...)
            Angle of attack from the chord line [rad].
        reynolds : array_like, shape (...)
            Re [-], of constants also that of the rotation alone; outside a table's Reynolds numbers
            that of the nearest row holds.  Both broadcast.

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
        """Set the corrections to use it with, by their ``texts``, which must be its own if any."""
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
        Amplitude of the separated lift [-]; c_l where ``lift_law`` is "simplified", the normal
        force of the section across the flow where it is "plate".
    c_d : float
        Amplitude of the pressure drag [-].
    alpha_0 : float
        Angle of attack at the middle of the stall blend [rad].
    zero_lift_angle : float
        Angle of attack of zero lift [rad], negative for ordinary camber.  The paper's law has
        none; (3) and (4) are evaluated at alpha - zero_lift_angle.
    c_d0, c_p, sharpness : float
        The paper's constants c_d0 [-], c_p [-] and M [1/rad].
    reynolds_camber : float
        Growth of the zero-lift angle by ln(Re / 5e4) [rad], Re = rho Omega y c / mu of the rotation
        alone, from 1e4 to 1.2e5; about -0.02 for small propellers, 0 in the paper.
    drag_angle : float
        How far above zero_lift_angle the pressure drag is least [rad]: c_d sin^2(alpha -
        zero_lift_angle - drag_angle) in (4).  About 0.07 for small propellers, 0 in the paper.
    lift_law : str
        "blended", eq. (3); "plate", which is (3) with the separated lift of a plate, whose normal
        force is sin(a)/(0.56 + 0.44 sin(a)) of that across the flow; or "simplified", footnote 1:
        C_L = c_l2 sin(a) cos(a).
    corrections : tuple of str or None
        Corrections with which the constants were found, as ``propmap.correction`` reads them.  A
        ``Model`` with this airfoil has them too.  None where nothing is said of them.
    name, source : str
        What the set is called and where its numbers come from.
    uncertainty : SectionUncertainty or None
        How well the constants are known; None where nothing is said of it.  Not compared.

    Raises
    ------
    InputError
        Where a constant is not a number or out of its range.
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
    drag_angle: float = 0.0
    lift_law: str = "blended"
    name: str = "unnamed"
    source: str = ""
    corrections: tuple[str, ...] | None = None
    uncertainty: SectionUncertainty | None = field(default=None, compare=False, repr=False)

    parameters: ClassVar[tuple[str, ...]] = tuple(CONSTANTS)
    """Names of what loads can be differentiated by."""

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
        """Whether lift rises with the angle of attack up to stall: not by footnote 1."""
        return self.lift_law != "simplified" and self.c_l1 > 0.0

    def core_law(self) -> dict[str, Any]:
        """Give the law as the compiled core takes it: its numbers by name."""
        attached = 0.0 if self.lift_law == "simplified" else 1.0
        plate = PLATE if self.lift_law == "plate" else 0.0
        numbers = {name: getattr(self, name) for name in self.parameters}
        return {"kind": "blended", "attached": attached, "plate": plate, **numbers}

    def with_parameters(self, **changes: Any) -> Airfoil:
        """Copy it with ``changes`` by name; its uncertainty no longer holds and is left out."""
        return replace(self, **{"uncertainty": None, **changes})

    def to_toml(self) -> str:
        """Write the set as the text of a parameter file."""
        text = self._text(FILED)
        if self.uncertainty is None:
            return text
        import tomli_w

        return f"{text}\n{tomli_w.dumps({'uncertainty': self.uncertainty.as_dict()})}"

    def metadata(self) -> dict[str, Any]:
        """Give the constants by name."""
        return {name: getattr(self, name) for name in FILED if name != "corrections"}

    def fingerprint(self) -> str:
        """Hash the parameter file, without its corrections, by SHA-256."""
        import hashlib

        return hashlib.sha256(self._text([*self.metadata()]).encode()).hexdigest()

    def _text(self, names: Sequence[str]) -> str:
        """Write these fields as a parameter file; terms beyond the paper only where they act."""
        lines = [f"schema = {LAW_SCHEMA}"]
        for name in names:
            value = getattr(self, name)
            needed = name not in CONSTANTS or CONSTANTS[name].filed_if_zero or value != 0.0
            if value is not None and needed:
                # JSON's strings are TOML's; only DEL differs.
                toml = json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
                lines.append(f"{name} = {toml}")
        return "\n".join(lines) + "\n"


FILED = tuple(f.name for f in fields(Airfoil) if f.name != "uncertainty")  # in files


def parameter_set(name_or_path: str | Path) -> Airfoil:
    """Load a named set of constants, such as "paper-apc", or read one from a TOML file."""
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
    """List the names of the bundled parameter sets."""
    return sorted(file.stem for file in SETS.glob("*.toml"))


def read_airfoil(path: Path, *, uncertainty: bool = True) -> Airfoil:
    """Read a parameter file, with what a fit says of the constants if ``uncertainty``;
    ``InputError`` names the file and the field."""
    with located(str(path)):
        try:
            table = tomllib.loads(path.read_bytes().decode("utf-8"))
        except FileNotFoundError:
            raise InputError("no such file", "give a set's name or an existing .toml") from None
        except OSError as error:
            raise InputError(f"cannot be read ({error.strerror})", "give a .toml file") from None
        except UnicodeDecodeError:
            raise InputError("not a text file", "give a parameter set in TOML") from None
        # A number of thousands of digits is a plain ValueError, deep nesting a RecursionError.
        except (ValueError, RecursionError) as error:
            remedy = "`propmap airfoils show paper-apc` prints an example"
            raise InputError(f"not valid TOML ({error})", remedy) from None
        schema = table.pop("schema", LAW_SCHEMA)
        if schema != LAW_SCHEMA:
            found = f"schema is {schema!r}, this version reads {LAW_SCHEMA}"
            raise InputError(found, "upgrade propmap")
        # A table is left to whoever wrote it; a stray key at the top is likely a typing error.
        extra = sorted(k for k, v in table.items() if k not in FILED and not isinstance(v, dict))
        if extra:
            known_fields = f"known fields: {', '.join(sorted(FILED))}"
            raise InputError(f"unknown field {extra[0]!r}", known_fields)
        required = [name for name in PAPER_FOUR if name not in table]
        if required == ["c_l1"] and table.get("lift_law") == "simplified":
            table["c_l1"], required = 0.0, []
        if required:
            raise InputError(f"{required[0]} is missing", f"add a line '{required[0]} = ...'")
        fit = table.get("fit") if uncertainty else None
        known = fitted_uncertainty(fit, (*CONSTANTS, "mount_area", "untwist"))
        known = known or filed_uncertainty(table.get("uncertainty"))
        return Airfoil(**{k: v for k, v in table.items() if k in FILED}, uncertainty=known)


LARGEST = 10.0  # coefficients beyond are taken for an error of the file [-]
CLOSEST = 0.999 * math.radians(0.01)  # least distance of two angles [rad]

SectionFunction = Callable[[Floats, Floats], tuple[ArrayLike, ArrayLike]]
"""Gives C_L and C_D (N,) at angles of attack [rad] and Reynolds numbers (N,)."""

MOST_ANGLES = 4000  # angles at which a function is sampled, at most


@dataclass(frozen=True, eq=False, repr=False)
class SectionTable(ByValue, SectionLaw):
    """C_L and C_D of a blade section, all the way round, at one or more Reynolds numbers.

    Attributes
    ----------
    angle : ndarray, shape (K,)
        Angle of attack from the chord line [rad], rising from -pi to pi.
    reynolds : ndarray, shape (R,)
        Reynolds numbers, rising.
    lift, drag : ndarray, shape (R, K)
        C_L and C_D [-], the same at -pi and pi.
    corrections : tuple of str or None
        Corrections that a ``Model`` with this table has, as ``propmap.correction`` reads them; None
        where nothing is said of them.
    name, source : str
        What the table is called and where its numbers come from.
    sampling_error : float
        Largest difference of C_L or C_D seen between the table and the function that it was sampled
        from [-]; 0 for a table that was not.

    Raises
    ------
    InputError
        Where the arrays do not fit together or hold no section's figures.
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
    """Names of what loads can be differentiated by."""

    def __post_init__(self) -> None:
        for array in ("angle", "reynolds", "lift", "drag"):
            values = np.array(getattr(self, array), dtype=np.float64)
            if not np.isfinite(values).all():
                raise InputError(f"{array} holds a value that is not finite: remove it")
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
            raise InputError("angles must rise, and be eight at least: sort the table")
        ends = self.angle[[0, -1]]
        if not np.allclose(ends, [-math.pi, math.pi], atol=1e-6):
            low, high = np.degrees(ends).round(2).tolist()
            found = f"angles run from {low} to {high} deg, expected -180 to 180"
            raise InputError(found, "extend the table, for instance by Viterna's method")
        if np.diff(self.angle).min() < CLOSEST:
            raise InputError("two angles are less than 0.01 deg apart: remove one of them")
        object.__setattr__(self, "angle", np.array([-math.pi, *self.angle[1:-1], math.pi]))
        if not (self.reynolds > 0.0).all() or not (np.diff(self.reynolds) > 0.0).all():
            raise InputError("Reynolds numbers must be positive and rise: sort the table")

    def _check_figures(self) -> None:
        for name, values in (("lift", self.lift), ("drag", self.drag)):
            worst = float(np.abs(values).max())
            if worst > LARGEST:
                found = f"{name} coefficient of {worst:g}, expected at most {LARGEST:g}"
                raise InputError(found, "check the table's columns")
            gap = np.abs(values[:, 0] - values[:, -1]).max()
            if gap > 1e-6:
                found = f"{name} differs by {gap:g} between -180 and 180 deg, which are one angle"
                raise InputError(found, "make them equal")
        if (self.drag < 0.0).any():
            raise InputError("a drag coefficient is negative: check the table's columns")
        middle = self.lift[self.reynolds.size // 2]
        near = np.abs(self.angle) < math.radians(30.0)
        if not (middle[near].min() < 0.0 < middle[near].max()):
            found = "lift does not pass zero between -30 and 30 deg"
            raise InputError(found, "give angles from the chord line, positive nose up")

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
        """Sample a section law of your own, so that a rotor can have it.

        Angles are added half-way between others until the table is as close to the function as is
        asked for.  The function is not called again afterwards.

        Parameters
        ----------
        function : callable
            ``function(alpha, reynolds)`` gives C_L and C_D (N,) at angles of attack from the chord
            line [rad], between -pi and pi, and Reynolds numbers, both (N,).
        reynolds : array_like, shape (R,)
            Reynolds numbers of the table, rising.
        tolerance : float
            Largest difference of C_L and C_D wanted at these Reynolds numbers [-].
        name, source : str
            As in ``SectionTable``.

        Returns
        -------
        SectionTable
            With ``sampling_error``, which counts what lies between two Reynolds numbers too.

        Raises
        ------
        InputError
            For a function that does not give two arrays of N finite numbers, a tolerance that 4000
            angles do not reach, as at a jump, and as ``SectionTable``.
        """
        rows = np.atleast_1d(np.asarray(reynolds, np.float64))

        def sampled(alpha: Floats, at: Floats) -> Floats:
            """C_L and C_D (2, R, K)."""
            every = np.broadcast_arrays(alpha[None, :], at[:, None])
            found = function(*(np.ravel(a) for a in every))
            try:
                both = np.asarray(np.stack([np.asarray(c, np.float64) for c in found]))
                return both.reshape(2, at.size, alpha.size)
            except (TypeError, ValueError):
                seen = f"the section law gives {found!r:.80} for {alpha.size * at.size} angles"
                remedy = "return C_L and C_D as two arrays of as many numbers"
                raise InputError(seen, remedy) from None

        def made(alpha: Floats, error: float = 0.0) -> SectionTable:
            lift, drag = sampled(alpha, rows)
            # -pi and pi are one angle.
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
        whole = max(error.max(), errors(table, alpha, between).max() if between.size else 0.0)
        return replace(table, sampling_error=float(whole))

    def core_law(self) -> dict[str, Any]:
        """Give the law as the compiled core takes it: its figures by name."""
        figures = {
            name: np.ascontiguousarray(getattr(self, name).ravel())
            for name in ("angle", "reynolds", "lift", "drag")
        }
        return {"kind": "tabulated", **figures}

    def metadata(self) -> dict[str, Any]:
        """Name, source and Reynolds numbers; not the coefficients."""
        return {"name": self.name, "source": self.source, "reynolds": self.reynolds.tolist()}

    def fingerprint(self) -> str:
        """SHA-256 of the figures as little-endian f8."""
        import hashlib

        arrays = (self.angle, self.reynolds, self.lift, self.drag)
        flat = np.concatenate([a.ravel() for a in arrays])
        return hashlib.sha256(flat.astype("<f8").tobytes()).hexdigest()

    def __repr__(self) -> str:
        return (
            f"SectionTable({self.name!r}, {self.angle.size} angles, "
            f"Re {self.reynolds[0]:.3g} to {self.reynolds[-1]:.3g})"
        )


# -------------------------------------------------------------------------------------------------
# How far loads computed with a set of constants may err, and by what.

DISCREPANCIES = ("thrust_coefficient", "power_coefficient")  # of an axial test


@dataclass(frozen=True, eq=False)
class SectionUncertainty:
    """How well a set of section constants is known.

    Attributes
    ----------
    covariance : SectionCovariance
        Covariance of the constants.  Where the blade was not measured it holds what is not known of
        chord and twist, too, as changes of the constants that have the same loads.
    thrust_coefficient, power_coefficient : float
        Standard deviations of the errors of C_T and C_P that the best constants would leave [-].
    another_tunnel : bool
        Whether the constants rest on a tunnel other than the one, or the flight, that the loads
        are to agree with, so that what tunnels differ by counts, see ``propmap.bands``.
    with_blade : SectionCovariance or None
        What ``covariance`` would be with the blade measured; None where it was.
    envelope : Envelope or None
        The range of operating points that the constants were fitted to; None where it is not
        known.

    Raises
    ------
    InputError
        For a standard deviation that is negative or no number.
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
            found = f"the covariances are of {self.with_blade.names} and {self.covariance.names}"
            raise InputError(found, "give them for the same constants")

    def without(self, name: str) -> SectionUncertainty:
        """Take the constant ``name`` as known."""
        names = [each for each in self.covariance.names if each != name]
        kept = self.covariance.of(names)
        blade = None if self.with_blade is None else self.with_blade.of(names)
        return replace(self, covariance=kept, with_blade=blade)

    def as_dict(self) -> dict[str, Any]:
        """Give plain data, as ``filed_uncertainty`` reads it."""
        return {
            "names": list(self.covariance.names),
            "covariance": self.covariance.matrix.tolist(),
            **{name: getattr(self, name) for name in DISCREPANCIES},
            "another_tunnel": self.another_tunnel,
            **({} if self.with_blade is None else {"with_blade": self.with_blade.matrix.tolist()}),
        }


def filed_uncertainty(table: Any) -> SectionUncertainty | None:
    """Read the table ``[uncertainty]`` of a file, as ``SectionUncertainty.as_dict`` writes it."""
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
        raise InputError(found, "remove it, or write the file anew") from None
    return SectionUncertainty(**matrices, **left, another_tunnel=other)


def fitted_uncertainty(table: Any, names: Collection[str]) -> SectionUncertainty | None:
    """Read from a fit's table ``[fit]`` how well its free parameters ``names`` are known."""
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
        found = f"the table [fit] is damaged: covariance or envelope ({error})"
        raise InputError(found, "write it again with propmap fit") from None
    kept_of = every.of(kept)
    return SectionUncertainty(kept_of, **shares, another_tunnel=False, envelope=covered)


LARGEST_VARIANCE = 1e30  # beyond it deviations of loads overflow


@dataclass(frozen=True, eq=False)
class SectionCovariance:
    """The covariance of P parameters of ``Airfoil``.

    Attributes
    ----------
    names : tuple of str
        The parameters.
    matrix : ndarray, shape (P, P)
        In the parameters' units; a variance is infinite where the data say nothing of the
        parameter.

    Raises
    ------
    InputError
        Where these do not fit together.
    """

    names: tuple[str, ...]
    matrix: Floats

    def __post_init__(self) -> None:
        count = len(self.names)
        if self.matrix.shape != (count, count):
            found = f"the covariance of {count} parameters has shape {self.matrix.shape}"
            raise InputError(found, f"give {count} rows of {count} numbers")
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
        """Parameters with an infinite variance."""
        variances = np.diag(self.matrix)
        return tuple(n for n, v in zip(self.names, variances, strict=True) if not np.isfinite(v))

    @property
    def determined(self) -> SectionCovariance:
        """The part of finite variance."""
        return self.of([name for name in self.names if name not in self.unknown])

    def of(self, names: list[str]) -> SectionCovariance:
        """Keep some of the parameters, ``names``."""
        kept = [self.names.index(name) for name in names]
        return SectionCovariance(tuple(names), self.matrix[np.ix_(kept, kept)])

    def as_dict(self) -> dict[str, Any]:
        """Give plain data, with None for an infinite variance."""
        rows = [[v if np.isfinite(v) else None for v in row] for row in self.matrix.tolist()]
        return {"names": list(self.names), "matrix": rows}
