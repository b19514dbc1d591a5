"""Where the search for the inflow ended, station by station: why a point did not converge."""

from __future__ import annotations

import dataclasses

import numpy as np

from propmap.arrays.namespace import by_numpy
from propmap.engine.accuracy import Accuracy
from propmap.engine.batch import Block
from propmap.engine.evaluation import Prepared, evaluate_flow, nodes_of
from propmap.engine.programs import Flow
from propmap.results import SearchReport
from propmap.solve.disk import solve_disk
from propmap.solve.problem import Case
from propmap.solve.root import MAX_STEPS, search


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
