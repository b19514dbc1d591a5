"""Aerodynamic forces of a vehicle in MJX and other JAX simulators, with jit, vmap and grad."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self

from propmap.errors import InputError, quoted, require
from propmap.jax import real_arrays
from propmap.model.airfoil import Airfoil
from propmap.results import spin_sign
from propmap.table import JaxTable, LoadTable
from propmap.table.query import JaxLoads
from propmap.vehicle.vehicle import Vehicle
from propmap.vehicle.vehicle_forces import check_table

require("jax")
import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
from jax.scipy.spatial.transform import Rotation  # noqa: E402

SLOW = 1e-3
"""In-plane velocity [m/s] below which the in-plane loads are linear, so that derivatives exist."""

OTHER_MASS = 0.01  # maximum relative difference of mass between model and vehicle


class JaxWrench(NamedTuple):
    """Aerodynamic force and moment on a vehicle at (...) states, in the vehicle frame.

    Attributes
    ----------
    force, moment : array, shape (..., 3)
        Force [N], and moment about the center of mass [N m]; NaN if a rotor is outside the table.
    code : array of int, shape (...)
        Worst status of the rotors, an index into ``propmap.table.STATUSES``.
    """

    force: Any
    moment: Any
    code: Any


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class JaxForces:
    """A vehicle with a table of rotor loads in JAX; a pytree.

    Create it with ``JaxForces.from_vehicle(vehicle, table)``.
    """

    table: JaxTable
    vehicle: Vehicle = field(metadata={"static": True})

    @classmethod
    def from_vehicle(cls, vehicle: Vehicle, table: LoadTable) -> Self:
        """Convert a ``vehicle`` and the ``table`` of its rotors to JAX.

        Raises ``InputError`` for a ``table`` of another type, propeller or air, and for a vehicle
        with mount drag or wakes, which a table excludes.
        """
        if not isinstance(table, LoadTable):
            raise InputError(f"table is {type(table).__name__}", "give a LoadTable of the rotors")
        check_table(vehicle, table)
        if vehicle.wakes is not None:
            found = "the vehicle has wakes, which are not computed in JAX"
            raise InputError(found, "use VehicleForces, or remove the wakes")
        return cls(JaxTable.from_table(table), vehicle)

    def wrench(
        self,
        omega: Any,
        velocity: Any,
        rates: Any = (0.0, 0.0, 0.0),
        wind: Any = (0.0, 0.0, 0.0),
        *,
        clamp: bool = False,
    ) -> JaxWrench:
        """Return force and moment of the air, as ``propmap.VehicleForces.wrench``.

        Derivatives are finite everywhere inside the table, including at rest and in axial flow.

        Parameters
        ----------
        omega : array, shape (..., k)
            Speeds of the k rotors, in the order of the vehicle's mounts [rad/s].
        velocity, rates, wind : array, shape (..., 3)
            Velocity of the center of mass over the ground [m/s], angular velocity of the vehicle
            [rad/s], and wind velocity over the ground [m/s], in the vehicle frame.
        clamp : bool
            Whether a rotor outside the table has the loads of the nearest point of the table
            instead of NaN; the code remains ``outside``.

        Raises
        ------
        InputError
            For complex values, and if a last axis does not have k speeds or three components.
        """
        omega, moving, turning, air = real_arrays(
            self.table.lows.dtype,
            omega=(omega, len(self.vehicle.mounts)),
            **{"velocity": (velocity, 3), "rates": (rates, 3), "wind": (wind, 3)},
        )
        through, place, axis = moving - air, self.vehicle.hub_positions, self.vehicle.rotor_axes
        hubs = through[..., None, :] + jnp.cross(turning[..., None, :], place)
        axial = jnp.sum(hubs * axis, axis=-1)
        across = hubs - axial[..., None] * axis
        inplane = jnp.sqrt(jnp.maximum(jnp.sum(across**2, axis=-1), SLOW**2))
        omega, axial, inplane = jnp.broadcast_arrays(omega, axial, inplane)
        seen = jnp.stack([inplane, jnp.zeros_like(axial), axial], axis=-1)
        loads = self.table.loads_at_velocity(omega, seen, clamp=clamp)
        along, aside = jax.lax.stop_gradient((axial, inplane))
        speed, beta = jnp.hypot(along, aside), jnp.arctan2(aside, along)
        code = self.table.code(omega, speed, beta, loads.thrust)
        ahead, spin = across / inplane[..., None], _spins(self.vehicle)
        left, load = jnp.cross(axis, ahead), JaxLoads(*(x[..., None] for x in loads))
        # The signs must agree with ``propmap.vehicle.wakes.hub_wrenches``.
        force = load.thrust * axis - load.drag * ahead + spin * load.side_force * left
        turning = spin * (load.torque * axis + load.roll_moment * ahead)
        moment = jnp.cross(place, force) - turning - load.pitch_moment * left
        total = force.sum(axis=-2) + _free_stream_force(self.vehicle, through)
        return JaxWrench(total, moment.sum(axis=-2), code.max(axis=-1))


def _spins(vehicle: Vehicle) -> Any:
    """Return 1 for counter-clockwise and -1 for clockwise rotors (k, 1)."""
    return jnp.array([[spin_sign(mount.spin)] for mount in vehicle.mounts])


def _free_stream_force(vehicle: Vehicle, velocity: Any) -> Any:
    """Return ``vehicle_forces.free_stream_force`` in JAX, with derivatives at rest."""
    body, wing = vehicle.body, vehicle.wing
    x, z = velocity[..., 0], velocity[..., 2]
    still = (x == 0.0) & (z == 0.0)
    flown = jnp.where(still, 1.0, x)
    angle, speed = jnp.arctan2(-z, flown), jnp.where(still, 0.0, jnp.hypot(flown, z))
    lift = body.lift_area * jnp.sin(angle) * jnp.cos(angle)
    down = jnp.square(velocity[..., :2]) @ jnp.array(body.download_area)
    force = -jnp.array(body.drag_area) * jnp.abs(velocity) * velocity
    # The magnitude of the velocity has no derivative at rest: use zero there.
    whole = jnp.sum(jnp.square(velocity), axis=-1)
    size = jnp.where(whole > 0.0, jnp.sqrt(jnp.where(whole > 0.0, whole, 1.0)), 0.0)
    force = force.at[..., 2].add(-down - body.plate_area * size * z)
    if wing is not None:
        alpha, m = angle + wing.incidence, Airfoil.sharpness
        # Eq. (3), whose sigma is one minus a product of logistic functions.
        near = [jax.nn.sigmoid(m * (wing.alpha_0 + way * alpha)) for way in (-1.0, 1.0)]
        attached, stalled = near[0] * near[1], wing.c_l2 * jnp.sin(alpha) * jnp.cos(alpha)
        carried = wing.area * (attached * wing.c_l1 * alpha + (1.0 - attached) * stalled)
        lift = lift + carried
        if wing.span is not None:
            induced = carried**2 / (math.pi * wing.span**2) * speed
            force = force - induced[..., None] * velocity * jnp.array([1.0, 0.0, 1.0])
    across = jnp.stack([-z, jnp.zeros_like(z), x], axis=-1)
    return 0.5 * vehicle.air.density * (force + (lift * speed)[..., None] * across)


# --- The rotors on a free body of MuJoCo, with rotor speeds that lag behind the commands ---------


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class MjxRotors:
    """The rotors of a vehicle on a free body of MJX; a pytree.

    Create it with ``MjxRotors.from_vehicle``.  If the vehicle has a ``rotor_inertia``, rotors also
    exert reaction torques when they change speed, and gyroscopic moments.
    """

    forces: JaxForces
    center: Any  # center of mass from the body's origin, in the body frame (3,) [m]
    lever: Any  # center of mass from the point where MuJoCo applies ``xfrc_applied`` (3,) [m]
    left: Any  # fraction of the difference from the command that remains after a step [-]
    step: Any  # time step of the model [s]
    momenta: Any  # angular momentum of each rotor at 1 rad/s (k, 3) [kg m^2/s]
    body: int = field(metadata={"static": True})
    qpos: int = field(metadata={"static": True})
    dof: int = field(metadata={"static": True})

    @classmethod
    def from_vehicle(
        cls, vehicle: Vehicle, table: LoadTable, model: Any, body: str, *, time_constant: float
    ) -> Self:
        """Attach the rotors of a vehicle to a body of a model.

        Parameters
        ----------
        vehicle, table
            As for ``JaxForces.from_vehicle``.
        model : mujoco.MjModel
            Model in SI units, with x of the body forward, y left, z up.
        body : str
            Name of a body with a free joint; its mass with its children is the vehicle's mass.
        time_constant : float
            Time constant of the first-order lag of the rotor speeds [s].

        Raises
        ------
        InputError
            As in ``JaxForces.from_vehicle``.  For a body that does not exist, is not free or has
            another mass.  For air density or viscosity in the model.  For a negative time constant.
        """
        from propmap.sim.mujoco import center_of_mass, check_air, free_body

        check_air(model)
        at, pose, motion = free_body(model, body)
        mass = float(model.body_subtreemass[at])
        if abs(mass - vehicle.mass) > OTHER_MASS * vehicle.mass:
            found = f"the body {quoted(body)} has {mass:g} kg, the vehicle {vehicle.mass:g}"
            raise InputError(found, "give both the same mass, in kg")
        if not 0.0 <= time_constant < math.inf:
            raise InputError(f"time_constant is {time_constant:g} s", "give 0 or more")
        data, axes, center = center_of_mass(model, at)
        steps = model.opt.timestep / time_constant if time_constant else math.inf
        return cls(
            forces=JaxForces.from_vehicle(vehicle, table),
            center=jnp.asarray(center),
            lever=jnp.asarray(axes @ (data.subtree_com[at] - data.xipos[at])),
            left=jnp.asarray(math.exp(-steps)),
            step=jnp.asarray(model.opt.timestep),
            momenta=vehicle.rotor_inertia * _spins(vehicle) * vehicle.rotor_axes,
            body=at,
            qpos=pose.start,
            dof=motion.start,
        )

    def apply(
        self, data: Any, omega: Any, commands: Any, wind: Any = (0.0,) * 3, *, clamp: bool = False
    ) -> tuple[Any, Any, Any]:
        """Write the aerodynamic force and moment to ``xfrc_applied``; call it before ``mjx.step``.

        Raises ``InputError`` for the same inputs as ``JaxForces.wrench``.

        Parameters
        ----------
        data : mjx.Data
            State of one vehicle; use ``jax.vmap`` for several.
        omega, commands : array, shape (k,)
            Actual and commanded rotor speeds [rad/s].
        wind : array, shape (3,)
            Wind velocity in the world frame [m/s].
        clamp : bool
            Whether rotors outside the table use the loads of its nearest point.

        Returns
        -------
        data : mjx.Data
            State with the body's row of ``xfrc_applied`` replaced.
        omega : array, shape (k,)
            Rotor speeds after the step [rad/s].
        code : array of int
            As for ``JaxWrench``.
        """
        given = {"omega": (omega, len(self.momenta)), "commands": (commands, len(self.momenta))}
        omega, commands, wind = real_arrays(self.step.dtype, **given, wind=(wind, 3))
        turn = Rotation.from_quat(jnp.roll(data.qpos[self.qpos + 3 : self.qpos + 7], -1))
        moving, rates = data.qvel[self.dof : self.dof + 3], data.qvel[self.dof + 3 : self.dof + 6]
        velocity = turn.apply(moving, inverse=True) + jnp.cross(rates, self.center)
        air = turn.apply(wind, inverse=True)
        found = self.forces.wrench(omega, velocity, rates, air, clamp=clamp)
        after = commands + self.left * (omega - commands)
        change = (after - omega) / self.step
        gained, held = (jnp.sum(x[:, None] * self.momenta, axis=0) for x in (change, omega))
        reaction = gained + jnp.cross(rates, held)
        moment = found.moment - reaction + jnp.cross(self.lever, found.force)
        row = jnp.concatenate([turn.apply(found.force), turn.apply(moment)])
        applied = data.xfrc_applied.at[self.body].set(row)
        return data.replace(xfrc_applied=applied), after, found.code
