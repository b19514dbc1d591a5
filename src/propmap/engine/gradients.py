"""Loads of batches, and their derivatives with respect to section parameters and flow."""

from __future__ import annotations

import functools
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax
import numpy as np

from propmap.arrays.namespace import by_numpy
from propmap.compilation import FEW
from propmap.engine.accuracy import Accuracy
from propmap.engine.batch import BLOCK, Block, nodes_of_each
from propmap.engine.evaluation import Prepared, evaluate_flow, nodes_of, prepare
from propmap.engine.lanes import in_groups, in_lanes, use_lanes
from propmap.engine.plan import alike_panels
from propmap.engine.programs import COMPILER_OPTIONS, Flow, compiled_search, with_lanes
from propmap.loads import LOADS
from propmap.physics.inflow_harmonics import Harmonics
from propmap.physics.momentum import static_inflow
from propmap.physics.rotor import RotorArrays
from propmap.physics.velocities import AzimuthNodes
from propmap.results import LoadGradients
from propmap.solve.disk import DiskSolution
from propmap.solve.load_slopes import (
    Directions,
    directions_of,
    load_slopes,
    moving,
    with_terms,
)
from propmap.solve.problem import Case
from propmap.typing import Floats

FIT_BLOCK = 8
"""Operating points per call if there are few: as many as fit in a vector register.  The program
compiles in a third less time than one for 32."""

ALIKE_BLOCK = 32
"""The same where there are many: half as long per point, and the program takes longer to
compile."""

TURNING = 4
"""Azimuths that tell how loads leave axial flow with the in-plane velocity: the mean of sin(psi)^2
is theirs.  In axial flow itself the loads are those of a single azimuth."""


def load_gradients(
    rotor: Prepared,
    setting: Accuracy,
    names: tuple[str, ...],
    omega: Floats,
    v_axial: Floats,
    v_inplane: Floats,
    *,
    alike: bool = False,
) -> LoadGradients:
    """Loads at N operating points and their derivatives by P of ``load_slopes.moving``.

    The derivatives follow from the implicit function theorem at the inflow found, without another
    search.  Fewer than ``FEW`` points all get the same nodes, see ``plan.plan``: the loads then
    differ from those of ``evaluation.evaluate`` within the accuracy asked for.

    Parameters
    ----------
    rotor, setting : Prepared, Accuracy
        As for ``evaluation.evaluate``.
    names : tuple of str
        The parameters; those of ``load_slopes.GEOMETRY`` too.
    omega, v_axial, v_inplane : ndarray, shape (N,)
        [rad/s], [m/s]; v_inplane >= 0.
    alike : bool
        Whether any number of points gets the same nodes, so that a single pair of programs is
        compiled for a large batch, too.
    """
    rotor = _with_terms(rotor, names)
    size = ALIKE_BLOCK if alike else FIT_BLOCK if omega.size < FEW else None
    down = v_axial < 0.0
    if not down.any():
        flow = Flow(omega, v_axial, v_inplane, None)
        return _gradients(rotor, setting, names, flow, None, size)
    v_hover, v_hover_slope = np.zeros_like(omega), np.zeros((len(names), omega.size))
    rates, where = np.unique(omega[down], return_inverse=True)
    still, no = np.zeros_like(rates), np.zeros((len(names), rates.size))
    static = _gradients(rotor, setting, names, Flow(rates, still, still, still), no, size)
    v, slope = _static_inflow(rotor, names, static)
    v_hover[down] = v[where]
    v_hover_slope[:, down] = slope[:, where]
    flow = Flow(omega, v_axial, v_inplane, v_hover)
    return _gradients(rotor, setting, names, flow, v_hover_slope, size)


def _with_terms(rotor: Prepared, names: tuple[str, ...]) -> Prepared:
    """The rotor with those terms of its law among ``names`` that were left out of it as zero."""
    arrays = with_terms(rotor.arrays, names)
    if arrays is rotor.arrays:
        return rotor
    return prepare(arrays, uniform=rotor.uniform, double=rotor.double)


def _gradients(
    rotor: Prepared,
    setting: Accuracy,
    names: tuple[str, ...],
    flow: Flow,
    v_hover_slope: Floats | None,
    size: int | None,
) -> LoadGradients:
    """``load_gradients`` with known static inflow and its derivatives (D, N) along directions.

    ``size`` is the number of points per block, all with the same nodes; None as in a plain batch.
    """
    points = flow.omega.size
    few = size is not None
    slopes = np.full((len(LOADS), len(names), points), np.nan)
    ways = directions_of(moving(rotor.arrays), names, len(names))

    def differentiate(block: Block, solution: DiskSolution) -> None:
        solution = jax.tree.map(np.asarray, solution)
        # Programs made of many kernels get few points, so that their arrays fit in the cache.
        width = block.size if use_lanes(block.panels) else min(BLOCK, block.size)
        program = _program(block.panels, in_groups(width, block.panels))
        for start in range(0, block.points.size, width):
            part = slice(start, start + width)
            points, azimuths = block.points[part], block.azimuths[part]
            piece = block._replace(points=points, azimuths=azimuths, size=width)
            which, kept = piece.padded, piece.points
            mine = jax.tree.map(functools.partial(_some, part), solution)
            if "v_inplane" in names:
                piece = piece._replace(azimuths=np.maximum(azimuths, TURNING))
                mine = _with_harmonics(rotor.arrays, mine)
            along = None if v_hover_slope is None else v_hover_slope[:, which]
            nodes = nodes_of(piece, few=few)
            asked = (flow.part(which), mine, ways, along, nodes, kept.size)
            found = program(rotor.on_device, *asked)
            by_name = np.asarray(found).transpose(1, 0, 2)
            slopes[:, :, kept] = by_name[:, :, : kept.size]

    if size is not None and names:
        sized = setting.for_stall(rotor.forecast.stall_width)
        _compile_both(rotor, sized, names, size, descends=flow.v_hover is not None)
    flat = evaluate_flow(
        rotor, setting, flow, alike=few, size=size, solved=differentiate if names else None
    )
    return LoadGradients(np.stack(flat.loads), slopes)


def _with_harmonics(rotor: RotorArrays, solution: DiskSolution) -> DiskSolution:
    """The solution with the harmonics of axial flow, zero, where these were not looked for."""
    if rotor.shape is None or solution.harmonics is not None:
        return solution
    none: Any = np.zeros_like(solution.inflow[0])
    return solution._replace(harmonics=Harmonics(none, none, none))


def _some(points: slice, values: Any) -> Any:
    return values[..., points]


def _static_inflow(
    rotor: Prepared, names: tuple[str, ...], static: LoadGradients
) -> tuple[Floats, Floats]:
    """v_h (N,) [m/s], eq. (12), and its derivatives (P, N) by ``names``."""
    # v_h is that of a rotor at rest in the air, whatever the flow is that it is used in.
    at_rest = np.array([name in ("v_axial", "v_inplane") for name in names], bool)[:, None]
    thrust, slope = static.loads[0], np.where(at_rest, 0.0, static.slopes[0])
    # By NumPy: the number of points differs from call to call, and JAX would compile for each.
    with by_numpy():
        v: Any = static_inflow(thrust, rotor.arrays.medium.density, rotor.arrays.blade.tip)
    lifting = v > 0.0
    return v, np.where(lifting, 0.5 * v / np.where(lifting, thrust, 1.0), 0.0) * slope


_COMPILED: set[tuple[Accuracy, int, tuple[str, ...], int, bool]] = set()


def _compile_both(
    rotor: Prepared, setting: Accuracy, names: tuple[str, ...], size: int, *, descends: bool
) -> None:
    """Compile the two programs for few points at the same time instead of one after the other."""
    key = (setting, rotor.arrays.blade.station.size, names, size, descends)
    if key in _COMPILED:
        return
    _COMPILED.add(key)
    panels, still = alike_panels(setting), np.zeros(size)
    nodes = nodes_of_each(np.ones(size, int), setting.most_azimuths)
    flow = Flow(still, still, still, still if descends else None)
    slopes = np.zeros((len(names), size)) if descends else None
    lanes = in_groups(size, panels)
    search = compiled_search(panels, axial=False, lanes=lanes)
    differentiate = _program(panels, lanes)
    arguments = (rotor.on_device, flow, nodes, size)

    def run_slopes(*here: Any) -> None:
        with jax.enable_x64(True):
            differentiate(rotor.on_device, *here)

    with jax.enable_x64(True), ThreadPoolExecutor(1) as beside:
        _, shapes = search.eval_shape(*arguments)
        solution = jax.tree.map(lambda a: np.zeros(a.shape, a.dtype), shapes)
        ways = directions_of(moving(rotor.arrays), names, len(names))
        here = (flow, solution, ways, slopes, nodes, size)
        # The derivatives first: XLA takes longest for them, in other threads, while Python goes on.
        differentiate.lower(rotor.on_device, *here)
        differentiated = beside.submit(run_slopes, *here)
        search(*arguments)
        differentiated.result()


@functools.cache
def _program(panels: tuple[int, ...], lanes: bool) -> Any:
    """Program for the derivatives (D, L, B) along directions, at a solution of (11)."""

    def slopes(
        rotor: RotorArrays,
        flow: Any,
        solution: DiskSolution,
        directions: Directions,
        v_hover_slopes: Any,
        azimuth: AzimuthNodes,
        used: Any,
    ) -> Any:
        same = isinstance(azimuth.count, int)

        def few(shared: Any, each: Any) -> Any:
            arrays, ways = shared
            here, found, moving, own = each
            nodes = azimuth if same else own
            return load_slopes(Case(arrays, *here), found, panels, nodes, ways, moving)

        shared = (rotor, directions)
        each = (flow, solution, v_hover_slopes, None if same else azimuth)
        if lanes:
            return in_lanes(few, shared, each, used, together=1)
        return few(shared, each)

    return jax.jit(slopes, compiler_options=with_lanes(COMPILER_OPTIONS, lanes))
