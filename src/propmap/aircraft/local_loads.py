"""Loads to first order about operating points, by derivatives that need no differences."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from propmap.loads import FLOW, LOADS
from propmap.rotor import Rotor
from propmap.table.query import LoadTable
from propmap.typing import Floats


def has_slopes(source: Any) -> bool:
    """Whether the loads of a ``source`` have exact derivatives by the flow.

    A rotor has, by the implicit function theorem, and a table; the hover model has not.
    """
    return isinstance(source, Rotor | LoadTable)


class LocalLoads:
    """Loads that are linear in rotor speed and in the velocity along and across the axis.

    They are linear about the operating points of the first call; a later one is about the nearest
    of these.  Where there is no velocity across the axis, drag and moments by it grow in whichever
    direction it does.

    Parameters
    ----------
    source : Rotor or LoadTable
        Has slopes, see ``has_slopes``.
    """

    def __init__(self, source: Any) -> None:
        self._source = source
        self._points = np.empty((3, 0))
        self._loads = np.empty((len(LOADS), 0))
        self._slopes = np.empty((len(LOADS), 3, 0))

    def loads_at_velocity(self, omega: Floats, velocity: Floats) -> Any:
        """Loads by name and a ``status``, of the shape of ``omega`` [rad/s]."""
        points = np.stack([omega, velocity[:, 2], np.hypot(velocity[:, 0], velocity[:, 1])])
        if not self._points.size:
            self._points = points
            self._loads, self._slopes = _loads_and_slopes(self._source, points)
        size = np.maximum(np.abs(self._points).max(axis=1), 1e-9)[:, None, None]
        apart = (points[:, :, None] - self._points[:, None]) / size
        k = np.argmin(np.sum(apart**2, axis=0), axis=1)
        change = points - self._points[:, k]
        rows = self._loads[:, k] + np.einsum("lpn,pn->ln", self._slopes[:, :, k], change)
        return SimpleNamespace(
            **dict(zip(LOADS, rows, strict=True)), status=np.full(omega.shape, "ok")
        )


def _loads_and_slopes(source: Any, points: Floats) -> tuple[Floats, Floats]:
    """Loads (L, N) at N points (3, N), and their derivatives (L, 3, N) by ``FLOW``."""
    if isinstance(source, Rotor):
        found = source.gradients(FLOW, *points)
        return found.loads, found.slopes
    omega, along, across = points
    velocity = np.stack([across, np.zeros_like(across), along], axis=1)
    loads = source.loads_at_velocity(omega, velocity)
    slopes = source.gradient_at_velocity(omega, velocity)
    each = np.stack([getattr(slopes, name) for name in LOADS])
    return np.stack([getattr(loads, name) for name in LOADS]), each[:, :, [0, 3, 1]].swapaxes(1, 2)
