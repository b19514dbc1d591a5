"""The section law's constants: named sets, files, and checks."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from propmap.errors import InputError
from propmap.model.core_section import section_coefficients
from propmap.model.corrections import agreed, as_texts
from propmap.model.drag_factor import drag_factor_accepted, warn_of_drag_factor
from propmap.model.uncertainty import SectionUncertainty, filed_uncertainty, fitted_uncertainty

if TYPE_CHECKING:
    from propmap.typing import Floats

SCHEMA = 1
SETS = Path(__file__).parents[1] / "catalogue" / "airfoils"
LIFT_LAWS = ("blended", "simplified")
LIMITS = {
    "c_l1": (0.0, 20.0, "1/rad"),
    "c_l2": (0.0, 10.0, "-"),
    "c_d": (0.0, 20.0, "-"),
    "alpha_0": (0.02, 1.5, "rad"),
    "zero_lift_angle": (-0.5, 0.5, "rad"),
    "c_d0": (0.0, 1.0, "-"),
    "c_p": (0.0, 10.0, "-"),
    "sharpness": (5.0, 500.0, "1/rad"),
    "drag_factor": (0.0, 10.0, "-"),
    "reynolds_camber": (-0.2, 0.2, "rad"),
    "drag_angle": (-0.5, 0.5, "rad"),
}
"""Least and largest value of each constant, and its unit."""
BEYOND_THE_PAPER = ("reynolds_camber", "drag_angle")
"""Constants that files leave out where they are zero, as in the paper's law."""


@dataclass(frozen=True)
class Airfoil:
    """Constants of the blade-section law, eqs. (3) and (4).

    Attributes
    ----------
    c_l1 : float
        Slope of the attached lift [1/rad].
    c_l2 : float
        Amplitude of the separated lift [-]; c_l where ``lift_law`` is "simplified".
    c_d : float
        Amplitude of the pressure drag [-].
    alpha_0 : float
        Angle of attack at the middle of the stall blend [rad].
    zero_lift_angle : float
        Angle of attack of zero lift [rad], negative for ordinary camber.  The paper's law has
        none; (3) and (4) are evaluated at alpha - zero_lift_angle.
    c_d0, c_p, sharpness : float
        The paper's constants c_d0 [-], c_p [-] and M [1/rad].
    drag_factor : float
        Multiplies the rotor drag [-], 1 in the paper.  Deprecated: another value warns; the
        correction ``mount-drag`` has what a factor cannot tell.
    reynolds_camber : float
        Growth of the zero-lift angle by ln(Re / 5e4) [rad], Re = rho Omega y c / mu of the rotation
        alone, from 1e4 to 1.2e5; about -0.02 for small propellers, 0 in the paper.
    drag_angle : float
        How far above zero_lift_angle the pressure drag is least [rad]: c_d sin^2(alpha -
        zero_lift_angle - drag_angle) in (4).  About 0.07 for small propellers, 0 in the paper.
    lift_law : str
        "blended", eq. (3), or "simplified", footnote 1: C_L = c_l2 sin(a) cos(a).
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
    drag_factor: float = 1.0
    reynolds_camber: float = 0.0
    drag_angle: float = 0.0
    lift_law: str = "blended"
    name: str = "unnamed"
    source: str = ""
    corrections: tuple[str, ...] | None = None
    uncertainty: SectionUncertainty | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        for constant, (low, high, unit) in LIMITS.items():
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
        if self.drag_factor != 1.0:
            warn_of_drag_factor(stacklevel=3)
        object.__setattr__(self, "corrections", as_texts(self.corrections))

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the constants by which loads can be differentiated."""
        return tuple(LIMITS)

    @property
    def has_attached_lift(self) -> bool:
        """Whether lift rises with the angle of attack up to stall: not by footnote 1."""
        return self.lift_law == "blended" and self.c_l1 > 0.0

    def coefficients(self, alpha: ArrayLike, reynolds: ArrayLike) -> tuple[Floats, Floats]:
        """Lift and drag of the section by itself, eqs. (3) and (4).

        Parameters
        ----------
        alpha : array_like, shape (...)
            Angle of attack from the chord line [rad].
        reynolds : array_like, shape (...)
            Re [-], also that of the rotation alone; both broadcast.

        Returns
        -------
        lift, drag : ndarray, shape (...)
            C_L and C_D [-].
        """
        return section_coefficients(self.core_law(), alpha, reynolds)

    def core_law(self) -> dict[str, Any]:
        """The law as the compiled core takes it: its numbers by name."""
        attached = 1.0 if self.lift_law == "blended" else 0.0
        numbers = {name: getattr(self, name) for name in self.parameters}
        return {"kind": "blended", "attached": attached, **numbers}

    def with_parameters(self, **changes: Any) -> Airfoil:
        """A copy with ``changes`` to constants, by name as in the constructor.

        How well they are known is that of the changed ones no more, and is left out unless given.
        """
        return replace(self, **{"uncertainty": None, **changes})

    def with_corrections(self, texts: Sequence[str]) -> Airfoil:
        """The set as it is to be used with corrections of these ``texts``.

        Raises
        ------
        InputError
            Where the constants were found with others.
        """
        with drag_factor_accepted():
            return replace(self, corrections=agreed(self.name, self.corrections, texts))

    def to_toml(self) -> str:
        """The set as the text of a parameter file."""
        text = _toml_file(self._told())
        if self.uncertainty is None:
            return text
        import tomli_w

        return f"{text}\n{tomli_w.dumps({'uncertainty': self.uncertainty.as_dict()})}"

    def _filed(self) -> dict[str, Any]:
        """What a parameter file may say."""
        return {name: getattr(self, name) for name in FILED}

    def _told(self) -> dict[str, Any]:
        """What a parameter file says: terms beyond the paper's only where they act."""
        return {
            key: value
            for key, value in self._filed().items()
            if value is not None and not (key in BEYOND_THE_PAPER and value == 0.0)
        }

    def metadata(self) -> dict[str, Any]:
        """The constants by name."""
        return {key: value for key, value in self._filed().items() if key != "corrections"}

    def fingerprint(self) -> str:
        """SHA-256 of the parameter file, without its corrections."""
        import hashlib

        told = {key: value for key, value in self._told().items() if key != "corrections"}
        return hashlib.sha256(_toml_file(told).encode()).hexdigest()


FILED = tuple(f.name for f in fields(Airfoil) if f.name != "uncertainty")
"""Fields of ``Airfoil`` that a parameter file has."""


def parameter_set(name_or_path: str | Path) -> Airfoil:
    """A named set of constants, or one read from a TOML file.

    Parameters
    ----------
    name_or_path : str or Path
        "paper-soft", "paper-stiff" or "paper-apc" (Table I), "apc-8x6e-2019" (fitted), or a file's
        path.

    Raises
    ------
    InputError
        For an unknown name, an unreadable file or a bad constant.
    """
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
    """Names of the bundled parameter sets."""
    return sorted(file.stem for file in SETS.glob("*.toml"))


def read_airfoil(path: Path, *, uncertainty: bool = True) -> Airfoil:
    """Read a parameter file.

    Parameters
    ----------
    path : Path
        Of the file.
    uncertainty : bool
        Whether what a fit's file says of its constants' uncertainty is read as well.

    Raises
    ------
    InputError
        Naming the file and the field.
    """
    name = str(path)
    try:
        table = tomllib.loads(path.read_bytes().decode("utf-8"))
    except FileNotFoundError:
        raise InputError(f"{name}: no such file; give a set's name or an existing .toml") from None
    except OSError as error:
        raise InputError(f"{name}: cannot be read ({error.strerror}); give a .toml file") from None
    except UnicodeDecodeError:
        raise InputError(f"{name}: not a text file; give a parameter set in TOML") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(
            f"{name}: not valid TOML ({error}); `propmap airfoils show paper-apc` prints an example"
        ) from None
    schema = table.pop("schema", SCHEMA)
    if schema != SCHEMA:
        raise InputError(
            f"{name}: schema is {schema!r}, this version reads {SCHEMA}; upgrade propmap"
        )
    # A table is left to whoever wrote it; a stray key at the top is likely a typing error.
    extra = sorted(k for k, v in table.items() if k not in FILED and not isinstance(v, dict))
    if extra:
        raise InputError(
            f"{name}: unknown field {extra[0]!r}; known fields: {', '.join(sorted(FILED))}"
        )
    required = [f for f in ("c_l1", "c_l2", "c_d", "alpha_0") if f not in table]
    if required == ["c_l1"] and table.get("lift_law") == "simplified":
        table["c_l1"], required = 0.0, []
    if required:
        raise InputError(f"{name}: {required[0]} is missing; add a line '{required[0]} = ...'")
    try:
        fit = table.get("fit") if uncertainty else None
        known = fitted_uncertainty(fit, (*LIMITS, "mount_area", "untwist"))
        known = known or filed_uncertainty(table.get("uncertainty"))
        return Airfoil(**{k: v for k, v in table.items() if k in FILED}, uncertainty=known)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _toml_file(told: Mapping[str, Any]) -> str:
    """The text of a parameter file."""
    lines = [f"schema = {SCHEMA}", *(f"{key} = {_toml(value)}" for key, value in told.items())]
    return "\n".join(lines) + "\n"


def _toml(value: Any) -> str:
    """A number, a text or a list of texts in TOML."""
    # JSON's strings are TOML's; only DEL differs.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
