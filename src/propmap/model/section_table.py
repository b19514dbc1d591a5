"""A section law given as a table of C_L and C_D."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from propmap.errors import InputError
from propmap.model.core_section import section_coefficients
from propmap.model.corrections import agreed, as_texts
from propmap.model.drag_factor import drag_factor_accepted, warn_of_drag_factor
from propmap.typing import Floats

LARGEST = 10.0
"""Coefficients beyond are taken for an error of the file [-]."""

CLOSEST = 0.999 * math.radians(0.01)
"""Least distance of two angles [rad]."""

SectionFunction = Callable[[Floats, Floats], tuple[ArrayLike, ArrayLike]]
"""Gives C_L and C_D (N,) at angles of attack [rad] and Reynolds numbers (N,)."""

MOST_ANGLES = 4000
"""Angles at which a function is sampled, at most."""


@dataclass(frozen=True, eq=False, repr=False)
class SectionTable:
    """C_L and C_D of a blade section, all the way round, at one or more Reynolds numbers.

    Attributes
    ----------
    angle : ndarray, shape (K,)
        Angle of attack from the chord line [rad], rising from -pi to pi.
    reynolds : ndarray, shape (R,)
        Reynolds numbers, rising.
    lift, drag : ndarray, shape (R, K)
        C_L and C_D [-], the same at -pi and pi.
    drag_factor : float
        Multiplies the rotor drag, 1 in the paper; deprecated, see ``Airfoil``.
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
    drag_factor: float = 1.0
    name: str = "unnamed"
    source: str = ""
    corrections: tuple[str, ...] | None = None
    sampling_error: float = 0.0

    parameters: ClassVar[tuple[str, ...]] = ("zero_lift_angle", "drag_factor")
    """Names of what loads can be differentiated by."""

    def __post_init__(self) -> None:
        for field in ("angle", "reynolds", "lift", "drag"):
            values = np.array(getattr(self, field), dtype=np.float64)
            if not np.isfinite(values).all():
                raise InputError(f"{field} holds a value that is not finite: remove it")
            values.flags.writeable = False
            object.__setattr__(self, field, values)
        shape = (self.reynolds.size, self.angle.size)
        if self.lift.shape != shape or self.drag.shape != shape:
            raise InputError(
                f"lift has shape {self.lift.shape} and drag {self.drag.shape}",
                f"give a row of {shape[1]} angles for each of {shape[0]} Reynolds numbers",
            )
        object.__setattr__(self, "corrections", as_texts(self.corrections))
        self._check_axes()
        self._check_figures()
        if self.drag_factor != 1.0:
            warn_of_drag_factor(stacklevel=3)

    def _check_axes(self) -> None:
        if self.angle.size < 8 or not (np.diff(self.angle) > 0.0).all():
            raise InputError("angles must rise, and be eight at least: sort the table")
        ends = self.angle[[0, -1]]
        if not np.allclose(ends, [-math.pi, math.pi], atol=1e-6):
            told = np.degrees(ends).round(2).tolist()
            raise InputError(
                f"angles run from {told[0]} to {told[1]} deg, expected -180 to 180",
                "extend the table, for instance by Viterna's method",
            )
        if np.diff(self.angle).min() < CLOSEST:
            raise InputError("two angles are less than 0.01 deg apart: remove one of them")
        object.__setattr__(self, "angle", np.array([-math.pi, *self.angle[1:-1], math.pi]))
        if not (self.reynolds > 0.0).all() or not (np.diff(self.reynolds) > 0.0).all():
            raise InputError("Reynolds numbers must be positive and rise: sort the table")

    def _check_figures(self) -> None:
        for name, values in (("lift", self.lift), ("drag", self.drag)):
            worst = float(np.abs(values).max())
            if worst > LARGEST:
                raise InputError(
                    f"{name} coefficient of {worst:g}, expected at most {LARGEST:g}",
                    "check the table's columns",
                )
            gap = np.abs(values[:, 0] - values[:, -1]).max()
            if gap > 1e-6:
                raise InputError(
                    f"{name} differs by {gap:g} between -180 and 180 deg, which are one angle",
                    "make them equal",
                )
        if (self.drag < 0.0).any():
            raise InputError("a drag coefficient is negative: check the table's columns")
        middle = self.lift[self.reynolds.size // 2]
        near = np.abs(self.angle) < math.radians(30.0)
        if not (middle[near].min() < 0.0 < middle[near].max()):
            raise InputError(
                "lift does not pass zero between -30 and 30 deg",
                "give angles from the chord line, positive nose up",
            )

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
                raise InputError(
                    f"the section law gives {found!r:.80} for {alpha.size * at.size} angles",
                    "return C_L and C_D as two arrays of as many numbers",
                ) from None

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
            raise InputError(
                f"a table of {alpha.size} angles differs from the section law by {error.max():.2g} "
                f"at {worst:.2f} deg, expected at most {tolerance:g}",
                "make the law continuous there, or give a larger tolerance",
            )
        between = np.sqrt(rows[:-1] * rows[1:])
        whole = max(error.max(), errors(table, alpha, between).max() if between.size else 0.0)
        return replace(table, sampling_error=float(whole))

    def coefficients(self, alpha: ArrayLike, reynolds: ArrayLike) -> tuple[Floats, Floats]:
        """Lift and drag between the figures of the table; as ``Airfoil.coefficients``.

        Parameters
        ----------
        alpha : array_like, shape (...)
            Angle of attack from the chord line [rad].
        reynolds : array_like, shape (...)
            Re [-]; outside the table's that of the nearest row holds.  Both broadcast.

        Returns
        -------
        lift, drag : ndarray, shape (...)
            C_L and C_D [-].
        """
        return section_coefficients(self.core_law(), alpha, reynolds)

    def core_law(self) -> dict[str, Any]:
        """The law as the compiled core takes it: its figures by name."""
        figures = {
            name: np.ascontiguousarray(getattr(self, name).ravel())
            for name in ("angle", "reynolds", "lift", "drag")
        }
        return {"kind": "tabulated", "drag_factor": self.drag_factor, **figures}

    def with_corrections(self, texts: Sequence[str]) -> SectionTable:
        """The table as it is to be used with corrections of these ``texts``; see ``Airfoil``."""
        with drag_factor_accepted():
            return replace(self, corrections=agreed(self.name, self.corrections, texts))

    def metadata(self) -> dict[str, Any]:
        """Name, source and Reynolds numbers; not the coefficients."""
        told = {"name": self.name, "source": self.source, "drag_factor": self.drag_factor}
        return told | {"reynolds": self.reynolds.tolist()}

    def fingerprint(self) -> str:
        """SHA-256 of the figures as little-endian f8."""
        import hashlib

        arrays = (self.angle, self.reynolds, self.lift, self.drag, np.array(self.drag_factor))
        flat = np.concatenate([a.ravel() for a in arrays])
        return hashlib.sha256(flat.astype("<f8").tobytes()).hexdigest()

    def __eq__(self, other: object) -> bool:
        return self._key() == other._key() if isinstance(other, SectionTable) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key())

    def __repr__(self) -> str:
        return (
            f"SectionTable({self.name!r}, {self.angle.size} angles, "
            f"Re {self.reynolds[0]:.3g} to {self.reynolds[-1]:.3g})"
        )

    def _key(self) -> tuple[Any, ...]:
        arrays = (self.angle, self.reynolds, self.lift, self.drag)
        return (
            *(a.tobytes() for a in arrays),
            self.drag_factor,
            self.name,
            self.source,
            self.corrections,
        )
