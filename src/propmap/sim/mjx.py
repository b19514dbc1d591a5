"""A vehicle's rotors in MJX, and in any simulator on JAX: through jit, vmap and grad."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self

from propmap.errors import InputError, quoted, require
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
"""In-plane velocity [m/s] below which the loads by it are linear, so that they have derivatives."""

OTHER_MASS = 0.01  # share by which a model's mass may differ from the vehicle's


class JaxWrench(NamedTuple):
    """Force and moment of the air on a vehicle at (...) states, in its frame.

    Attributes
    ----------
    force, moment : array, shape (..., 3)
        [N], and about the centre of mass [N m]; NaN where a rotor is outside the table.
    code : array of int, shape (...)
        The worst of the rotors', an index into ``propmap.table.STATUSES``.
    """

    force: Any
    moment: Any
    code: Any


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class JaxForces:
    """A vehicle with a table of its rotors' loads in JAX; a pytree.

    Make one with ``JaxForces.of(vehicle, table)``.
    """

    table: JaxTable
    vehicle: Vehicle = field(metadata={"static": True})

    @classmethod
    def of(cls, vehicle: Vehicle, table: LoadTable) -> Self:
        """Take a ``vehicle`` and a ``table`` of its rotors over to JAX.

        Raises ``InputError`` for what is no table, for one of another propeller or air, and for
        mounts and wakes, of which a table knows nothing.
        """
        if not isinstance(table, LoadTable):
            raise InputError(f"table is {type(table).__name__}", "give a LoadTable of its rotors")
        check_table(vehicle, table)
        if vehicle.wakes is not None:
            found = "the vehicle has wakes, which are not computed in JAX"
            raise InputError(found, "use VehicleForces, or leave them out")
        return cls(JaxTable.of(table), vehicle)

    def wrench(
        self,
        omegas: Any,
        velocity: Any,
        rates: Any = (0.0, 0.0, 0.0),
        wind: Any = (0.0, 0.0, 0.0),
        *,
        clamp: bool = False,
    ) -> JaxWrench:
        """Force and moment of the air on the vehicle, as ``propmap.VehicleForces.wrench``.

        Derivatives are finite everywhere inside the table, at rest and along the axes too.

        Parameters
        ----------
        omegas : array, shape (..., k)
            Speeds of the k rotors, in the order of the vehicle's mounts [rad/s].
        velocity, rates, wind : array, shape (..., 3)
            Velocity of the centre of mass over the ground [m/s], how fast the vehicle turns
            [rad/s], and velocity of the air over the ground [m/s], in the vehicle's frame.
        clamp : bool
            Whether outside the table the loads are those of its nearest point, in place of NaN;
            the code is that of ``outside`` all the same.

        Raises
        ------
        InputError
            Where a last axis does not hold k speeds, or x, y, z.
        """
        given = {"omegas": omegas, "velocity": velocity, "rates": rates, "wind": wind}
        counts = (len(self.vehicle.mounts), 3, 3, 3)
        arrays = {name: jnp.asarray(x, self.table.lows.dtype) for name, x in given.items()}
        for (name, x), count in zip(arrays.items(), counts, strict=True):
            if x.shape[-1:] != (count,):
                raise InputError(f"{name} has shape {x.shape}", f"its last axis must hold {count}")
        omega, moving, turning, air = arrays.values()
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
        # Signs are those of ``propmap.vehicle.wakes.hub_wrenches``.
        force = load.thrust * axis - load.drag * ahead + spin * load.side_force * left
        turning = spin * (load.torque * axis + load.roll_moment * ahead)
        moment = jnp.cross(place, force) - turning - load.pitch_moment * left
        total = force.sum(axis=-2) + _free_stream_force(self.vehicle, through)
        return JaxWrench(total, moment.sum(axis=-2), code.max(axis=-1))


def _spins(vehicle: Vehicle) -> Any:
    """Return 1 for each rotor that turns counter-clockwise, else -1 (k, 1)."""
    return jnp.array([[spin_sign(mount.spin)] for mount in vehicle.mounts])


def _free_stream_force(vehicle: Vehicle, velocity: Any) -> Any:
    """Return that of ``propmap.vehicle.vehicle_forces``, with derivatives at rest."""
    body, wing = vehicle.body, vehicle.wing
    x, z = velocity[..., 0], velocity[..., 2]
    still = (x == 0.0) & (z == 0.0)
    flown = jnp.where(still, 1.0, x)
    angle, speed = jnp.arctan2(-z, flown), jnp.where(still, 0.0, jnp.hypot(flown, z))
    lift = body.lift_area * jnp.sin(angle) * jnp.cos(angle)
    down = jnp.square(velocity[..., :2]) @ jnp.array(body.download_area)
    force = -jnp.array(body.drag_area) * jnp.abs(velocity) * velocity
    # Zero and without a slope at rest, where the size of the velocity has none.
    whole = jnp.sum(jnp.square(velocity), axis=-1)
    size = jnp.where(whole > 0.0, jnp.sqrt(jnp.where(whole > 0.0, whole, 1.0)), 0.0)
    force = force.at[..., 2].add(-down - body.plate_area * size * z)
    if wing is not None:
        alpha, m = angle + wing.incidence, Airfoil.sharpness
        # Eq. (3), whose sigma is one less a product of logistic functions.
        near = [jax.nn.sigmoid(m * (wing.alpha_0 + way * alpha)) for way in (-1.0, 1.0)]
        attached, stalled = near[0] * near[1], wing.c_l2 * jnp.sin(alpha) * jnp.cos(alpha)
        carried = wing.area * (attached * wing.c_l1 * alpha + (1.0 - attached) * stalled)
        lift = lift + carried
        if wing.span is not None:
            induced = carried**2 / (math.pi * wing.span**2) * speed
            force = force - induced[..., None] * velocity * jnp.array([1.0, 0.0, 1.0])
    across = jnp.stack([-z, jnp.zeros_like(z), x], axis=-1)
    return 0.5 * vehicle.air.density * (force + (lift * speed)[..., None] * across)


# -------------------------------------------------------------------------------------------------
# A free body of MuJoCo on which the rotors act, with speeds that follow their commands.


@jax.tree_util.register_dataclass
@dataclass(frozen=True, eq=False)
class MjxRotors:
    """The rotors of a vehicle on a free body of MJX; a pytree.

    Make one with ``MjxRotors.of``.  Where the vehicle's ``rotor_inertia`` is known, rotors turn it
    also as they change their speed, and as gyroscopes.
    """

    forces: JaxForces
    centre: Any  # of mass, from the body's origin, in its frame (3,) [m]
    lever: Any  # and from where MuJoCo applies forces to it
    left: Any  # share of the difference from the commands that is left after a step [-]
    step: Any  # of the model's time [s]
    momenta: Any  # of each rotor at 1 rad/s (k, 3) [kg m^2/s]
    body: int = field(metadata={"static": True})
    qpos: int = field(metadata={"static": True})
    dof: int = field(metadata={"static": True})

    @classmethod
    def of(
        cls, vehicle: Vehicle, table: LoadTable, model: Any, body: str, *, time_constant: float
    ) -> Self:
        """Put a vehicle's rotors on a body of a model.

        Parameters
        ----------
        vehicle, table
            As for ``JaxForces.of``.
        model : mujoco.MjModel
            In SI units, x of the body forward, y left, z up; its time step counts for the lag.
        body : str
            Name of a body with a free joint, which with its children has the vehicle's mass.
        time_constant : float
            In which the rotors' speeds come 63 % nearer to their commands [s].

        Raises
        ------
        InputError
            As ``JaxForces.of``, for a body that is not there, is not free or has another mass, for
            a model with air of its own and for a negative time constant.
        """
        import mujoco

        from propmap.sim.mujoco import check_air

        check_air(model)
        known = [model.body(k).name for k in range(1, model.nbody)]
        if body not in known:
            found = f"the model has no body {quoted(body)}"
            raise InputError(found, f"choose one of {', '.join(known)}")
        at = model.body(body).id
        joint = int(model.body_jntadr[at])
        if joint < 0 or model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_FREE:
            raise InputError(f"the body {quoted(body)} is not free", "give it a <freejoint/>")
        mass = float(model.body_subtreemass[at])
        if abs(mass - vehicle.mass) > OTHER_MASS * vehicle.mass:
            found = f"the body {quoted(body)} has {mass:g} kg, the vehicle {vehicle.mass:g}"
            raise InputError(found, "give both in SI units, alike")
        if not 0.0 <= time_constant < math.inf:
            raise InputError(f"time_constant is {time_constant:g} s", "give 0 or more")
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        turn, origin = data.xmat[at].reshape(3, 3), data.subtree_com[at]
        steps = model.opt.timestep / time_constant if time_constant else math.inf
        return cls(
            forces=JaxForces.of(vehicle, table),
            centre=jnp.asarray((origin - data.xpos[at]) @ turn),
            lever=jnp.asarray((origin - data.xipos[at]) @ turn),
            left=jnp.asarray(math.exp(-steps)),
            step=jnp.asarray(model.opt.timestep),
            momenta=vehicle.rotor_inertia * _spins(vehicle) * vehicle.rotor_axes,
            body=at,
            qpos=int(model.jnt_qposadr[joint]),
            dof=int(model.jnt_dofadr[joint]),
        )

    def apply(
        self, data: Any, omegas: Any, commands: Any, wind: Any = (0.0,) * 3, *, clamp: bool = False
    ) -> tuple[Any, Any, Any]:
        """Write force and moment of the air into ``xfrc_applied``, before ``mjx.step``.

        Parameters
        ----------
        data : mjx.Data
            State of one vehicle; many by ``jax.vmap``.
        omegas, commands : array, shape (k,)
            Speeds of the rotors, and those that they are to have [rad/s].
        wind : array, shape (3,)
            Velocity of the air in the world's frame [m/s].
        clamp : bool
            As for ``JaxForces.wrench``.

        Returns
        -------
        data : mjx.Data
            With the body's row of ``xfrc_applied`` replaced.
        omegas : array, shape (k,)
            Speeds of the rotors after the step [rad/s].
        code : array of int
            As for ``JaxWrench``.
        """
        turn = Rotation.from_quat(jnp.roll(data.qpos[self.qpos + 3 : self.qpos + 7], -1))
        moving, rates = data.qvel[self.dof : self.dof + 3], data.qvel[self.dof + 3 : self.dof + 6]
        velocity = turn.apply(moving, inverse=True) + jnp.cross(rates, self.centre)
        air = turn.apply(jnp.asarray(wind), inverse=True)
        found = self.forces.wrench(omegas, velocity, rates, air, clamp=clamp)
        after = commands + self.left * (omegas - commands)
        change = (after - omegas) / self.step
        gained, held = (jnp.sum(x[:, None] * self.momenta, axis=0) for x in (change, omegas))
        reaction = gained + jnp.cross(rates, held)
        moment = found.moment - reaction + jnp.cross(self.lever, found.force)
        row = jnp.concatenate([turn.apply(found.force), turn.apply(moment)])
        applied = data.xfrc_applied.at[self.body].set(row)
        return data.replace(xfrc_applied=applied), after, found.code
