"""A vehicle in SciPy's solve_ivp, RotorPy, MuJoCo and Drake: one interface, four integrators."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from benchmarks.cross_check.mission import TIME_CONSTANT, UP, State
from propmap import VehicleForces
from propmap.results import spin_sign
from propmap.rotor import Rotor
from propmap.table import LoadTable
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.vehicle import Vehicle
from propmap.vehicle.vehicle_forces import LoadSource


class SciPy:
    """Newton's and Euler's equations of a rigid body by ``solve_ivp``, error-controlled."""

    def __init__(
        self, vehicle: Vehicle, loads: LoadSource, start: State, tolerance: float = 1e-10
    ) -> None:
        self.forces, self.tolerance = VehicleForces(vehicle, loads), tolerance
        self._turned, self._packed = Rotation.from_matrix(start.attitude), _packed(start)
        self.inertia = np.array(vehicle.inertia)

    @property
    def state(self) -> State:
        """Return the state now."""
        position, velocity, _, rates, omega = np.split(self._packed, SPLIT)
        return State(position, velocity, self._turned.as_matrix(), rates, omega)

    def advance(self, command: Floats, step: float) -> None:
        """Go on for a step; the attitude in it is a rotation vector from where it begins."""

        def rate(_: float, packed: Floats) -> Floats:
            velocity, turn, rates, omega = np.split(packed, SPLIT)[1:]
            turned = self._turned * Rotation.from_rotvec(turn)
            found = self.forces.wrench(omega, turned.inv().apply(velocity), rates)
            # The third entry is the rotation vector's rate, to the fourth order of its length.
            return np.concatenate(
                [
                    velocity,
                    turned.apply(found.force) / self.forces.vehicle.mass - GRAVITY * UP,
                    rates
                    + 0.5 * np.cross(turn, rates)
                    + np.cross(turn, np.cross(turn, rates)) / 12,
                    (found.moment - np.cross(rates, self.inertia * rates)) / self.inertia,
                    (command - omega) / TIME_CONSTANT,
                ]
            )

        found = solve_ivp(
            rate,
            (0.0, step),
            self._packed,
            method="DOP853",
            first_step=step,
            rtol=self.tolerance,
            atol=self.tolerance,
        )
        self._packed = found.y[:, -1]
        self._turned = self._turned * Rotation.from_rotvec(self._packed[6:9])
        self._packed[6:9] = 0.0


SPLIT = (3, 6, 9, 12)


def _packed(state: State) -> Floats:
    return np.concatenate([state.position, state.velocity, np.zeros(3), state.rates, state.omega])


class RotorPy:
    """RotorPy's ``Multirotor`` with its wrench replaced; one step of RK45 per step."""

    def __init__(self, vehicle: Vehicle, loads: LoadSource, start: State) -> None:
        from rotorpy.vehicles.multirotor import Multirotor

        forces = VehicleForces(vehicle, loads)

        class Flown(Multirotor):  # type: ignore[misc]
            """Asks ``forces`` for the air's wrench."""

            def compute_body_wrench(
                self, body_rates: Floats, rotor_speeds: Floats, body_airspeed_vector: Floats
            ) -> tuple[Floats, Floats]:
                """As Multirotor's."""
                found = forces.wrench(rotor_speeds, body_airspeed_vector, body_rates)
                return found.force, found.moment

        none = dict.fromkeys(("Ixy", "Ixz", "Iyz"), 0.0)
        inertia = dict(zip(("Ixx", "Iyy", "Izz"), vehicle.inertia or (), strict=True))
        # What its own model and controllers take is not used.
        unused = {"k_eta": 1.0, "k_m": 1.0}
        frame = {
            "mass": vehicle.mass,
            "num_rotors": len(vehicle.mounts),
            "rotor_pos": {f"r{k}": np.array(m.position) for k, m in enumerate(vehicle.mounts)},
            "rotor_directions": np.array([-spin_sign(m.spin) for m in vehicle.mounts]),
            "rotor_speed_min": 0.0,
            "rotor_speed_max": math.inf,
            "tau_m": TIME_CONSTANT,
        }
        self.forces, self.vehicle = forces, Flown(frame | inertia | none | unused)
        self.vehicle.weight = -vehicle.mass * GRAVITY * UP
        self._state: dict[str, Any] = {
            "x": start.position,
            "v": start.velocity,
            "q": Rotation.from_matrix(start.attitude).as_quat(),
            "w": start.rates,
            "wind": np.zeros(3),
            "rotor_speeds": start.omega,
        }

    @property
    def state(self) -> State:
        """Return the state now."""
        x, v, q, w, _, omega = self._state.values()
        return State(x, v, Rotation.from_quat(q).as_matrix(), w, omega)

    def advance(self, command: Floats, step: float) -> None:
        """Go on for a step, whatever its error."""
        fixed = {"method": "RK45", "first_step": step, "rtol": 1e9, "atol": 1e9}
        self.vehicle.integrator_kwargs = fixed
        self._state = self.vehicle.step(self._state, {"cmd_motor_speeds": command}, step)


class MuJoCo:
    """A free body of MuJoCo: forces in its callback of passive forces, or held over a step.

    The callback is ``MujocoRotors`` where that has the loads.
    """

    def __init__(
        self, vehicle: Vehicle, loads: LoadSource, start: State, *, held: bool = False
    ) -> None:
        import mujoco

        from propmap.sim.mujoco import MujocoRotors

        self.mujoco, self.forces, self.held = mujoco, VehicleForces(vehicle, loads), held
        self.model = mujoco.MjModel.from_xml_string(_mjcf(vehicle, "Euler" if held else "RK4"))
        self.push: Callable[[Any, Any], None] = self.add_forces
        if isinstance(loads, Rotor | LoadTable):
            self.push = MujocoRotors(self.model, vehicle, loads)
        self.data = mujoco.MjData(self.model)
        turned = Rotation.from_matrix(start.attitude).as_quat(scalar_first=True)
        self.data.qpos[:] = np.concatenate([start.position, turned])
        self.data.qvel[:] = np.concatenate([start.velocity, start.rates])
        self.data.act[:] = start.omega

    @property
    def state(self) -> State:
        """Return the state now."""
        position, turned = np.split(self.data.qpos.copy(), [3])
        velocity, rates = np.split(self.data.qvel.copy(), [3])
        attitude = Rotation.from_quat(turned, scalar_first=True).as_matrix()
        return State(position, velocity, attitude, rates, self.data.act.copy())

    def wrench(self) -> tuple[Floats, Floats]:
        """Return force and moment of the air in the world's axes."""
        state = self.state
        found = self.forces.wrench(state.omega, state.attitude.T @ state.velocity, state.rates)
        return state.attitude @ found.force, state.attitude @ found.moment

    def add_forces(self, _: Any, data: Any) -> None:
        """Add them to ``qfrc_passive``: a free joint turns in the body's axes."""
        force, moment = self.wrench()
        data.qfrc_passive[:3] += force
        data.qfrc_passive[3:] += self.state.attitude.T @ moment

    def advance(self, command: Floats, step: float) -> None:
        """Go on for a step."""
        self.model.opt.timestep = step
        self.data.ctrl[:] = command
        if self.held:
            self.data.xfrc_applied[1] = np.concatenate(self.wrench())
            self.mujoco.mj_step(self.model, self.data)
            return
        self.mujoco.set_mjcb_passive(self.push)
        try:
            self.mujoco.mj_step(self.model, self.data)
        finally:
            self.mujoco.set_mjcb_passive(None)


def _mjcf(vehicle: Vehicle, integrator: str) -> str:
    """Return the vehicle as MuJoCo has it, its rotors as actuators that push nothing themselves."""
    sites = actuators = ""
    for k, mount in enumerate(vehicle.mounts, start=1):
        place, axis = (" ".join(map(repr, vector)) for vector in (mount.position, mount.axis))
        named = f'name="rotor_{k}"'
        sites += f'<site {named} pos="{place}" zaxis="{axis}"/>'
        lag = f'dyntype="filter" dynprm="{TIME_CONSTANT}" gainprm="0"'
        actuators += f'<general {named} site="rotor_{k}" {lag}/>'
    turning = " ".join(map(repr, vehicle.inertia or ()))
    return f"""
        <mujoco>
          <option integrator="{integrator}" gravity="0 0 {-GRAVITY!r}"/>
          <worldbody>
            <body name="vehicle">
              <freejoint/>
              <inertial pos="0 0 0" mass="{vehicle.mass!r}" diaginertia="{turning}"/>
              {sites}
            </body>
          </worldbody>
          <actuator>{actuators}</actuator>
        </mujoco>"""


class Drake:
    """A free body of a ``MultibodyPlant`` with the system of examples/drake, by its RK3."""

    def __init__(self, vehicle: Vehicle, loads: LoadSource, start: State) -> None:
        from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

        from examples.drake.rotor_forces import flying

        self.forces = VehicleForces(vehicle, loads)
        diagram = flying(self.forces, TIME_CONSTANT, GRAVITY)
        self.simulator = Simulator(diagram)
        context = self.simulator.get_mutable_context()
        self.plant, rotors = (diagram.GetSubsystemByName(name) for name in ("plant", "rotors"))
        self.at_plant, at_rotors = (
            part.GetMyMutableContextFromRoot(context) for part in (self.plant, rotors)
        )
        turned = Rotation.from_matrix(start.attitude).as_quat(scalar_first=True)
        self.plant.SetPositions(self.at_plant, np.concatenate([turned, start.position]))
        turning = start.attitude @ start.rates
        self.plant.SetVelocities(self.at_plant, np.concatenate([turning, start.velocity]))
        at_rotors.SetContinuousState(start.omega)
        self.turning, self.at_rotors = rotors.GetOutputPort("omega"), at_rotors
        self.context, self.command = context, diagram.GetInputPort("command")
        self.choose = ResetIntegratorFromFlags
        self.steps = 0

    @property
    def state(self) -> State:
        """Return the state now."""
        turned, position = np.split(self.plant.GetPositions(self.at_plant), [4])
        rates, velocity = np.split(self.plant.GetVelocities(self.at_plant), [3])
        attitude = Rotation.from_quat(turned, scalar_first=True).as_matrix()
        omega = self.turning.Eval(self.at_rotors)
        return State(position, velocity, attitude, attitude.T @ rates, omega)

    def advance(self, command: Floats, step: float) -> None:
        """Go on for a step."""
        if not self.steps:
            self.choose(self.simulator, "runge_kutta3", step)
            self.simulator.get_mutable_integrator().set_fixed_step_mode(True)
        self.command.FixValue(self.context, command)
        self.steps += 1
        self.simulator.AdvanceTo(self.steps * step)
