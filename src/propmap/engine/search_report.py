"""Where the search for the inflow ended, station by station: why a point did not converge."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.namespace import by_numpy
from propmap.engine.accuracy import Accuracy
from propmap.engine.batch import Block
from propmap.engine.evaluation import Prepared, evaluate_flow, nodes_of
from propmap.engine.programs import Flow
from propmap.solve.disk import solve_disk
from propmap.solve.problem import Case
from propmap.solve.root import MAX_STEPS, search
from propmap.typing import Floats


@dataclass(frozen=True)
class SearchReport:
    """How equation (11) was solved at one operating point; S stations from root to tip.

    Attributes
    ----------
    radius : ndarray, shape (S,)
        y [m].
    inflow : ndarray, shape (S,)
        v_i where the search ended [m/s].
    residual : ndarray, shape (S,)
        Blade-element thrust less momentum thrust there [N/m].
    steps : ndarray, shape (S,)
        Evaluations of the residual in the search.
    found : ndarray, shape (S,)
        Whether the search found the largest root.
    tip : float
        Blade radius R [m].
    """

    radius: Floats
    inflow: Floats
    residual: Floats
    steps: NDArray[np.int64]
    found: NDArray[np.bool_]
    tip: float

    def __str__(self) -> str:
        lost = np.flatnonzero(~self.found)
        if not lost.size:
            k = int(np.argmax(self.steps))
            return (
                f"all {self.radius.size} stations converged, in {int(self.steps.max())} steps at "
                f"most (at y/R = {self.radius[k] / self.tip:.3f})"
            )
        k = int(lost[0])
        return (
            f"{lost.size} of {self.radius.size} stations did not converge; the first at "
            f"y = {self.radius[k]:.5f} m (y/R = {self.radius[k] / self.tip:.3f}): after "
            f"{int(self.steps[k])} steps v_i = {self.inflow[k]:.4g} m/s leaves a residual of "
            f"{self.residual[k]:.3g} N/m"
        )


def search_report(
    rotor: Prepared,
    setting: Accuracy,
    flow: Flow,
    max_steps: int = MAX_STEPS,
) -> SearchReport:
    """Solve one operating point again, with NumPy, and report on its search.

    ``flow`` is of one point, with its static inflow if it descends.
    """
    blocks: list[Block] = []
    by_hand = dataclasses.replace(rotor, compiled=False)
    evaluate_flow(by_hand, setting, flow, solved=lambda block, _: blocks.append(block))
    block = blocks[-1]  # the last one counts, see ``evaluate_flow``
    nodes = nodes_of(block, few=False)
    density, steps = float(rotor.arrays.medium.density), np.array(max_steps)
    with by_numpy():
        _, disk = solve_disk(Case(rotor.arrays, *flow), block.panels, nodes)  # type: ignore[arg-type]
        count = disk.nodes.radius.shape[0]
        each = [
            search(disk.problem.stations(slice(k, k + 1)), steps, nodes)  # type: ignore[arg-type]
            for k in range(count)
        ]
    return SearchReport(
        radius=np.asarray(disk.nodes.radius[:, 0]),
        inflow=np.array([float(one.inflow[0, 0]) for one in each]),
        residual=density * np.array([float(one.residual[0, 0]) for one in each]),
        steps=np.array([int(one.steps) for one in each]),
        found=np.array([bool(one.found[0, 0]) for one in each]),
        tip=float(rotor.arrays.blade.tip),
    )
