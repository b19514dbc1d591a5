"""Loads of batches of operating points: planned, cut into blocks, run on all cores."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import numpy as np

from propmap.arrays.namespace import by_numpy, on_accelerator
from propmap.compilation import FEW
from propmap.engine.accuracy import Accuracy
from propmap.engine.batch import BLOCK, LARGE_BATCH, Block, cut, filled_up, nodes_of_each, run
from propmap.engine.forecast import Forecast, static_loads
from propmap.engine.lanes import in_groups
from propmap.engine.plan import Job, Outlook, may_leave_islands, plan, plan_again
from propmap.engine.programs import Flow, compiled_search, search_by_numpy
from propmap.physics.element import AnnulusLoads
from propmap.physics.momentum import static_inflow as equation_12
from propmap.physics.rotor import RotorArrays
from propmap.physics.velocities import AzimuthNodes, azimuth_nodes
from propmap.solve.disk import DiskSolution
from propmap.solve.rotor_loads import RotorLoads
from propmap.typing import Floats

CHUNK = 65536
"""Operating points that are planned and run together, at most, which limits the memory in use."""

ATTACHED = 0.9
"""Attached share below which the forecast of no stall was wrong, and a point is evaluated again."""

ROWS = len(AnnulusLoads._fields) + len(RotorLoads._fields) - 1
"""Number of arrays in ``RotorLoads.rows``."""

Solved = Callable[[Block, DiskSolution], None]
"""Called with each block and its solution, whose last axis is the block's points, padded."""


@dataclass(frozen=True)
class Prepared:
    """A rotor ready for evaluation.

    Attributes
    ----------
    arrays, on_device : RotorArrays
        Its arrays, of NumPy float64, and the same where programs run.
    forecast : Forecast
        Tells at which operating points the rotor may stall.
    compiled : bool
        Whether programs are compiled; else NumPy runs them.
    uniform : bool
        Whether the same programs serve batches of any size.
    double : bool
        Whether programs work in float64, or else in float32.
    """

    arrays: RotorArrays
    on_device: RotorArrays
    forecast: Forecast
    compiled: bool
    uniform: bool
    double: bool

    @functools.cached_property
    def static(self) -> tuple[float, float]:
        """Thrust and torque at rest over Omega^2, see ``static_loads``."""
        return static_loads(self.arrays)


def prepare(
    arrays: RotorArrays, *, compiled: bool = True, uniform: bool = False, double: bool = True
) -> Prepared:
    """What all evaluations of a rotor need, done once; parameters as in ``Prepared``."""
    on_device = arrays
    if compiled:
        with jax.enable_x64(double):
            on_device = jax.device_put(arrays)
    return Prepared(arrays, on_device, Forecast.of(arrays), compiled, uniform, double)


def evaluate(
    rotor: Prepared, setting: Accuracy, omega: Floats, v_axial: Floats, v_inplane: Floats
) -> RotorLoads:
    """Loads at N operating points; omega [rad/s], velocities [m/s], all (N,), v_inplane >= 0."""
    return _in_parts(rotor, setting, flow_at(rotor, setting, omega, v_axial, v_inplane))


def flow_at(
    rotor: Prepared, setting: Accuracy, omega: Floats, v_axial: Floats, v_inplane: Floats
) -> Flow:
    """The flow with the static inflow that descending points need; arguments as in ``evaluate``."""
    down = v_axial < 0.0
    v_hover = np.zeros_like(omega) if rotor.uniform or down.any() else None
    if v_hover is not None and down.any():
        rates, where = np.unique(omega[down], return_inverse=True)
        v_hover[down] = static_inflow(rotor, setting, rates)[where]
    return Flow(omega, v_axial, v_inplane, v_hover)


def _in_parts(rotor: Prepared, setting: Accuracy, flow: Flow) -> RotorLoads:
    # Parts of equal size: a small remainder would need further programs.
    points = np.arange(flow.omega.size)
    which = np.array_split(points, max(1, -(-points.size // CHUNK)))
    found = [evaluate_flow(rotor, setting, flow.part(part)) for part in which]
    rows: Any = [np.concatenate(row) for row in zip(*(one.rows for one in found), strict=True)]
    return RotorLoads.of_rows(rows)


def evaluate_flow(
    rotor: Prepared,
    setting: Accuracy,
    flow: Flow,
    *,
    alike: bool = False,
    size: int | None = None,
    solved: Solved | None = None,
) -> RotorLoads:
    """Loads at N operating points whose static inflow is known.

    Parameters
    ----------
    rotor, setting, flow
        Rotor, accuracy and operating points.
    alike : bool
        Whether all points get the same nodes, see ``plan``, and are evaluated only once.
    size : int, optional
        Points per block; by default as in ``batch.cut``.
    solved : callable, optional
        Called with each block.  A point may be in several blocks; its last one counts.
    """
    omega, v_axial, v_inplane, v_hover = flow
    setting = setting.for_stall(rotor.forecast.stall_width)
    if rotor.uniform and not alike:
        setting = setting.with_few_programs
    everyone = np.arange(omega.size)
    outlook = Outlook(
        advance=advance_ratio(rotor, omega, v_inplane),
        climb=advance_ratio(rotor, omega, v_axial),
        stalls=rotor.forecast.may_stall(omega, v_axial, v_inplane) | alike,
        islands=may_leave_islands(v_axial, 0.0 if v_hover is None else v_hover),
    )
    results = np.full((ROWS, omega.size), np.nan)
    on_device = rotor.compiled and on_accelerator()
    kinds = {
        "axial_apart": not _few(rotor, flow),
        "descent": v_hover is not None,
        "again_alike": rotor.uniform,
    }

    # An accelerator gets large blocks of the points that are left, too.
    large = rotor.uniform or (on_device and omega.size >= LARGE_BATCH)

    def run_jobs(jobs: list[Job], size: int | None) -> RotorLoads:
        here = {"accelerator": on_device, "compiled": rotor.compiled}
        blocks = cut(jobs, size, large=large, **here)
        _run(rotor, blocks, flow, results, solved)
        return RotorLoads.of_rows(results)

    found = run_jobs(plan(setting, outlook, everyone, alike=alike, **kinds), size)
    if not alike:
        unseen = ~outlook.stalls & ~((found.attached > ATTACHED) & (found.roots == 1))
        unseen &= np.isfinite(found.loads.thrust)
        if unseen.any():
            jobs = plan(setting, outlook.part(unseen), everyone[unseen], **kinds)
            found = run_jobs([job for job in jobs if len(job.panels) > 1], size)
        rough = np.ones(omega.size, bool)
        limits = (setting.largest_tail, *(limit for _, limit in setting.finer))
        for times, limit in enumerate(limits[:-1], start=1):
            rough &= tail_share(rotor, omega, v_axial, v_inplane, found) > limit
            if not rough.any():
                break
            jobs = plan_again(setting, times, outlook.part(rough), everyone[rough])
            # Blocks of one size need only one further program.
            found = run_jobs(jobs, None if on_device or rotor.uniform else BLOCK)
    # ``SPEED_FLOOR`` leaves loads of 1e-45 and the like at rest: make them zero.
    results[np.abs(results) < 1e-30] = 0.0
    found = RotorLoads.of_rows(results)
    return found._replace(roots=found.roots.astype(int), mirrored=found.mirrored > 0.0)


def tail_share(
    rotor: Prepared, omega: Floats, v_axial: Floats, v_inplane: Floats, found: RotorLoads
) -> Floats:
    """The larger of the tails of thrust and torque, as a share of the load at rest, (N,).

    Above the last limit of ``Accuracy.finer`` the loads may be less accurate than promised.
    """
    thrust, torque = rotor.static
    # A rotor that turns slowly in a wind has the loads of the wind.
    tip = float(rotor.arrays.blade.tip)
    square = np.maximum(omega**2, (v_axial**2 + v_inplane**2) / tip**2)
    tails = np.maximum(found.thrust_tail / thrust, found.torque_tail / torque)
    return np.divide(tails, square, out=np.zeros_like(tails), where=square > 0.0)


def advance_ratio(rotor: Prepared, omega: Floats, velocity: Floats) -> Floats:
    """A component of V over Omega R [-], (N,); infinite for a rotor at rest in a wind."""
    tip = float(rotor.arrays.blade.station[-1])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(velocity != 0.0, velocity / (omega * tip), 0.0)


def static_inflow(rotor: Prepared, setting: Accuracy, omega: Floats) -> Floats:
    """Static inflow (12) [m/s] at omega (N,) [rad/s]."""
    still = np.zeros_like(omega)
    # v_hover is given so that the programs are those of the descending points.
    thrust: Any = _in_parts(rotor, setting, Flow(omega, still, still, still)).loads.thrust
    with by_numpy():
        return np.asarray(equation_12(thrust, rotor.arrays.medium.density, rotor.arrays.blade.tip))


def _run(
    rotor: Prepared,
    blocks: list[Block],
    flow: Flow,
    results: Floats,
    solved: Solved | None,
) -> None:
    """Evaluate blocks and write ``RotorLoads.rows`` into ``results`` (F, N)."""
    few = _few(rotor, flow)

    def one(block: Block) -> None:
        nodes = nodes_of(block, few=few)
        which = block.padded
        program = search_by_numpy(block.panels)
        if rotor.compiled:
            axial, lanes = isinstance(nodes.count, int), in_groups(block.size, block.panels)
            program = compiled_search(block.panels, axial=axial, lanes=lanes)
        # Without x64 JAX converts float64 to float32.
        with jax.enable_x64(rotor.double):
            asked = (flow.part(which), nodes, block.points.size)
            found, solution = program(rotor.on_device, *asked)
            results[:, block.points] = np.asarray(found)[:, : block.points.size]
            if solved is not None:
                solved(block, solution)

    run(blocks, one, in_turn=not rotor.compiled)


def nodes_of(block: Block, *, few: bool) -> AzimuthNodes:
    """Azimuth nodes of a block: a single one for axial flow, unless there are ``few`` points, for
    which one program less to compile counts more."""
    if block.azimuths[0] == 1 and not few:
        return azimuth_nodes(1)
    return nodes_of_each(filled_up(block.azimuths, block.size), block.most_azimuths)


def _few(rotor: Prepared, flow: Flow) -> bool:
    return flow.omega.size < FEW or rotor.uniform
