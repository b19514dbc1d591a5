"""What a state of the inflow does to the loads, beside the static solution."""

from __future__ import annotations

from typing import NamedTuple

from propmap.arrays.namespace import Array, stop_gradient, xp
from propmap.physics.element import AnnulusLoads
from propmap.physics.inflow_harmonics import Harmonics
from propmap.physics.velocities import AzimuthNodes
from propmap.solve.disk import DiskSolution, disk_inflow
from propmap.solve.harmonics import loads_and_slopes
from propmap.solve.problem import Case
from propmap.solve.rotor_loads import harmonic_problem


class StateLoads(NamedTuple):
    """Loads at a state of the inflow, and what its motion depends on; arrays (B,).

    Attributes
    ----------
    steady : Harmonics
        The static solution [m/s]; its mean is the whole mean inflow over the disk.
    mass_flow : Array
        ``DiskFlow.mass_flow`` there [m/s].
    by_thrust, by_roll, by_pitch : Array
        Gains of ``HarmonicResponse``, not faded out in the vortex ring [s/m^3], [s/m^4], [s/m^4].
    change : AnnulusLoads
        Loads of the rotor per density, minus those at the static solution.
    slopes : tuple of 3 AnnulusLoads
        Their derivatives with the three ``Harmonics``, at the static solution.
    """

    steady: Harmonics
    mass_flow: Array
    by_thrust: Array
    by_roll: Array
    by_pitch: Array
    change: AnnulusLoads
    slopes: tuple[AnnulusLoads, ...]


def state_loads(
    case: Case,
    solution: DiskSolution,
    state: Array,
    panels: tuple[int, ...],
    azimuth: AzimuthNodes,
) -> StateLoads:
    """Loads with the inflow of a state instead of the static one, eqs. (13)-(15).

    The inflow at a blade element is that of the static solution, its mean and its gradients
    replaced by those of the state.

    Parameters
    ----------
    case : Case
        The case that was solved; its rotor has a shape of the inflow.
    solution : DiskSolution
        Its solution.
    state : Array, shape (3, B)
        Mean inflow, v_s and v_c [m/s].
    panels : tuple of int
        Radial nodes on each panel, those of the solution.
    azimuth : AzimuthNodes
        Azimuths to average over, several of them.
    """
    case = stop_gradient(case)
    shape = case.rotor.shape
    if shape is None:
        raise ValueError("the rotor's inflow has no shape")
    problem = harmonic_problem(case, disk_inflow(case, solution, panels, azimuth))
    mean, found = problem.flow.inflow, solution.harmonics
    if found is None:  # axial flow
        none = xp.zeros_like(mean)
        found = Harmonics(none, none, none)
    there, slopes, _ = loads_and_slopes(problem, found, azimuth)
    asked = Harmonics(state[0] - mean, state[1], state[2])
    here, _, _ = loads_and_slopes(problem, asked, azimuth)
    gains = shape.response(problem.flow, problem.at.tip)
    return StateLoads(
        found._replace(mean=mean + found.mean),
        problem.flow.mass_flow,
        gains.by_thrust,
        gains.by_roll,
        gains.by_pitch,
        AnnulusLoads(*(a - b for a, b in zip(here, there, strict=True))),
        slopes,
    )
