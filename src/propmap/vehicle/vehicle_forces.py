"""Aerodynamic force and moment on a vehicle: interacting rotors, body and wing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.model.airfoil import Airfoil
from propmap.model.envelope import Envelope
from propmap.model.model import Model
from propmap.operating_points import broadcast, numbers
from propmap.results import STATUSES
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.vehicle.vehicle import Vehicle
from propmap.vehicle.wakes import (
    HubFlow,
    check_apart,
    cross,
    flow_of_hubs,
    hub_wrenches,
    wake_flow,
)

if TYPE_CHECKING:
    from propmap.vehicle.vehicle import Body, Wing


@dataclass(frozen=True, eq=False)
class VehicleWrench:
    """Aerodynamic force and moment on a vehicle of k rotors at (...) states, in its frame.

    The weight of the vehicle and the gyroscopic moments of the rotors are not included.

    Attributes
    ----------
    force, moment : ndarray, shape (..., 3)
        Total force [N], and moment about the center of mass [N m]; NaN if the loads of a rotor were
        not found.
    status : ndarray of str, shape (...)
        Worst status of the rotors, as in ``propmap.Loads`` or a table's loads.  It is
        "extrapolated" if a rotor's flow is outside the data of the fit of its section constants.
    rotor_force, rotor_moment : ndarray, shape (..., k, 3)
        Force of each rotor and its mount [N], and its moment about the center of mass [N m].
    body_force, wing_force : ndarray, shape (..., 3)
        Forces at the center of mass [N]; zero without a body or wing.
    thrust, torque : ndarray, shape (..., k)
        Thrust and torque of each rotor [N], [N m].
    added_flow : ndarray, shape (..., k)
        Velocity that the wakes of the other rotors add to V cos(beta) [m/s]; zero if the ``wakes``
        of the vehicle are None.
    rotor_status : ndarray of str, shape (..., k)
        Status of each rotor.
    power : ndarray, shape (...)
        Total shaft power, the sum of torque times omega [W].
    """

    force: Floats
    moment: Floats
    status: NDArray[np.str_]
    rotor_force: Floats
    rotor_moment: Floats
    body_force: Floats
    wing_force: Floats
    thrust: Floats
    torque: Floats
    added_flow: Floats
    rotor_status: NDArray[np.str_]
    power: Floats


class VehicleForces:
    """Aerodynamic force and moment on a vehicle, computed from the loads of its rotors.

    Parameters
    ----------
    vehicle : Vehicle
        Vehicle, from ``propmap.read_vehicle(path).vehicle``.  Its rotors interact if it has
        ``wakes``.
    loads : Rotor or LoadTable
        Source of the loads of its rotors; other objects need a method ``loads_at_velocity``.

    Raises
    ------
    InputError
        For loads of another propeller or other air.  For a ``LoadTable``, if [mount] in the vehicle
        file has a drag area.  For interacting rotors at the same position.
    """

    def __init__(self, vehicle: Vehicle, loads: LoadSource) -> None:
        self.vehicle = vehicle
        self._rotors = Rotors.of(vehicle, loads)
        self._can_reverse = getattr(loads, "backward", isinstance(loads, Rotor))
        known = loads.model.uncertainty if isinstance(loads, Rotor) else None
        self._envelope = None if known is None else known.envelope

    def wrench(
        self,
        omega: ArrayLike,
        velocity: ArrayLike,
        rates: ArrayLike = (0.0, 0.0, 0.0),
        wind: ArrayLike = (0.0, 0.0, 0.0),
    ) -> VehicleWrench:
        """Return the aerodynamic force and moment on the vehicle.

        All vectors are in the vehicle's frame: x forward, y left, z up.  Leading axes broadcast.

        Parameters
        ----------
        omega : array_like, shape (..., k)
            Speeds of the k rotors, in the order of the vehicle's mounts [rad/s].  Negative speeds
            describe rotors that turn backward; they require a vehicle without wakes, and a
            ``Rotor`` or a table of such rotors.
        velocity : array_like, shape (..., 3)
            Velocity of the center of mass over the ground [m/s].
        rates : array_like, shape (..., 3)
            Angular velocity [rad/s].
        wind : array_like, shape (..., 3)
            Uniform velocity of the air over the ground [m/s]; convert a wind in the world's frame
            to the vehicle's frame first.

        Raises
        ------
        InputError
            For other shapes, non-finite values, and negative speeds with wakes or unsuitable loads.
        """
        k = len(self._rotors)
        vectors = {"velocity": velocity, "rates": rates, "wind": wind}
        can_reverse = self._rotors.wakes is None and self._can_reverse
        given = {"omega": numbers("omega", omega, negative=can_reverse)}
        given |= {name: broadcast(**{name: vector})[0] for name, vector in vectors.items()}
        for name, array in given.items():
            count, what = (3, "x, y, z") if name in vectors else (k, f"the {k} rotor speeds")
            if array.ndim == 0 or array.shape[-1] != count:
                raise InputError(f"{name} has shape {array.shape}", f"its last axis must be {what}")
        try:
            shape = np.broadcast_shapes(*(array.shape[:-1] for array in given.values()))
        except ValueError:
            shapes = ", ".join(f"{name} {array.shape}" for name, array in given.items())
            raise InputError(
                f"shapes do not fit together: {shapes}", "all axes except the last must broadcast"
            ) from None
        omega, moving, turning, air = (
            np.broadcast_to(array, (*shape, array.shape[-1])) for array in given.values()
        )
        through = moving - air
        hubs = through[..., None, :] + cross(turning[..., None, :], self._rotors.position)
        found = self._rotors.wrenches(omega, hubs)
        if self._envelope is not None:
            far = self._rotors.beyond(self._envelope, omega, hubs)
            words = np.where(far, "extrapolated", SEVERITY[0])
            found = found._replace(status=worst(np.stack([found.status, words], axis=-1)))
        moment = self._rotors.moment(found.force, found.moment)
        vehicle = self.vehicle
        body, wing = body_and_wing(vehicle.body, vehicle.wing, vehicle.air.density, through)
        return VehicleWrench(
            force=found.force.sum(axis=-2) + body + wing,
            moment=moment.sum(axis=-2),
            status=worst(found.status),
            rotor_force=found.force,
            rotor_moment=moment,
            body_force=body,
            wing_force=wing,
            thrust=found.thrust,
            torque=found.torque,
            added_flow=found.added_flow,
            rotor_status=found.status,
            power=np.sum(found.torque * omega, axis=-1),
        )


# --- Forces and moments of the interacting rotors of a vehicle -----------------------------------

THRUST, TORQUE = (list(LOADS).index(name) for name in ("thrust", "torque"))

FORWARD = 0.5  # rotors pull forward if the upward component of their mean axis is smaller
FLOW_STEP = 1e-2  # step of difference quotients by the axial flow [m/s]


class RotorWrenches(NamedTuple):
    """Forces, moments and loads of k rotors at (...) states."""

    force: Floats  # (..., k, 3) on the vehicle at the hub, in its frame [N]
    moment: Floats  # (..., k, 3) about the hub [N m]
    thrust: Floats  # (..., k) [N]
    torque: Floats  # (..., k) [N m]
    added_flow: Floats  # (..., k), added to V cos(beta) by other wakes [m/s]; NaN if unknown
    status: NDArray[np.str_]  # (..., k)


class Rotors:
    """All rotors of a vehicle, which interact if the vehicle has ``wakes``.

    ``sources`` compute the loads of the rotors.  The wakes follow from the thrust without
    interaction: ``attached_thrust`` of the rotor ``attached``, or by default the thrust from an
    additional evaluation of the sources.  Raises ``InputError`` for interacting rotors at the same
    position.
    """

    def __init__(self, vehicle: Vehicle, sources: Sources, attached: Rotor | None = None) -> None:
        self.vehicle, self.sources = vehicle, sources
        nothing = np.zeros((0, len(vehicle.mounts)))
        flow = flow_of_hubs(vehicle, nothing, np.zeros((*nothing.shape, 3)))
        self.position, self.axis, self.spin = flow.position, flow.axis, flow.spin
        self.radius = vehicle.propeller.radius
        self.wakes, self._attached = vehicle.wakes, attached
        if self.wakes is not None:
            check_apart(vehicle)

    def __len__(self) -> int:
        return len(self.spin)

    @property
    def forward(self) -> bool:
        """Whether the rotors pull forward rather than up."""
        return float(self.axis[:, 2].mean()) < FORWARD

    @classmethod
    def of(cls, vehicle: Vehicle, loads: LoadSource) -> Rotors:
        """Return the rotors with loads from a table, or from a ``Rotor`` and its model.

        Raises ``InputError`` if propeller or air differ from the vehicle.
        """
        if not isinstance(vehicle, Vehicle):
            remedy = "give propmap.read_vehicle(path).vehicle"
            raise InputError(f"vehicle is {type(vehicle).__name__}", remedy)
        if not isinstance(loads, LoadSource):
            raise InputError(
                f"loads is {type(loads).__name__}", "give a Rotor or a LoadTable of its rotors"
            )
        if not isinstance(loads, Rotor):
            check_table(vehicle, loads)
            return cls(vehicle, [(loads, np.arange(len(vehicle.mounts)))])
        model = loads.model
        if model.propeller != vehicle.propeller or model.air != vehicle.air:
            raise InputError(
                "the rotor has another propeller or air than the vehicle",
                "give Rotor(Model(vehicle.propeller, airfoil, vehicle.air))",
            )
        every: Sources = [(loads.with_model(own), k) for own, k in mounted_rotors(vehicle, model)]
        return cls(vehicle, every, loads if vehicle.wakes is not None else None)

    def moment(self, force: Floats, moment: Floats) -> Floats:
        """Return moments (..., k, 3) [N m] about the center of mass from the loads at the hubs."""
        return moment + cross(self.position, force)

    def wrenches(self, omega: Floats, velocity: Floats) -> RotorWrenches:
        """Return force and moment of each rotor at ``omega`` (..., k) [rad/s].

        The hubs move at ``velocity`` (..., k, 3) through the air, in the vehicle's frame [m/s].
        """
        flow = self._flow(omega, velocity)
        added = np.zeros_like(flow.omega)
        if self.wakes is None:
            loads, status = loads_at_hubs(self.sources, flow)
        else:
            alone = self._alone(flow)
            added = wake_flow(self.vehicle, self.wakes, flow, alone.thrust).added
            loads, status = self._in_wakes(flow, added, alone)
        return _as_wrenches(flow, loads, added, status, omega.shape)

    def beyond(self, envelope: Envelope, omega: Floats, velocity: Floats) -> NDArray[np.bool_]:
        """Return which rotors (..., k) are outside an ``envelope``; inputs as in ``wrenches``."""
        flow = self._flow(omega, velocity)
        outside = envelope.beyond(flow.omega, flow.axial, flow.inplane, self.radius).points
        return outside.reshape(omega.shape)

    def around(
        self, omega: Floats, velocity: Floats, change: float
    ) -> tuple[RotorWrenches, Floats, Floats]:
        """Return wrenches for s motions, and derivatives of the total wrench by each rotor speed.

        All motions have the rotor speeds ``omega`` (n, k) [rad/s]; their hub velocities are
        ``velocity`` (s, n, k, 3) [m/s].  ``change`` is the relative step of a rotor speed for the
        difference quotients.  The derivatives (n, k, 3) of the total force [N s] and moment [N m s]
        are for the first motion, and include the change of the wakes.
        """
        s, n, k = velocity.shape[:3]
        first, faster = np.arange(n), np.arange(s * n, (s + 1) * n)
        turning = np.tile(omega, (s + 1, 1))
        turning[faster] *= 1.0 + change
        moving = np.concatenate([velocity, velocity[:1]])
        flow = self._flow(turning, moving.reshape(-1, k, 3))
        added, wake = np.zeros_like(flow.omega), None
        if self.wakes is None:
            loads, status = loads_at_hubs(self.sources, flow)
        else:
            alone = self._alone(flow)
            wake = wake_flow(self.vehicle, self.wakes, flow.part(first), alone.thrust[first])
            rest = slice(n, s * n)
            others = wake_flow(self.vehicle, self.wakes, flow.part(rest), alone.thrust[rest]).added
            again = np.concatenate([np.arange((s + 1) * n), first])
            added = np.concatenate([wake.added, others, wake.added, wake.added + FLOW_STEP])
            flow, thrust = flow.part(again), alone.thrust
            loads, status = self._in_wakes(flow, added, alone.part(again))
        here, step = flow.part(first), omega * change
        force, moment = hub_wrenches(here, (loads[:, faster] - loads[:, first]) / step)
        moment = self.moment(force, moment)
        if wake is not None:
            # A rotor's speed changes the flow at the other rotors, and thereby their loads.
            push, turn = hub_wrenches(here, (loads[:, (s + 1) * n :] - loads[:, first]) / FLOW_STEP)
            by_speed = wake.by_thrust * ((thrust[faster] - thrust[first]) / step)[:, None]
            force = force + np.einsum("ntj,nts->nsj", push, by_speed)
            moment = moment + np.einsum("ntj,nts->nsj", self.moment(push, turn), by_speed)
        motions = slice(s * n)
        wrenches = _as_wrenches(
            flow.part(motions), loads[:, motions], added[motions], status[motions], (s, n, k)
        )
        return wrenches, force, moment

    def changed(self, changes: Sources, omega: Floats, velocity: Floats) -> RotorWrenches:
        """Return the first-order changes of forces and moments due to ``changes`` of the loads.

        A change of thrust also changes the wakes, even if ``attached_thrust`` determines the wakes.
        ``omega`` (n, k) and ``velocity`` (n, k, 3) are those of ``wrenches``.
        """
        flow = self._flow(omega, velocity)
        added = np.zeros_like(flow.omega)
        if self.wakes is None:
            loads, status = loads_at_hubs(changes, flow)
            return _as_wrenches(flow, loads, added, status, omega.shape)
        alone = self._alone(flow)
        wake = wake_flow(self.vehicle, self.wakes, flow, alone.thrust)
        here = np.nan_to_num(wake.added)
        more, less = (
            loads_at_hubs(self.sources, flow.perturbed(here + by))[0]
            for by in (FLOW_STEP, -FLOW_STEP)
        )
        # Evaluate both flows in one call: ``changes`` may store the result of its first call.
        twice = np.tile(np.arange(len(omega)), 2)
        both = flow.part(twice).perturbed(np.concatenate([np.zeros_like(added), here]))
        every, status = loads_at_hubs(changes, both)
        first, in_wakes = every[:, : len(omega)], every[:, len(omega) :]
        follows = np.einsum("nts,ns->nt", wake.by_thrust, first[THRUST])
        loads = in_wakes + (more - less) / (2.0 * FLOW_STEP) * follows
        return _as_wrenches(flow, loads, follows, status[len(omega) :], omega.shape)

    def _flow(self, omega: Floats, velocity: Floats) -> HubFlow:
        """Return the flow at the hubs, with all leading axes flattened to one."""
        k = len(self)
        return flow_of_hubs(self.vehicle, omega.reshape(-1, k), velocity.reshape(-1, k, 3))

    def _alone(self, flow: HubFlow) -> _Isolated:
        """Return the thrust of the rotors without interaction."""
        if self._attached is None:
            loads, status = loads_at_hubs(self.sources, flow)
            return _Isolated(loads[THRUST], status)
        thrust, _ = self._attached.attached_thrust(flow.omega, flow.axial, flow.inplane)
        return _Isolated(thrust, np.full(thrust.shape, SEVERITY[0]))

    def _in_wakes(
        self, flow: HubFlow, added: Floats, alone: _Isolated
    ) -> tuple[Floats, NDArray[np.str_]]:
        """Return loads and their status with ``added`` (n, k) axial flow [m/s]."""
        loads, found = loads_at_hubs(self.sources, flow.perturbed(np.nan_to_num(added)))
        lost = np.isnan(added)
        found = np.where(lost, worst(alone.status)[:, None], found)
        return np.where(lost, np.nan, loads), found


class _Isolated(NamedTuple):
    """Thrust that generates the wakes, NaN if it is unknown, and the status; (n, k) each."""

    thrust: Floats
    status: NDArray[np.str_]

    def part(self, which: NDArray[np.intp]) -> _Isolated:
        """Return the selected states."""
        return _Isolated(self.thrust[which], self.status[which])


def _as_wrenches(
    flow: HubFlow, loads: Floats, added: Floats, status: NDArray[np.str_], shape: tuple[int, ...]
) -> RotorWrenches:
    """Return loads (L, n, k) as ``RotorWrenches`` of the ``shape`` (..., k)."""
    force, moment = (values.reshape(*shape, 3) for values in hub_wrenches(flow, loads))
    thrust, torque = loads[THRUST].reshape(shape), loads[TORQUE].reshape(shape)
    return RotorWrenches(force, moment, thrust, torque, added.reshape(shape), status.reshape(shape))


def mounted_rotors(vehicle: Vehicle, model: Model) -> list[tuple[Model, NDArray[np.intp]]]:
    """Return a model for each different drag of a mount, with the indices of its rotors.

    Rotors whose mount has no ``drag`` use ``model`` unchanged.
    """
    drags = [mount.drag for mount in vehicle.mounts]
    return [
        (
            model if drag is None else model.with_mount(drag),
            np.array([k for k, other in enumerate(drags) if other == drag]),
        )
        for drag in dict.fromkeys(drags)
    ]


# --- Loads of a vehicle's rotors from a rotor model, a table or the hover model ------------------

USABLE, (RING, LOST) = STATUSES[:-2], STATUSES[-2:]
SEVERITY = (*USABLE, "extrapolated", RING, "unresolved", "clamped", LOST, "no_value", "outside")
"""Statuses of rotors, of tables, and of points outside a fit's data, from harmless to fatal."""


@runtime_checkable
class LoadSource(Protocol):
    """Interface of ``Rotor`` and ``LoadTable``: loads for a velocity in the rotor frame."""

    def loads_at_velocity(self, omega: Any, velocity: Any) -> Any:
        """Return loads with a ``status``."""
        ...


Sources = list[tuple[LoadSource, NDArray[np.intp]]]
"""Sources of loads, each with the indices of its rotors."""


def loads_at_hubs(sources: Sources, flow: HubFlow) -> tuple[Floats, NDArray[np.str_]]:
    """Return loads (L, n, k) of the ``sources`` in the ``flow``, and their status (n, k)."""
    loads = np.empty((len(LOADS), *flow.omega.shape))
    status = np.empty(flow.omega.shape, dtype="<U16")
    for source, mine in sources:
        parts = [values[:, mine] for values in (flow.omega, flow.inplane, flow.axial)]
        if not parts[0].size:
            continue
        # Rotors of a symmetric vehicle have equal points, which are evaluated once.
        once, where = _distinct(np.stack(parts, axis=-1).reshape(-1, 3))
        where = where.reshape(parts[0].shape)
        omega, across, along = once.T
        found, words = load_rows(source, omega, along, across)
        loads[:, :, mine], status[:, mine] = found[:, where], words[where]
    return loads, status


def load_rows(
    source: LoadSource, omega: Floats, axial: Floats, inplane: Floats
) -> tuple[Floats, NDArray[np.str_]]:
    """Return loads (L, N) of a ``source`` in the order of ``LOADS``, and their status (N,)."""
    velocity = np.stack([inplane, np.zeros_like(inplane), axial], axis=1)
    found = source.loads_at_velocity(omega, velocity)
    return np.stack([getattr(found, name) for name in LOADS]), np.asarray(found.status)


def worst(status: NDArray[np.str_]) -> NDArray[np.str_]:
    """Return the worst ``status`` (..., k) of all rotors, (...)."""
    names = np.array(SEVERITY)
    order = np.argsort(names)
    rank = order[np.searchsorted(names, status, sorter=order)]
    return np.asarray(names[rank.max(axis=-1)])


def _distinct(points: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Return the distinct rows of points (n, 3), ignoring rounding errors, and for each point the
    index of its distinct row."""
    size = np.maximum(np.abs(points).max(axis=0, initial=0.0), 1e-30)
    rounded = np.round(points / size, 11) + 0.0
    order = np.lexsort(rounded.T)
    ranked = rounded[order]
    new = np.append(True, (ranked[1:] != ranked[:-1]).any(axis=1))
    where = np.empty(len(points), np.intp)
    where[order] = np.cumsum(new) - 1
    return points[order[new]], where


def check_table(vehicle: Vehicle, table: Any) -> None:
    """Raise ``InputError`` if a ``table``, or another source of loads, does not fit the vehicle."""
    if any(mount.drag is not None for mount in vehicle.mounts):
        raise InputError(
            "the vehicle file has [mount], which does not apply to a table",
            "remove [mount], and build the table with --correction installed:area_m2=...",
        )
    described = getattr(table, "info", {}).get("propeller")
    if described is None:
        return
    if table.backward and (vehicle.wakes is not None or vehicle.wing is not None):
        found = (
            "the table is for propellers that turn backward, but the vehicle has wakes or a wing"
        )
        raise InputError(found, "ignore the wakes (--no-wakes), remove [wing]")
    if described.get("geometry_sha256") != vehicle.propeller.fingerprint():
        raise InputError(
            f"the table is for {described.get('name')!r}, but the propeller of the vehicle is "
            f"{vehicle.propeller.name!r} or has another geometry",
            "build a table for the propeller of the vehicle",
        )
    if abs(table.content.density - vehicle.air.density) > 1e-6 * vehicle.air.density:
        raise InputError(
            f"the table is valid for {table.content.density:g} kg/m^3, the vehicle flies in "
            f"{vehicle.air.density:g} kg/m^3",
            "build a table with --rho, or change [air]",
        )


# --- Forces of body and wing in the free stream: section III.A and footnote 4 of the paper -------


def free_stream_force(body: Body, wing: Wing | None, density: float, velocity: Floats) -> Floats:
    """Return the force of body and wing [N] at a ``velocity`` (..., 3) through the air [m/s].

    Both vectors are in the vehicle's frame; ``density`` is the air density [kg/m^3].
    """
    return np.asarray(sum(body_and_wing(body, wing, density, velocity)))


def body_and_wing(
    body: Body, wing: Wing | None, density: float, velocity: Floats
) -> tuple[Floats, Floats]:
    """Return the forces of body and wing in ``free_stream_force``, zero without a ``wing``."""
    from propmap import core

    rows = np.ascontiguousarray(velocity).reshape(-1, 3)
    found = core.free_stream_forces(airframe(body, wing, density), rows)
    of_body, of_wing = (each.reshape(velocity.shape) for each in found)
    return of_body, of_wing


def airframe(body: Body, wing: Wing | None, density: float) -> dict[str, Any]:
    """Return body, wing and air ``density`` [kg/m^3] in the form that the core reads."""
    found: dict[str, Any] = {"density": float(density), "lift_area": float(body.lift_area)}
    found["plate_area"] = float(body.plate_area)
    for name in ("drag_area", "download_area"):
        found[name] = np.array(getattr(body, name), np.float64)
    if wing is not None:
        found |= {"wing": _section(wing).core_law(), "wing_area": float(wing.area)}
        found |= {"incidence": float(wing.incidence), "span": float(wing.span or 0.0)}
    return found


def wing_lift(wing: Wing, angle: Floats) -> Floats:
    """Return lift / dynamic pressure [m^2] of a ``wing`` at an ``angle`` of attack [rad]."""
    lift, _ = _section(wing).coefficients(angle, 1.0)  # eq. (3), which does not depend on Re
    return wing.area * lift


def _section(wing: Wing) -> Airfoil:
    return Airfoil(c_l1=wing.c_l1, c_l2=wing.c_l2, c_d=0.0, alpha_0=wing.alpha_0)
