"""Changes of a rotor's loads, where loads are wanted: by a parameter, or by an error of theirs."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np

from propmap.loads import LOADS
from propmap.operating_points import FlowPoints
from propmap.typing import Floats

ChangesAt = Callable[[FlowPoints], Floats]
"""D changes of the L loads at N operating points, (D, L, N)."""


class LoadChanges:
    """Several changes of the loads at one set of operating points, computed once.

    Parameters
    ----------
    at : callable
        See ``ChangesAt``.
    """

    def __init__(self, at: ChangesAt) -> None:
        self._at = at
        self._known: Floats | None = None

    def number(self, d: int) -> LoadChange:
        """Change number ``d`` where a source of loads is wanted."""
        return LoadChange(self, d)

    def rows(self, d: int, points: FlowPoints) -> Floats:
        """Change number ``d`` (L, N) at N ``points``, the same at every call."""
        if self._known is None:
            self._known = self._at(points)
        return np.asarray(self._known[d])


class LoadChange:
    """One of several changes as a source of loads.

    Parameters
    ----------
    changes : LoadChanges
        All of them.
    d : int
        Which.
    """

    def __init__(self, changes: LoadChanges, d: int) -> None:
        self.changes, self.d = changes, d

    def loads_at_velocity(self, omega: Floats, velocity: Floats) -> Any:
        """The change by the loads' names and a ``status``, of the shape of ``omega`` [rad/s]."""
        across = np.hypot(velocity[:, 0], velocity[:, 1])
        rows = self.changes.rows(self.d, FlowPoints(omega, velocity[:, 2], across))
        by_name = dict(zip(LOADS, rows, strict=True))
        return SimpleNamespace(**by_name, status=np.full(omega.shape, "ok"))
