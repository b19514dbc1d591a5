"""A vehicle in MuJoCo: forces beside ``VehicleForces``, flights beside mechanics, bad models."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import propmap
from propmap import InputError, VehicleForces
from propmap.export import export_vehicle
from propmap.vehicle.vehicle import Body, Mount, Vehicle
from tests.export.needed import package
from tests.export.test_vehicle_export import ASKEW, PLAIN, VEHICLES, WAKES, table_of
from tests.vehicle.test_vehicle_wrench import IN_WAKES, QUAD, ROTOR, SYMMETRIC

mujoco = package("mujoco")
sim = package("propmap.sim.mujoco")

INERTIA = (0.004, 0.005, 0.008)
GRAVITY = 9.81
LAG = 0.03
CENTER = (0.02, -0.01, 0.03)


def mjcf(
    vehicle: Vehicle,
    *,
    option: str = "",
    center: tuple[float, float, float] = (0.0, 0.0, 0.0),
    actuator: str = f'dyntype="filter" dynprm="{LAG}" gainprm="0"',
) -> str:
    """The vehicle, with its center of mass at ``center`` of its body's frame."""

    def words(vector: Any) -> str:
        return " ".join(repr(float(x)) for x in vector)

    sites = "\n".join(
        f'<site name="rotor_{k}" pos="{words(np.add(mount.position, center))}"'
        f' zaxis="{words(mount.axis)}"/>'
        for k, mount in enumerate(vehicle.mounts, start=1)
    )
    actuators = "\n".join(
        f'<general name="rotor_{k}" site="rotor_{k}" {actuator}/>'
        for k in range(1, len(vehicle.mounts) + 1)
    )
    return f"""<mujoco>
<option timestep="0.001" integrator="RK4" {option}/>
<worldbody>
<body name="quad">
<freejoint/>
<inertial pos="{words(center)}" mass="{vehicle.mass}" diaginertia="{words(INERTIA)}"/>
{sites}
</body>
</worldbody>
<actuator>
{actuators}
</actuator>
</mujoco>"""


@pytest.fixture
def fly() -> Iterator[Callable[..., tuple[Any, Any, Any]]]:
    """Make model, state and forces, which act until the test ends."""

    def make(text: str, vehicle: Vehicle, loads: Any, **given: Any) -> tuple[Any, Any, Any]:
        mujoco.set_mjcb_passive(None)  # a model that is compiled is stepped once
        model = mujoco.MjModel.from_xml_string(text)
        forces = sim.MujocoRotors(model, vehicle, loads, **given)
        mujoco.set_mjcb_passive(forces)
        return model, mujoco.MjData(model), forces

    yield make
    mujoco.set_mjcb_passive(None)


def random_state(data: Any, rng: np.random.Generator, low: float, high: float) -> None:
    data.qpos[:3], data.qpos[3:] = rng.normal(0.0, 5.0, 3), rng.normal(0.0, 1.0, 4)
    data.qpos[3:] /= np.linalg.norm(data.qpos[3:])
    data.qvel[:3], data.qvel[3:] = rng.normal(0.0, 3.0, 3), rng.normal(0.0, 1.0, 3)
    data.act[:] = rng.uniform(low, high, data.act.size)
    data.ctrl[:] = data.act


def generalized(model: Any, data: Any, force: Any, moment: Any) -> np.ndarray:
    """The generalized forces of a force and a moment at ``CENTER``, in the vehicle's frame."""
    turn, expected = Rotation.from_quat(data.qpos[[4, 5, 6, 3]]), np.zeros(model.nv)
    place, body = data.qpos[:3] + turn.apply(CENTER), model.body("quad").id
    world = turn.apply(force), turn.apply(moment)
    mujoco.mj_applyFT(model, data, *world, place, body, expected)
    return expected


@pytest.mark.parametrize(
    "case",
    ["askew, with a wing and lift", "askew in wakes, on a wing with a span", "slipstreams"],
)
def test_forces_are_those_of_vehicle_forces(fly: Callable[..., Any], case: str) -> None:
    """At any attitude, spin, motion and wind, with the body's origin beside its center of mass."""
    vehicle = VEHICLES[case]
    loads = table_of(vehicle)
    wind = np.array([2.0, -1.0, 0.5])
    text = mjcf(vehicle, option='wind="2 -1 0.5"', center=CENTER)
    model, data, forces = fly(text, vehicle, loads)
    rng, direct = np.random.default_rng(0), VehicleForces(vehicle, loads)
    compared = 0
    for _ in range(20):
        random_state(data, rng, 450.0, 900.0)
        turn = Rotation.from_quat(data.qpos[[4, 5, 6, 3]])
        rates = data.qvel[3:].copy()
        center = turn.inv().apply(data.qvel[:3]) + np.cross(rates, CENTER)
        want = direct.wrench(data.act, center, rates, turn.inv().apply(wind))
        if np.isnan(want.force).any():
            with pytest.raises(InputError, match="has no loads"):
                mujoco.mj_forward(model, data)
            continue
        compared += 1
        mujoco.mj_forward(model, data)
        expected = generalized(model, data, want.force, want.moment)
        size = np.abs(expected).max()
        np.testing.assert_allclose(data.qfrc_passive, expected, rtol=0.0, atol=1e-12 * size)
        told = forces.wrench(data)
        np.testing.assert_allclose(told.moment, want.moment, rtol=0.0, atol=1e-12 * size)
        assert list(forces.status) == want.rotor_status.tolist()
    assert compared >= 7


class Lagging:
    """Rotors of a vehicle with ``DynamicInflow``, one at a time, in frames of their own."""

    def __init__(self, vehicle: Vehicle) -> None:
        self.vehicle, self.states = vehicle, [None] * len(vehicle.mounts)
        self.direct, self.frames, self.rotors = VehicleForces(vehicle, ROTOR), [], []
        for mount in vehicle.mounts:
            across = np.linalg.svd(np.array([mount.axis]))[2][1]
            self.frames.append(np.stack([across, np.cross(mount.axis, across), mount.axis]))
            model = ROTOR.model if mount.drag is None else ROTOR.model.with_mount(mount.drag)
            self.rotors.append(propmap.DynamicInflow(propmap.Rotor(model), spin=mount.spin))

    def advance(
        self, step: float, omega: Any, velocity: Any, rates: Any, wind: Any
    ) -> tuple[np.ndarray, np.ndarray]:
        """Force and moment at the start of a ``step`` [s]; then the states are those at its end."""
        static = self.direct.wrench(omega, velocity, rates, wind)
        force, moment = static.body_force + static.wing_force, np.zeros(3)
        for k, (mount, frame, rotor) in enumerate(
            zip(self.vehicle.mounts, self.frames, self.rotors, strict=True)
        ):
            hub = frame @ (velocity - wind + np.cross(rates, mount.position))
            hub[2] += static.added_flow[k]
            if self.states[k] is None:
                self.states[k] = rotor.steady(omega[k], hub)
            found, self.states[k] = rotor.advance(self.states[k], step, omega[k], hub)
            push = frame.T @ found.force
            force = force + push
            moment = moment + frame.T @ found.moment + np.cross(mount.position, push)
        return force, moment


@pytest.mark.parametrize("vehicle", [QUAD, IN_WAKES], ids=["alone", "in wakes"])
def test_the_inflow_lags_as_in_dynamic_inflow(fly: Callable[..., Any], vehicle: Vehicle) -> None:
    """Tilted rotors of both spins, one with a mount, while speeds and motion change.

    More evaluations at the same time do not advance the inflow.
    """
    text = mjcf(vehicle, option='wind="2 -1 0.5"', center=CENTER).replace("RK4", "Euler")
    model, data, _ = fly(text, vehicle, ROTOR)
    random_state(data, np.random.default_rng(1), 500.0, 800.0)
    lagging, direct, apart = Lagging(vehicle), VehicleForces(vehicle, ROTOR), 0.0
    for k in range(30):
        data.ctrl[:] = 650.0 + 250.0 * np.sin(k + np.arange(data.ctrl.size))
        data.act[:] += 0.3 * (data.ctrl - data.act)
        turn, rates = Rotation.from_quat(data.qpos[[4, 5, 6, 3]]).inv(), data.qvel[3:].copy()
        center = turn.apply(data.qvel[:3]) + np.cross(rates, CENTER)
        flight = data.act.copy(), center, rates, turn.apply(model.opt.wind)
        wrench = lagging.advance(model.opt.timestep, *flight)
        for again in (mujoco.mj_forward, mujoco.mj_inverse, mujoco.mj_forward):
            again(model, data)
            want = generalized(model, data, *wrench)
            size = np.abs(want).max()
            np.testing.assert_allclose(data.qfrc_passive, want, rtol=0.0, atol=1e-10 * size)
        static = direct.wrench(*flight)
        still = generalized(model, data, static.force, static.moment)
        apart = max(apart, np.abs(want - still).max() / size)
        if k == 0:  # steady at first; the nodes are not those of the static solution
            assert apart < 2e-3
        mujoco.mj_step(model, data)
    assert apart > 0.04


def flown(
    model: Any, data: Any, step: float, *, jump: bool = True, until: float = 0.03
) -> np.ndarray:
    """The motion after rotors without lag jump to other speeds, at 4 ms."""
    model.opt.timestep = step
    while data.time < until - 1e-9:
        faster = jump and data.time > 0.004 - 1e-9
        data.ctrl[:] = [800.0, 750.0, 700.0, 650.0] if faster else 650.0
        mujoco.mj_step(model, data)
    return np.concatenate([data.qpos, data.qvel])


DIRECT = mjcf(SYMMETRIC, actuator='gainprm="0"')


def test_integrators_agree_on_the_inflow_in_the_limit(fly: Callable[..., Any]) -> None:
    """First-order in the step: the inflow steps with the flow at the start."""
    apart, ends = [], {}
    for step in (2e-3, 5e-4):
        for integrator in ("Euler", "RK4", "implicitfast"):
            text = DIRECT.replace("RK4", integrator)
            model, data, _ = fly(text, SYMMETRIC, ROTOR)
            data.qvel[:] = 6.0, 1.0, 0.0, 0.3, -0.2, 0.1
            ends[integrator] = flown(model, data, step)
        apart.append(np.ptp(np.stack(list(ends.values())), axis=0).max())
    assert 3.0 < apart[0] / apart[1] < 5.0 and apart[1] < 0.01


@pytest.mark.parametrize("integrator", ["Euler", "RK4"])
def test_each_data_has_its_inflow(fly: Callable[..., Any], integrator: str) -> None:
    """Interleaved flights, resets, and linearizations do not change a flight."""
    model, data, _ = fly(DIRECT.replace("RK4", integrator), SYMMETRIC, ROTOR)
    want = flown(model, data, 1e-3)
    first, second = mujoco.MjData(model), mujoco.MjData(model)
    for end in np.arange(1, 31) * 1e-3:
        one = flown(model, first, 1e-3, until=end)
        flown(model, second, 1e-3, until=end, jump=False)
    np.testing.assert_array_equal(one, want)
    assert np.abs(second.qvel - first.qvel).max() > 0.1
    for steps in (1, 2, 30):  # number of steps since the last reset
        mujoco.mj_resetData(model, data)
        np.testing.assert_array_equal(flown(model, data, 1e-3), want)
        mujoco.mj_resetData(model, data)
        flown(model, data, 1e-3, until=steps * 1e-3)
    # Within a step, the inflow changes linearly, and so nearly does the thrust.
    mujoco.mj_resetData(model, data)
    flown(model, data, 1e-3, until=6e-3)
    start, thrusts = data.time, []
    for share in (0.0, 0.5, 1.0):
        data.time = start + share * 1e-3
        mujoco.mj_forward(model, data)
        thrusts.append(data.qfrc_passive[2])
    assert thrusts[1] - thrusts[0] == pytest.approx(0.5 * (thrusts[2] - thrusts[0]), rel=0.01)
    if integrator == "RK4":  # for which MuJoCo does not linearize
        return
    # While the inflow lags, at 6 ms: forward differences would notice if it jumped.
    mujoco.mj_resetData(model, data)
    flown(model, data, 1e-3, until=6e-3)
    found = []
    for centered in (False, True):
        found.append(np.empty((12, 12)))
        rest = np.empty((12, 4)), None, None
        mujoco.mjd_transitionFD(model, data, 1e-6, centered, found[-1], *rest)
    np.testing.assert_allclose(*found, atol=1e-5)
    np.testing.assert_array_equal(flown(model, data, 1e-3), want)


SQUARE = replace(
    PLAIN,
    mounts=tuple(replace(m, position=tuple(0.16 * np.sign(m.position))) for m in PLAIN.mounts),
)


def test_hover_holds_and_rotors_lag(fly: Callable[..., Any]) -> None:
    table = table_of(SQUARE)
    model, data, forces = fly(mjcf(SQUARE), SQUARE, table)
    share = SQUARE.mass * GRAVITY / 4.0
    omega = float(table.omega_for("thrust", share, 0.0, 0.0).omega)
    data.act[:] = data.ctrl[:] = omega
    while data.time < 1.0:
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.qpos, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], atol=1e-9)
    assert forces.worst_status == ("ok",) * 4
    # A faster command lifts it; the speed follows with the lag.
    data.ctrl[:] = 1.1 * omega
    start = data.time
    while data.time - start < 0.05 - 1e-9:
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.act, omega * (1.1 - 0.1 * np.exp(-0.05 / LAG)), rtol=1e-9)
    assert data.qvel[2] > 0.01


def test_without_a_lag_the_command_is_the_speed(fly: Callable[..., Any]) -> None:
    table = table_of(SQUARE)
    actuator = 'gainprm="0" ctrlrange="300 700"'
    model, data, _ = fly(mjcf(SQUARE, actuator=actuator), SQUARE, table)
    lifts = []
    for command in (500.0, 700.0, 900.0):
        data.ctrl[:] = command
        mujoco.mj_forward(model, data)
        lifts.append(data.qfrc_passive[2])
    thrust = [4.0 * table.loads(omega, 0.0, 0.0).thrust for omega in (500.0, 700.0)]
    np.testing.assert_allclose(lifts, [*thrust, thrust[1]], rtol=1e-12)


@pytest.mark.parametrize("exact", [False, True])
def test_angular_momentum_of_vehicle_and_rotors_is_kept(
    fly: Callable[..., Any], exact: bool
) -> None:
    """In space: rotors that change their speed turn the vehicle, and are gyroscopes.

    With exact filters about the axis: Euler's steps take the mean change of speed over a step.
    """
    heavy, mounts = 3e-5, PLAIN.mounts if exact else ASKEW
    vehicle = replace(PLAIN, mounts=mounts, rotor_inertia=heavy, body=Body())
    text = mjcf(vehicle, option='gravity="0 0 0"')
    if exact:
        text = text.replace("RK4", "Euler").replace('"filter"', '"filterexact"')
    model, data, forces = fly(text, vehicle, table_of(vehicle, scale=0.0), clamp=True)
    spin = np.array([{"ccw": 1.0, "cw": -1.0}[mount.spin] for mount in mounts])
    data.act[:] = 500.0
    if exact:
        data.ctrl[:] = 500.0 + 300.0 * (spin > 0.0)
    else:
        data.ctrl[:], data.qvel[3:] = [300.0, 700.0, 800.0, 900.0], [1.0, -0.7, 0.4]

    def momentum() -> np.ndarray:
        turn = Rotation.from_quat(data.qpos[[4, 5, 6, 3]])
        rotors = heavy * (spin * data.act) @ forces.vehicle.rotor_axes
        return turn.apply(np.array(INERTIA) * data.qvel[3:] + rotors)

    before, rates = momentum(), data.qvel[3:].copy()
    while data.time < 0.5:
        mujoco.mj_step(model, data)
    assert np.abs(data.qvel[3:] - rates).max() > 0.5
    atol = 1e-9 if exact else 1e-6 * np.abs(before).max()
    np.testing.assert_allclose(momentum(), before, rtol=0.0, atol=atol)


# --- Missing loads, and samples that the model does not describe ----------------------------------


@pytest.mark.parametrize("wakes", [None, WAKES], ids=["alone", "wakes"])
def test_a_table_that_does_not_cover_the_flight_is_told(
    fly: Callable[..., Any], wakes: Any
) -> None:
    """With wakes, the flow at the other rotors is unknown too, but they are not the cause."""
    vehicle = replace(PLAIN, wakes=wakes)
    model, data, forces = fly(mjcf(vehicle), vehicle, table_of(vehicle))
    data.act[:], data.ctrl[:] = [600.0, 600.0, 150.0, 600.0], 600.0
    with pytest.raises(InputError, match=r"rotor_3 has no loads \(outside\), at 150 rad/s") as told:
        mujoco.mj_step(model, data)
    assert "\n" not in str(told.value) and "clamp=True" in str(told.value)
    others = "ok" if wakes is None else "outside"
    assert forces.status == (others, others, "outside", others)
    assert np.isnan(forces.wrench(data).thrust[2])
    mujoco.mj_resetData(model, data)
    data.act[:] = data.ctrl[:] = 600.0
    mujoco.mj_step(model, data)
    assert np.isfinite(data.qpos).all()
    assert forces.status == ("ok",) * 4 and forces.worst_status[2] == "outside"


@pytest.mark.parametrize("clamp", [False, True])
@pytest.mark.parametrize("wakes", [None, WAKES], ids=["alone", "wakes"])
def test_a_command_that_is_no_number_is_told(
    fly: Callable[..., Any], wakes: Any, clamp: bool
) -> None:
    vehicle = replace(PLAIN, wakes=wakes)
    model, data, _ = fly(mjcf(vehicle), vehicle, table_of(vehicle), clamp=clamp)
    data.act[:], data.ctrl[:] = 600.0, [600.0, np.nan, 600.0, 600.0]
    with pytest.raises(InputError, match="the command or the speed of rotor_2 is not finite"):
        mujoco.mj_step(model, data)
    data.ctrl[:] = 600.0
    data.act[:] = [600.0, -600.0, 600.0, 600.0]
    with pytest.raises(InputError, match="the speed of rotor_2 is -600 rad/s"):
        mujoco.mj_step(model, data)


@pytest.mark.parametrize("wakes", [None, WAKES], ids=["alone", "wakes"])
def test_beyond_the_table_by_its_nearest_point(fly: Callable[..., Any], wakes: Any) -> None:
    vehicle = replace(PLAIN, wakes=wakes)
    model, data, forces = fly(mjcf(vehicle), vehicle, table_of(vehicle), clamp=True)
    lifts = []
    for omega in (150.0, 200.0):
        data.act[:] = data.ctrl[:] = omega
        mujoco.mj_forward(model, data)
        lifts.append(data.qfrc_passive[2])
        if omega < 200.0:
            assert forces.status == ("clamped",) * 4
            assert set(forces.wrench(data).rotor_status) == {"clamped"}
            assert forces.wrench(data).force[2] == pytest.approx(lifts[0], rel=1e-9)
    assert lifts[0] == pytest.approx(lifts[1], rel=1e-12) and lifts[0] > 0.0


def test_the_vortex_ring_is_told(fly: Callable[..., Any]) -> None:
    model, data, forces = fly(mjcf(PLAIN), PLAIN, table_of(PLAIN, gap=True))
    found = set()
    for speed in np.linspace(0.0, 10.0, 30):
        for angle in np.linspace(0.0, np.pi, 13):
            data.qvel[:3] = speed * np.sin(angle), 0.0, speed * np.cos(angle)
            data.act[:] = data.ctrl[:] = 600.0
            try:
                mujoco.mj_forward(model, data)
            except InputError as error:
                assert "(no_value)" in str(error) or "(outside)" in str(error)
            found |= set(forces.status)
    assert {"ok", "vortex_ring", "unresolved", "no_value"} <= found


def test_other_models_are_left_alone(fly: Callable[..., Any]) -> None:
    text = mjcf(PLAIN)
    model, data, _ = fly(text, PLAIN, table_of(PLAIN))
    data.act[:] = data.ctrl[:] = 600.0
    mujoco.set_mjcb_passive(None)  # a model that is compiled is stepped once
    other = mujoco.MjModel.from_xml_string(text.replace("quad", "ball"))
    same = mujoco.MjModel.from_xml_string(text)
    forces = sim.MujocoRotors(model, PLAIN, table_of(PLAIN))
    mujoco.set_mjcb_passive(forces)
    for one, lifted in ((other, False), (same, True), (model, True)):
        state = mujoco.MjData(one)
        state.act[:] = state.ctrl[:] = 600.0
        mujoco.mj_forward(one, state)
        assert (state.qfrc_passive[2] > 0.0) == lifted


@pytest.mark.parametrize("on_core", [False, True], ids=["table", "core"])
def test_rollouts_in_threads_are_the_flights(fly: Callable[..., Any], on_core: bool) -> None:
    rollout = package("mujoco.rollout")
    vehicle = SYMMETRIC if on_core else PLAIN
    model, data, _ = fly(mjcf(vehicle), vehicle, ROTOR if on_core else table_of(PLAIN))
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    data.act[:], data.qvel[0] = 600.0, 1.0
    start = np.empty(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, start, kind)
    commands = np.broadcast_to(np.linspace(580.0, 640.0, 8)[:, None, None], (8, 50, 4)).copy()
    threads = [mujoco.MjData(model) for _ in range(8)]
    states, _ = rollout.rollout(model, threads, np.tile(start, (8, 1)), commands)
    for command, found in zip(commands, states, strict=True):
        mujoco.mj_setState(model, data, start, kind)
        data.ctrl[:] = command[0]
        for _ in range(50):
            mujoco.mj_step(model, data)
        np.testing.assert_array_equal(found[-1, 1 : 1 + model.nq], data.qpos)


@pytest.mark.filterwarnings("ignore:.*QACC")
def test_a_rollout_without_loads_stops_in_its_thread(fly: Callable[..., Any]) -> None:
    """MuJoCo resets the flight and repeats its state to the end; the other flights go on."""
    rollout = package("mujoco.rollout")
    model, data, forces = fly(mjcf(PLAIN), PLAIN, table_of(PLAIN))
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    data.act[:] = 600.0
    start = np.empty(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, start, kind)
    commands = np.full((16, 80, 4), 600.0)
    commands[::2] = 100.0  # slower than the table
    threads = [mujoco.MjData(model) for _ in range(8)]
    states, _ = rollout.rollout(model, threads, np.tile(start, (16, 1)), commands)
    np.testing.assert_allclose(states[1::2, -1, 0], 0.08)
    assert (states[::2, -1, 0] == 0.001).all() and forces.worst_status == ("outside",) * 4


GOOD = mjcf(PLAIN)
SITE = re.search(r'<site name="rotor_4".*', GOOD)
ACTUATOR = re.search(r'<general name="rotor_4".*', GOOD)
assert SITE is not None and ACTUATOR is not None
WRONG: dict[str, tuple[str, dict[str, Any], str]] = {
    "a rotor without a site": (
        GOOD.replace('name="rotor_4" pos', 'name="x" pos').replace('site="rotor_4"', 'site="x"'),
        {}, "has no site 'rotor_4'"
    ),
    "a site without a rotor": (
        GOOD.replace(SITE[0], SITE[0] + SITE[0].replace("rotor_4", "rotor_5")),
        {}, "the site 'rotor_5' belongs to no rotor: the vehicle has 4"
    ),
    "a rotor without an actuator": (GOOD.replace(ACTUATOR[0], ""), {}, "no actuator 'rotor_4'"),
    "two names alike": (
        GOOD, {"names": ("rotor_1", "rotor_2", "rotor_1", "rotor_4")},
        "two rotors are named 'rotor_1'"
    ),
    "too few names": (GOOD, {"names": ("rotor_1", "rotor_2")}, "2 names are given, the vehicle"),
    "names in another order": (
        GOOD, {"names": ("rotor_2", "rotor_1", "rotor_3", "rotor_4")}, "in the vehicle's order"
    ),
    "grams": (
        GOOD.replace('mass="1.2"', 'mass="1200"').replace('"0.004 0.005 0.008"', '"4 5 8"'),
        {}, "has 1200 kg, the vehicle file 1.2 kg; MJCF is in kg, not g"
    ),
    "millimeters": (
        mjcf(replace(PLAIN, mounts=tuple(
            replace(m, position=tuple(1e3 * x for x in m.position)) for m in PLAIN.mounts))),
        {}, "is at (160, 170, 20) m from the center of mass, the vehicle's rotor at "
        "(0.16, 0.17, 0.02) m; MJCF is in m, not mm"
    ),
    "a limited activation": (
        GOOD.replace('dyntype="filter"', 'dyntype="filter" actlimited="true" actrange="0 600"'),
        {}, "the activation of the actuator 'rotor_1' is limited; limit ctrl"
    ),
    "no actuators": (
        GOOD.replace("<worldbody>", '<option><flag actuation="disable"/></option><worldbody>'),
        {}, "disables the actuators"
    ),
    "one text for names": (GOOD, {"names": "rotor_1"}, "names is 'rotor_1', one text"),
    "z down": (
        mjcf(replace(PLAIN, mounts=tuple(replace(m, axis=(0.0, 0.0, -1.0)) for m in PLAIN.mounts))),
        {}, "rotate the site so that its z axis is along the thrust"
    ),
    "no free joint": (
        GOOD.replace("<freejoint/>", '<joint type="hinge"/>'), {}, "the body 'quad' is not free"
    ),
    "a rotor that tilts": (
        GOOD.replace(SITE[0], f'<body><joint/><geom size="0.01" mass="0.01"/>{SITE[0]}</body>'),
        {}, "are on bodies that move relative to each other"
    ),
    "an actuator that pushes": (GOOD.replace('gainprm="0"', ""), {}, "itself exerts a force"),
    "an integrator": (
        GOOD.replace('"filter"', '"integrator"'), {}, "has an unsupported dyntype"
    ),
    "two kinds": (
        GOOD.replace(ACTUATOR[0], ACTUATOR[0].replace('"filter"', '"none"')), {}, "others have none"
    ),
    "air": (mjcf(PLAIN, option='density="1.2"'), {}, "option density or viscosity is not 0"),
    "nothing passive": (
        GOOD.replace("/>", '><flag spring="disable" damper="disable"/></option>', 1),
        {}, "passive forces are disabled"
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_what_does_not_fit_is_refused_in_a_line(case: str) -> None:
    text, given, message = WRONG[case]
    model = mujoco.MjModel.from_xml_string(text)
    with pytest.raises(InputError, match=re.escape(message)) as told:
        sim.MujocoRotors(model, PLAIN, table_of(PLAIN), **given)
    assert "\n" not in str(told.value)


def test_what_is_no_model_vehicle_or_loads_is_named() -> None:
    model = mujoco.MjModel.from_xml_string(GOOD)
    with pytest.raises(InputError, match="loads is str; give a Rotor or a LoadTable"):
        sim.MujocoRotors(model, PLAIN, "table.npz")
    for given in ((model, "quad.toml"), ("quad.xml", PLAIN)):
        with pytest.raises(InputError, match="not MjModel and Vehicle; give an MjModel and"):
            sim.MujocoRotors(*given, table_of(PLAIN))
    with pytest.raises(InputError, match="another propeller or air"):
        sim.MujocoRotors(model, PLAIN, propmap.Rotor(propmap.catalogue_model("apc-8x6e")))


# --- Rotors for models in other layouts ----------------------------------------------------------

PLACES = ((-0.14, -0.18, "ccw"), (-0.14, 0.18, "cw"), (0.14, 0.18, "ccw"), (0.14, -0.18, "cw"))
ABOVE = 0.06 - (4 * 0.15 * 0.06) / 1.35  # of the hubs over the center of mass
BARE = replace(
    SYMMETRIC, mounts=tuple(Mount((x, y, ABOVE), spin=spin) for x, y, spin in PLACES), body=Body()
)
HUBS = ("thrust1", "thrust2", "thrust3", "thrust4")
AIR = 'density="1.225" viscosity="1.8e-5"'


def motors_at_rotors() -> str:
    """As the Skydio X2 in MuJoCo Menagerie: a motor with thrust and yaw at each rotor."""
    sites = motors = ""
    for name, (x, y, spin) in zip(HUBS, PLACES, strict=True):
        sites += f'<geom type="sphere" size=".02" mass=".15" pos="{x} {y} .06"/>'
        sites += f'<site name="{name}" pos="{x} {y} .06"/>'
        yaw = {"ccw": -0.02, "cw": 0.02}[spin]
        motors += f'<motor name="{name}" site="{name}" gear="0 0 1 0 0 {yaw}"/>'
    return f"""<mujoco><option timestep="0.01" {AIR}/><default><motor ctrlrange="0 12"/></default>
<worldbody><body name="drone" pos="0 0 .1"><freejoint/>
<geom type="box" size=".1 .05 .03" mass=".75"/>{sites}</body></worldbody>
<actuator>{motors}</actuator>
<keyframe><key name="hover" qpos="0 0 2 1 0 0 0" ctrl="3 3 3 3"/></keyframe></mujoco>"""


def thrust_and_moments() -> str:
    """As the Crazyflie in MuJoCo Menagerie: the thrust and three moments of the body."""
    gears = ("0 0 1 0 0 0", "0 0 0 -1 0 0", "0 0 0 0 -1 0", "0 0 0 0 0 -1")
    motors = "".join(
        f'<motor name="act{k}" site="actuation" gear="{gear}" ctrlrange="0 40"/>'
        for k, gear in enumerate(gears)
    )
    return f"""<mujoco><option timestep="0.01" integrator="RK4" {AIR}/>
<worldbody><body name="drone" pos="0 0 .1" quat=".7 0 0 .7"><freejoint/>
<inertial pos="0 0 .02" mass="1.35" diaginertia="0.01 0.013 0.02"/><site name="actuation"/>
<body><joint name="gimbal" axis="0 1 0"/><geom size=".01" mass="1e-6" pos="0 0 .02"/></body>
</body></worldbody>
<actuator><position name="tilt" joint="gimbal" kp="1"/>{motors}</actuator>
<keyframe><key name="hover" qpos="0 0 2 1 0 0 0 0" ctrl=".1 13 0 0 0"/></keyframe></mujoco>"""


LAYOUTS: dict[str, tuple[str, dict[str, Any], list[str]]] = {
    "motors at rotors": (motors_at_rotors(), {"sites": HUBS}, [*HUBS]),
    "thrust and moments": (thrust_and_moments(), {}, [f"act{k}" for k in range(4)]),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_an_attached_vehicle_hovers_for_ten_seconds(fly: Callable[..., Any], layout: str) -> None:
    text, given, removed = LAYOUTS[layout]
    spec = mujoco.MjSpec.from_string(text)
    vehicle, changes = sim.attach(spec, replace(BARE, mass=1.0), "drone", **given)
    assert vehicle.mass == pytest.approx(1.35, rel=1e-5)
    for name in (*removed, "hover", "density: 0 instead of 1.225", "viscosity", "rotor_4"):
        assert any(name in line for line in changes), name
    assert "mass 1.35 kg (vehicle file: 1 kg)" in changes[0]
    model, data, forces = fly(spec.to_xml(), vehicle, ROTOR)
    names = [model.actuator(k).name for k in range(model.nu)]
    assert [name for name in names if name != "tilt"] == [f"rotor_{k}" for k in range(1, 5)]
    # Other controls remain; those of the rotors were forces.
    assert model.key_ctrl[0, :-4].tolist() == [0.1][: model.nu - 4]
    assert not model.key_ctrl[0, -4:].any()
    turned = data.qpos[3:7].copy()
    composite, origin = np.zeros((model.nv, model.nv)), np.array([0.0, 0.0, 1.0])
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, composite)
    lever = np.diag([1.0, 1.0, 0.0]) * vehicle.mass * (0.06 - ABOVE if given else 0.02) ** 2
    np.testing.assert_allclose(np.diag(composite[3:6, 3:6] - lever), vehicle.inertia, rtol=1e-4)
    np.testing.assert_allclose(forces.vehicle.rotor_axes, np.tile(origin, (4, 1)), atol=1e-12)
    hubs = forces.vehicle.hub_positions
    np.testing.assert_allclose(hubs, BARE.hub_positions, atol=1e-6)
    # Hover by the thrust of one rotor, with steady inflow.
    inflow, share = propmap.DynamicInflow(ROTOR), vehicle.mass * GRAVITY / 4.0

    def excess(omega: float) -> float:
        state = inflow.steady(omega, (0.0, 0.0, 0.0))
        return float(inflow.loads(state, omega, (0.0, 0.0, 0.0)).thrust) - share

    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.qpos[3:7], data.ctrl[:] = turned, 0.0
    data.act[:] = data.ctrl[-4:] = brentq(excess, 300.0, 1500.0, xtol=1e-10)
    while data.time < 10.0:
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.qpos[:7], [0.0, 0.0, 2.0, *turned], atol=1e-3)
    assert forces.worst_status == ("ok",) * 4


def test_attached_rotors_tilt_as_in_the_vehicle_file(fly: Callable[..., Any]) -> None:
    """On a body that starts upside down."""
    spec = mujoco.MjSpec.from_string(thrust_and_moments().replace(".7 0 0 .7", "0 1 0 0"))
    vehicle, _ = sim.attach(spec, QUAD, "drone")
    found = fly(spec.to_xml(), vehicle, ROTOR)[2].vehicle
    np.testing.assert_allclose(found.rotor_axes, QUAD.rotor_axes, atol=1e-6)
    np.testing.assert_allclose(found.hub_positions, QUAD.hub_positions, atol=1e-6)


def test_kept_actuators_still_push(fly: Callable[..., Any]) -> None:
    spec = mujoco.MjSpec.from_string(motors_at_rotors())
    vehicle, changes = sim.attach(spec, BARE, "drone", sites=HUBS, keep=True)
    assert not any("removed" in line for line in changes)
    model, data, _ = fly(spec.to_xml(), vehicle, ROTOR)
    data.ctrl[:4] = 1.0
    mujoco.mj_forward(model, data)
    assert data.qfrc_actuator[2] == pytest.approx(4.0) and model.nu == 8


TIPS = "".join(f'<site name="{name}"/>' for name in HUBS)  # for the gimbal


@pytest.mark.parametrize(
    ("text", "given", "message"),
    [
        (motors_at_rotors(), {"body": "x2"}, "no body 'x2'; choose one of drone"),
        (re.sub("<keyframe>.*</keyframe>|<freejoint/>", "", motors_at_rotors()), {}, "not free"),
        (motors_at_rotors(), {"sites": HUBS[::-1]}, "'thrust4' is at .*in the vehicle's order"),
        (
            thrust_and_moments().replace("<geom", TIPS + "<geom"),
            {"sites": HUBS},
            "are not on the body 'drone'; give the sites' body",
        ),
        (motors_at_rotors(), {"sites": HUBS[:3]}, "3 names are given, the vehicle has 4 rotors"),
        (motors_at_rotors().replace("0 0 1 0", "0 0 -1 0"), {}, "push along .* against the rotors"),
        (motors_at_rotors().replace("thrust4", "rotor_1"), {}, "already has a site 'rotor_1'"),
    ],
)
def test_attach_refuses_and_changes_nothing(text: str, given: dict[str, Any], message: str) -> None:
    spec = mujoco.MjSpec.from_string(text)
    before = spec.to_xml()
    with pytest.raises(InputError, match=message):
        sim.attach(spec, BARE, **{"body": "drone"} | given)
    assert spec.to_xml() == before


# --- ``propmap export --to mujoco`` --------------------------------------------------------------


@pytest.mark.parametrize(
    ("flown", "seconds"),
    [(VEHICLES["askew, with a wing and lift"], "0.500"), (replace(PLAIN, wakes=WAKES), "0.250")],
    ids=["askew, with a wing and lift", "wakes"],
)
@pytest.mark.usefixtures("fly")
def test_an_exported_vehicle_hovers(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    flown: Vehicle,
    seconds: str,
) -> None:
    vehicle = replace(flown, inertia=INERTIA, rotor_inertia=1e-5)
    paths = export_vehicle(vehicle, table_of(vehicle), "mujoco", tmp_path)
    assert sorted(path.name for path in paths) == [
        "README-mujoco.txt", "invented.npz", "test_quad.xml", "test_quad_mujoco.py"
    ]  # fmt: skip
    script = str(tmp_path / "test_quad_mujoco.py")
    monkeypatch.setattr(sys, "argv", [script, "--headless", seconds])
    runpy.run_path(script, run_name="__main__")
    mujoco.set_mjcb_passive(None)
    told = capsys.readouterr().out
    found = re.fullmatch(
        rf"after {seconds} s at \((\S+), (\S+), (\S+)\) m, status ok, ok, ok, ok\n", told
    )
    assert found is not None, told
    # As far as a hundredth of a m/s^2 or so moves it in that time, and rounding in print.
    off = 0.008 * float(seconds) ** 2
    np.testing.assert_allclose([float(word) for word in found.groups()], [0, 0, 2], atol=off)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "test_quad.xml"))
    assert model.body_mass.sum() == pytest.approx(vehicle.mass, rel=1e-12)
    np.testing.assert_allclose(model.body("test_quad").inertia, INERTIA, rtol=1e-12)
    assert "assumed time constant of 0.05 s" in " ".join(
        (tmp_path / "README-mujoco.txt").read_text().split()
    )


ONE_SPIN = tuple(replace(mount, spin="cw") for mount in PLAIN.mounts)
AHEAD = tuple(replace(mount, position=(0.16, *mount.position[1:])) for mount in PLAIN.mounts)


@pytest.mark.parametrize(
    ("vehicle", "message"),
    [
        (PLAIN, "has no inertia"),
        (replace(PLAIN, inertia=INERTIA, mass=30.0), "does not hover: .* rotor speeds"),
        *(
            (replace(PLAIN, inertia=INERTIA, mounts=mounts), "cannot hover without a moment .*spin")
            for mounts in (ONE_SPIN, AHEAD)
        ),
    ],
    ids=["no inertia", "too heavy", "one spin for all", "rotors ahead"],
)
def test_what_cannot_be_exported(tmp_path: Path, vehicle: Vehicle, message: str) -> None:
    with pytest.raises(InputError, match=message) as told:
        export_vehicle(vehicle, table_of(vehicle), "mujoco", tmp_path / "out")
    assert "\n" not in str(told.value) and not (tmp_path / "out").exists()
    vehicle = replace(PLAIN, inertia=INERTIA)
    table = table_of(vehicle, beta=(0.0, np.pi / 2.0))
    with pytest.raises(InputError, match=r"beta is 0 to 90 deg.*--beta 0:180"):
        export_vehicle(vehicle, table, "mujoco", tmp_path / "out")


def test_headless_flight_without_loads_ends_with_a_line(tmp_path: Path) -> None:
    """Rotors slower than the table's slowest."""
    vehicle = replace(PLAIN, inertia=INERTIA)
    export_vehicle(vehicle, table_of(vehicle), "mujoco", tmp_path)
    model = tmp_path / "test_quad.xml"
    text = model.read_text()
    assert 'qpos="0 0 2 1.0 0.0 0.0 0.0"' in text  # without rounding errors
    model.write_text(re.sub(r'act="[^"]*"', 'act="100 100 100 100"', text))
    command = [sys.executable, str(tmp_path / "test_quad_mujoco.py"), "--headless", "5"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and done.stdout == ""
    assert done.stderr.count("\n") == 1 and "no loads" in done.stderr, done.stderr
