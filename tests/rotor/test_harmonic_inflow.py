"""Loads with an inflow that varies around the disk."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import propmap as pm
from propmap.arrays.namespace import by_numpy
from propmap.loads import LOADS
from propmap.physics.inflow_harmonics import DiskFlow
from propmap.physics.velocities import azimuth_nodes
from propmap.solve.disk import DiskSolution
from propmap.solve.harmonics import HarmonicProblem, find_harmonics, loads_and_slopes
from propmap.solve.load_slopes import directions_of, load_slopes, moving
from propmap.solve.problem import Case
from propmap.solve.rotor_loads import RotorLoads, harmonic_problem, search_loads, solve_disk
from tests.oracle.make_harmonic_reference import LOADS as SIX
from tests.oracle.make_harmonic_reference import (
    POINTS,
    TABLE,
    HarmonicRow,
    harmonic_row,
    questions,
)

BLADE = pm.propeller("apc-8x6e")
NAMES = ("pitt-peters", "pitt-peters-gradient", "coleman", "drees", "white-blake")
OBLIQUE = (600.0, np.array([4.0, 9.0, 14.0]), np.radians([80.0, 60.0, 85.0]))


def rotor(name: str | None, law: str = "paper-apc", *, compiled: bool = False) -> pm.Rotor:
    corrections = (pm.correction(name),) if name else ()
    model = pm.Model(BLADE, pm.airfoil(law), corrections=corrections)
    return pm.Rotor(model, compiled=compiled)


def frozen() -> list[HarmonicRow]:
    header, *rows = (line.split(",") for line in TABLE.read_text(encoding="utf-8").splitlines())
    assert tuple(header) == HarmonicRow._fields
    return [HarmonicRow(row[0], *map(float, row[1:])) for row in rows]


def errors(got: pm.Loads, rows: list[HarmonicRow]) -> dict[str, np.ndarray]:
    """As shares of static thrust, static thrust times R and static torque."""
    scale = {"thrust": np.array([row.static_thrust for row in rows])}
    scale["torque"] = np.array([row.static_torque for row in rows])
    found = {}
    for name in SIX:
        load = LOADS[name]
        unit = scale[load.scale] * (1.0 if load.unit == LOADS[load.scale].unit else BLADE.radius)
        want = np.array([getattr(row, name) for row in rows])
        found[name] = np.abs(getattr(got, name) - want) / unit
    return found


@pytest.mark.parametrize("law", ["soft", "stiff", "apc"])
def test_loads_agree_with_the_literal_reference(law: str) -> None:
    """0.1 % of static loads at 200 points, which SciPy solved."""
    rows = [row for row in frozen() if row.set == law]
    assert len(rows) >= POINTS // 3
    flow = np.array([row[1:4] for row in rows])
    velocity = np.stack([flow[:, 2], 0.0 * flow[:, 2], flow[:, 1]], axis=-1)
    got = rotor("pitt-peters", f"paper-{law}").loads_at_velocity(flow[:, 0], velocity)
    for name, error in errors(got, rows).items():
        assert error.max() < 1e-3, (name, rows[int(error.argmax())])


@pytest.mark.slow
def test_the_frozen_rows_are_what_the_literal_code_gives() -> None:
    rows, asked = frozen(), questions()
    # Each law, in climb and in descent.
    for k in range(0, POINTS, 41):
        assert harmonic_row(asked[k])[1:] == pytest.approx(rows[k][1:], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_axial_flow_is_that_of_the_paper(name: str) -> None:
    """Climb, rest, vortex ring and windmill."""
    points = (
        600.0,
        np.array([8.0, 0.0, 4.0, 6.0, 14.0]),
        np.array([0.0, 0.0, np.pi, np.pi, np.pi]),
    )
    want, got = rotor(None).loads(*points), rotor(name).loads(*points)
    for load in LOADS:
        np.testing.assert_allclose(getattr(got, load), getattr(want, load), atol=1e-12)
    assert (want.status == got.status).all()


def test_an_inflow_without_harmonics_has_no_force_across() -> None:
    found = rotor(None).loads(*OBLIQUE)
    assert (found.side_force == 0.0).all()
    assert (found.pitch_moment == 0.0).all()


def test_each_shape_has_loads_of_its_own() -> None:
    rolls = [rotor(name).loads(*OBLIQUE).roll_moment for name in (None, *NAMES)]
    pitches = [rotor(name).loads(*OBLIQUE).pitch_moment for name in (None, *NAMES)]
    for k in range(len(rolls)):
        for other in range(k):
            assert (np.abs(pitches[k] - pitches[other]) > 1e-5).all()
    assert (rolls[1] < 0.9 * rolls[0]).all()  # the moments' feedback
    assert (np.array(pitches[1:]) > 0.0).all()  # less lift at the rear: nose up


def test_the_harmonics_belong_to_the_loads() -> None:
    """The equations of Pitt and Peters hold at what was found, feedback included."""
    arrays = rotor("pitt-peters").arrays
    omega, speed, beta = (np.broadcast_to(a, 3).astype(float) for a in OBLIQUE)
    case = Case(arrays, omega, speed * np.cos(beta), speed * np.sin(beta), None)
    nodes = azimuth_nodes(32)
    with by_numpy():
        _, disk = solve_disk(case, (12, 12, 12), nodes)
        problem: HarmonicProblem = harmonic_problem(case, disk)
        found = find_harmonics(problem, nodes)
        loads, _, _ = loads_and_slopes(problem, found.harmonics, nodes)
    flow: DiskFlow = problem.flow
    area, radius = np.pi * BLADE.radius**2, BLADE.radius
    chi = np.arctan2(flow.v_inplane, np.abs(flow.v_axial + flow.inflow))
    lateral = 4.0 / (1.0 + np.cos(chi)) * loads.roll_moment / (area * radius * flow.mass_flow)
    rear = -loads.pitch_moment / (area * radius * flow.mass_flow)
    longitudinal = (
        15.0 * np.pi / 64.0 * np.tan(0.5 * chi) * loads.thrust / (area * flow.mass_flow)
        + 4.0 * np.cos(chi) / (1.0 + np.cos(chi)) * rear
    )
    np.testing.assert_allclose(found.harmonics.lateral, lateral, rtol=1e-5)
    np.testing.assert_allclose(found.harmonics.longitudinal, longitudinal, rtol=1e-5)
    # The loads given are those of the last step, followed to its end by their slopes.
    for given, own in zip(found.loads, loads, strict=True):
        np.testing.assert_allclose(given, own, atol=1e-6 * loads.thrust.max())


@pytest.mark.parametrize("beta", [np.pi / 2, 0.0, np.radians(110.0)])
def test_loads_are_continuous(beta: float) -> None:
    """Through edgewise and axial flow, and where the vortex ring fades in."""
    angle = beta + 1e-4 * np.arange(-3.0, 4.0)
    found = rotor("pitt-peters").loads(600.0, 6.0, angle)
    for load in LOADS:
        values = getattr(found, load)
        steps = np.abs(np.diff(values))
        assert steps.max() < 3e-4 * np.abs(found.thrust).max(), load


@pytest.mark.slow
def test_compiled_programs_agree_with_numpy() -> None:
    omega = np.random.default_rng(5).uniform(200.0, 900.0, 60)
    points = (omega, np.linspace(0.0, 18.0, 60), np.linspace(0.0, 2.0, 60))
    want, got = (
        rotor("pitt-peters").loads(*points),
        rotor("pitt-peters", compiled=True).loads(*points),
    )
    assert (want.status == got.status).all()
    for load in LOADS:
        a, b = getattr(got, load), getattr(want, load)
        np.testing.assert_allclose(a, b, atol=1e-7 * np.abs(want.thrust).max())


@pytest.mark.slow
def test_derivatives_agree_with_differences(monkeypatch: pytest.MonkeyPatch) -> None:
    """To 1e-6 of the largest derivative, at nodes that stay where they are.

    The harmonics are solved to the end here: what the search leaves off, 1e-7 of the loads, would
    be divided by the differences' step.
    """
    from propmap.solve import harmonics

    monkeypatch.setattr(harmonics, "CLOSE", 1e-9)
    names = ("omega", "v_axial", "v_inplane", "c_l1", "c_d", "alpha_0", "zero_lift_angle")
    arrays = rotor("pitt-peters").arrays
    flow = {
        "omega": np.array([500.0, 620.0, 800.0, 600.0]),
        "v_axial": np.array([3.0, 1.0, 6.0, -0.5]),
        "v_inplane": np.array([6.0, 12.0, 9.0, 11.0]),
    }
    panels, nodes = (40,), azimuth_nodes(32)

    def solved(change: dict[str, float]) -> tuple[Case, RotorLoads, DiskSolution]:
        law = {name: by for name, by in change.items() if name not in flow}
        moved = (flow[name] + change.get(name, 0.0) for name in flow)
        case = Case(arrays._replace(law=arrays.law.plus(**law)), *moved, None)  # type: ignore[arg-type]
        return case, *search_loads(case, panels, nodes)

    with by_numpy():
        ends = {
            name: [np.stack(solved({name: by})[1].loads) for by in (1e-5, -1e-5)] for name in names
        }
        case, _, solution = solved({})
    movable = moving(arrays)
    with jax.enable_x64(True):
        found = load_slopes(
            jax.tree.map(jnp.asarray, case),
            jax.tree.map(jnp.asarray, solution),
            panels,
            nodes,
            directions_of(movable, names, len(names)),
            None,
        )
    for name, got in zip(names, np.asarray(found), strict=True):
        want = (ends[name][0] - ends[name][1]) / 2e-5
        scale = np.abs(want).max(axis=1, keepdims=True)
        assert (scale > 0.0).all()
        assert (np.abs(got - want) <= 1e-6 * scale).all(), name


def test_a_mirrored_rotor_has_a_mirrored_wrench() -> None:
    """About the plane of symmetry y = 0: force (x, -y, z), moment (-x, y, -z)."""
    one = rotor("pitt-peters")
    ccw = one.wrench(600.0, [7.0, 3.0, 2.0], "ccw")
    cw = one.wrench(600.0, [7.0, -3.0, 2.0], "cw")
    np.testing.assert_allclose(cw.force, ccw.force * [1.0, -1.0, 1.0], rtol=1e-12)
    np.testing.assert_allclose(cw.moment, ccw.moment * [-1.0, 1.0, -1.0], rtol=1e-12)


def test_the_wrench_has_all_six_loads() -> None:
    one, omega = rotor("pitt-peters"), 600.0
    loads, wrench = one.loads(omega, 10.0, np.pi / 2), one.wrench(omega, [10.0, 0.0, 0.0])
    np.testing.assert_allclose(wrench.force, [-loads.drag, loads.side_force, loads.thrust])
    # Nose up is about -y where x points forward and z up.
    turning = [-loads.roll_moment, -loads.pitch_moment, -loads.torque]
    np.testing.assert_allclose(wrench.moment, turning)
    assert loads.pitch_moment > 0.0
