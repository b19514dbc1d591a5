"""A vehicle: mass, rotors, body, wing, and the interaction of its rotors."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from propmap.errors import InputError
from propmap.model.air import Air
from propmap.model.corrections import Installed
from propmap.model.propeller import Propeller
from propmap.typing import Floats
from propmap.vehicle.powertrain import Powertrain

SPINS = ("ccw", "cw")
Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Mount:
    """Position, axis, spin and mount of a rotor in the vehicle's frame: x forward, y left, z up.

    Attributes
    ----------
    position : tuple of 3 float
        Position of the hub relative to the center of mass [m].
    axis : tuple of 3 float
        Unit vector along the thrust [-].
    spin : str
        "ccw" or "cw", seen from above with the thrust up.
    drag : Installed or None
        Drag of the parts in the slipstream, such as motor and arm; None if the vehicle file
        contains none.  Then the correction "installed" of the model applies, if it has one.
    """

    position: Vector
    axis: Vector = (0.0, 0.0, 1.0)
    spin: str = "ccw"
    drag: Installed | None = None


@dataclass(frozen=True)
class Body:
    """Forces of the body (section III.A of the paper), in the vehicle's frame.

    Attributes
    ----------
    drag_area : tuple of 3 float
        Drag area along each axis [m^2]; F_k = -1/2 rho drag_area_k |v_k| v_k.
    lift_area : float
        Lift area [m^2]; the lift normal to the flow is 1/2 rho V^2 lift_area sin(a) cos(a), where a
        is the angle of attack of the body in its plane of symmetry.
    download_area : tuple of 2 float
        Download areas for flow along x and y [m^2]: F_z = -1/2 rho download_area_k v_k^2, for both
        signs of v_k.  Negative areas give lift.
    plate_area : float
        Area of the horizontal parts (frame, battery, arms) [m^2], which act as a flat plate:
        F_z = -1/2 rho plate_area V v_z.  In flow along z, a ``drag_area`` of this size has the
        same force.  In oblique flow, the plate has the larger force.
    """

    drag_area: Vector = (0.0, 0.0, 0.0)
    lift_area: float = 0.0
    download_area: tuple[float, float] = (0.0, 0.0)
    plate_area: float = 0.0


@dataclass(frozen=True)
class Wing:
    """A wing in the free stream with the lift of eq. (3) (footnote 4 of the paper).

    Attributes
    ----------
    area : float
        Area of the wing [m^2].
    incidence : float
        Angle between its zero-lift line and the vehicle's x axis [rad], positive leading edge up.
    c_l1, c_l2, alpha_0 : float
        Section constants, as for a blade section [1/rad], [-], [rad].
    span : float or None
        Span [m] for the induced drag of an elliptic wing: Prandtl, NACA report 116, 1921; None for
        no induced drag, as in the paper.
    """

    area: float
    incidence: float = 0.0
    c_l1: float = 5.0
    c_l2: float = 1.0
    alpha_0: float = 0.3
    span: float | None = None


@dataclass(frozen=True)
class Wakes:
    """Interaction of the rotors through their wakes, see ``propmap.vehicle.wakes``.

    For overlapping rotors above each other, the slipstream of the upper rotor acts on the lower
    rotor.  The gains do not apply to slipstreams.

    Attributes
    ----------
    ahead, beside, downwash : float
        Gains on the velocity induced by a vortex cylinder [-]: 1 for the value of the cylinder, 0
        for none.  ``ahead`` multiplies upwash at rotors ahead of or behind the source rotor in the
        flight direction.  ``beside`` multiplies upwash at rotors to its side.  ``downwash``
        multiplies downwash.
    share : float
        Factor on the inflow in the velocity that carries the wake [-]: 1 at the disk, 2 far below.
    """

    ahead: float = 1.0
    beside: float = 1.0
    downwash: float = 1.0
    share: float = 1.0

    @property
    def slipstreams_alone(self) -> bool:
        """Whether only the slipstreams of upper rotors act on lower rotors."""
        return self == SLIPSTREAMS


SLIPSTREAMS = Wakes(ahead=0.0, beside=0.0, downwash=0.0)
"""Interaction in a vehicle whose file has no [wakes]."""


@dataclass(frozen=True, eq=False)
class Vehicle:
    """A vehicle whose rotors have identical propellers.

    Attributes
    ----------
    name : str
        Name of the vehicle.
    mass : float
        Take-off mass [kg].
    propeller : Propeller
        Propeller of every rotor.
    mounts : tuple of Mount
        One per rotor, in the order of the rotor speeds.
    air : Air
        Air (default: values of the paper).
    body, wing : Body, Wing or None
        Forces of the body, and of a wing if there is one.
    powertrain : Powertrain
        Known components of the powertrain.
    wakes : Wakes or None
        Interaction of the rotors; None for no interaction, as in the paper.  If a file has no table
        [wakes] but rotors are above each other, only slipstreams act on the lower rotors.
    sensor : tuple of 3 float
        Position of the accelerometer of its logs relative to the center of mass [m].
    inertia : tuple of 3 float, or None
        Moments of inertia about its axes through the center of mass [kg m^2]; None if unknown.
    rotor_inertia : float
        Moment of inertia of one rotor and its rotating motor parts about the rotor axis [kg m^2].

    Raises
    ------
    InputError
        For an impossible mass, inertia, spin or axis.
    """

    name: str
    mass: float
    propeller: Propeller
    mounts: tuple[Mount, ...]
    air: Air = field(default_factory=Air)
    body: Body = Body()
    wing: Wing | None = None
    powertrain: Powertrain = field(default_factory=Powertrain)
    wakes: Wakes | None = None
    sensor: Vector = (0.0, 0.0, 0.0)
    inertia: Vector | None = None
    rotor_inertia: float = 0.0

    def __post_init__(self) -> None:
        if not 0.001 <= self.mass <= 1000.0:
            fault = f"mass is {self.mass} kg, expected 0.001 to 1000"
            raise InputError(fault, "give the take-off mass in kg")
        if not self.mounts:
            raise InputError("the vehicle has no rotor", "add a [[rotors]] table per rotor")
        if self.inertia is not None:
            largest, what = max(self.inertia), f"inertia is {list(self.inertia)} kg m^2"
            if not min(self.inertia) > 0.0:
                raise InputError(what, "give three numbers above zero, or leave it out")
            if largest > (sum(self.inertia) - largest) * 1.001:
                found = f"{what}: one value is larger than the sum of the others"
                raise InputError(found, "check the order [about x, about y, about z] and the units")
        if not 0.0 <= self.rotor_inertia < 0.1 * self.mass:
            remedy = "give the inertia of one rotor and its motor's bell about the rotor axis, or "
            remedy += "leave it out"
            raise InputError(f"rotor_inertia is {self.rotor_inertia:g} kg m^2", remedy)
        for k, mount in enumerate(self.mounts, start=1):
            if mount.spin not in SPINS:
                fault = f"rotor {k}: spin is {mount.spin!r}"
                raise InputError(fault, "give 'ccw' or 'cw', seen from above")
            length = sum(a * a for a in mount.axis) ** 0.5
            if abs(length - 1.0) > 1e-6:
                fault = f"rotor {k}: the axis has length {length:g}"
                raise InputError(fault, "give a unit vector, such as [0, 0, 1]")

    @property
    def hub_positions(self) -> Floats:
        """Positions of the k hubs relative to the center of mass, (k, 3) [m]."""
        return np.array([mount.position for mount in self.mounts])

    @property
    def rotor_axes(self) -> Floats:
        """Unit vectors along the thrust of the k rotors, (k, 3) [-]."""
        return np.array([mount.axis for mount in self.mounts])
