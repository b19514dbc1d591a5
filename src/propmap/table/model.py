"""The model as the builder of a table sees it: coefficients at (J, beta), each asked for once."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.loads import LOADS, error_scales
from propmap.tasks import InTurn, Workers
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.rotor import Rotor

Progress = Callable[[str, int], None]
"""Called with what is being done and the number of operating points evaluated so far."""

BATCH = 4096
"""Operating points between two reports of progress: some tenths of a second."""


class Model:
    """Loads of a rotor relative to its static ones, at two rotational speeds.

    Parameters
    ----------
    rotor : Rotor
        The model.
    omega : ndarray, shape (2,)
        Both speeds [rad/s].
    leave_out_vortex_ring : bool
        Whether loads in the vortex ring state are NaN.
    progress : Progress, optional
        Told of every batch.
    workers : Workers, optional
        Who evaluates; by default this process.

    Raises
    ------
    InputError
        Unless static thrust and torque are positive.
    """

    def __init__(
        self,
        rotor: Rotor,
        omega: Floats,
        *,
        leave_out_vortex_ring: bool = False,
        progress: Progress | None = None,
        workers: Workers | None = None,
    ) -> None:
        self.rotor, self.omega = rotor, omega
        self._workers = workers or InTurn()
        self.leave_out_vortex_ring = leave_out_vortex_ring
        self.evaluations = 0
        self.stage = "static loads"
        self._progress = progress
        self._known: list[dict[tuple[float, float], Floats]] = [{}, {}]
        self.static = self.static_loads(omega)

    def static_loads(self, omega: Floats) -> Floats:
        """What errors are relative to (n, L), see ``loads.error_scales``."""
        loads, _ = self._evaluate(omega, np.zeros_like(omega), np.zeros_like(omega))
        static = dict(zip(LOADS, loads.T, strict=True))
        scales = np.array(list(error_scales(static, self.rotor.model.propeller.radius).values())).T
        if not (scales > 0.0).all():
            raise InputError(
                "at rest in the air this rotor has no positive thrust and torque, to which a "
                "table's errors could be related",
                "check the propeller's pitch and the section law",
            )
        return scales

    def loads(self, omega: Floats, speed: Floats, beta: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """Loads (n, L) in the order of ``LOADS``, and whether in the vortex ring state (n,)."""
        values, ring = self._evaluate(omega, speed, beta)
        if self.leave_out_vortex_ring:
            values[ring] = np.nan
        return values, ring

    def relative(self, node: int, advance: Floats, beta: Floats) -> tuple[Floats, Floats]:
        """Loads over static ones on a grid at one omega (n, m, L), and 1 in the vortex ring."""
        known = self._known[node]
        grid = [(j, b) for j in advance.tolist() for b in beta.tolist()]
        self._learn(node, [point for point in grid if point not in known])
        found = np.array([known[point] for point in grid]).reshape(advance.size, beta.size, -1)
        return found[..., :-1], found[..., -1]

    def _learn(self, node: int, points: list[tuple[float, float]]) -> None:
        if not points:
            return
        advance, beta = np.array(points).T
        omega = np.full(advance.size, self.omega[node])
        values, ring = self.loads(omega, advance * omega * self.rotor.model.propeller.radius, beta)
        rows = np.concatenate([values / self.static[node], ring[:, None]], axis=1)
        self._known[node].update(zip(points, rows, strict=True))

    def _evaluate(
        self, omega: Floats, speed: Floats, beta: Floats
    ) -> tuple[Floats, NDArray[np.bool_]]:
        values, ring = np.empty((omega.size, len(LOADS))), np.empty(omega.size, bool)
        cuts = [slice(start, start + BATCH) for start in range(0, omega.size, BATCH)]
        batches = ((omega[cut], speed[cut], beta[cut]) for cut in cuts)
        for which, found in self._workers.results(_loads_of, self.rotor, batches):
            values[cuts[which]], ring[cuts[which]] = found
            self.evaluations += found[1].size
            if self._progress:
                self._progress(self.stage, self.evaluations)
        return values, ring


def _loads_of(
    rotor: Rotor, batch: tuple[Floats, Floats, Floats]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Loads (n, L) of a batch, and whether in the vortex ring state (n,)."""
    found = rotor.loads(*batch)
    values = np.stack([getattr(found, name) for name in LOADS], axis=-1)
    return values, found.status == "vortex_ring"
