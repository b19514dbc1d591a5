"""How uncertain the parameters of a section law are, as a fit has found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from propmap.errors import InputError
from propmap.typing import Floats


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
            raise InputError(
                f"the covariance of {count} parameters has shape {self.matrix.shape}",
                f"give {count} rows of {count} numbers",
            )
        known = self.determined.matrix if self.unknown else self.matrix
        if not known.size:
            return
        if not np.isfinite(known).all() or np.linalg.eigvalsh(known)[0] < -1e-6 * known.max():
            raise InputError("the covariance has a negative variance", "fit again")

    @property
    def unknown(self) -> tuple[str, ...]:
        """Parameters with an infinite variance."""
        variances = np.diag(self.matrix)
        return tuple(n for n, v in zip(self.names, variances, strict=True) if not np.isfinite(v))

    @property
    def determined(self) -> SectionCovariance:
        """The same without those of infinite variance."""
        return self.of([name for name in self.names if name not in self.unknown])

    def of(self, names: list[str]) -> SectionCovariance:
        """The part that belongs to some of the parameters, ``names``."""
        kept = [self.names.index(name) for name in names]
        return SectionCovariance(tuple(names), self.matrix[np.ix_(kept, kept)])

    def as_dict(self) -> dict[str, Any]:
        """Plain data, None for an infinite variance."""
        rows = [[v if np.isfinite(v) else None for v in row] for row in self.matrix.tolist()]
        return {"names": list(self.names), "matrix": rows}
