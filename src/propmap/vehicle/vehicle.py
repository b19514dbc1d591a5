"""A vehicle: rotors on a frame, its mass, and what its body and wing add to their forces."""

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
    """Where a rotor sits, in the vehicle's frame: x forward, y left, z up; and on what.

    Attributes
    ----------
    position : tuple of 3 float
        Position of the hub relative to the centre of mass [m].
    axis : tuple of 3 float
        Unit vector along the thrust [-].
    spin : str
        "ccw" or "cw", seen from above with the thrust up.
    drag : Installed or None
        What carries it in its slipstream, such as motor and arm; None for what the section law
        brings along, where it was fitted with a mount.
    """

    position: Vector
    axis: Vector = (0.0, 0.0, 1.0)
    spin: str = "ccw"
    drag: Installed | None = None


@dataclass(frozen=True)
class Body:
    """Forces of the body itself (the paper's section III.A), in the vehicle's frame.

    Attributes
    ----------
    drag_area : tuple of 3 float
        Along each axis [m^2]; F_k = -1/2 rho drag_area_k |v_k| v_k.
    lift_area : float
        Lift across the flow is 1/2 rho V^2 lift_area sin(a) cos(a) [m^2], a the angle of attack of
        the body in its plane of symmetry.
    download_area : tuple of 2 float
        For flow along x and along y [m^2]: F_z = -1/2 rho download_area_k v_k^2, whichever way it
        flows; negative where it lifts.
    plate_area : float
        Area of what lies level, as a plate [m^2]: F_z = -1/2 rho plate_area V v_z. In flow along z
        its force is that of an equal ``drag_area``; in oblique flow it is larger.
    """

    drag_area: Vector = (0.0, 0.0, 0.0)
    lift_area: float = 0.0
    download_area: tuple[float, float] = (0.0, 0.0)
    plate_area: float = 0.0


@dataclass(frozen=True)
class Wing:
    """A wing in the free stream whose lift follows eq. (3) (the paper's footnote 4).

    Attributes
    ----------
    area : float
        Area of the wing [m^2].
    incidence : float
        Angle between its zero-lift line and the vehicle's x axis [rad], positive leading edge up.
    c_l1, c_l2, alpha_0 : float
        As for a blade section [1/rad], [-], [rad].
    span : float or None
        [m], for the drag that comes with lift, that of an elliptic wing: Prandtl, NACA report 116,
        1921; None for no such drag, as in the paper.
    """

    area: float
    incidence: float = 0.0
    c_l1: float = 5.0
    c_l2: float = 1.0
    alpha_0: float = 0.3
    span: float | None = None


@dataclass(frozen=True)
class Wakes:
    """How the rotors' wakes act on each other, see ``propmap.vehicle.wakes``.

    Where rotors are above each other, the slipstreams of the upper ones act on the lower ones, and
    no gain counts.

    Attributes
    ----------
    ahead, beside, downwash : float
        Factors on the velocity that a vortex cylinder induces [-]: on upwash at rotors ahead of or
        behind the one whose wake it is, as the air meets it, on upwash at rotors beside it, and on
        downwash; 1 is the cylinder's own, 0 none.
    share : float
        Share of a rotor's inflow in the air that carries its wake away [-]: 1 at the disk, 2 far
        below.
    """

    ahead: float = 1.0
    beside: float = 1.0
    downwash: float = 1.0
    share: float = 1.0

    @property
    def slipstreams_alone(self) -> bool:
        """Whether no wake acts but the slipstreams of rotors on those below them."""
        return self == SLIPSTREAMS


SLIPSTREAMS = Wakes(ahead=0.0, beside=0.0, downwash=0.0)
"""What acts in a vehicle whose file has no [wakes]."""


@dataclass(frozen=True, eq=False)
class Vehicle:
    """Rotors of one kind on a frame.

    Attributes
    ----------
    name : str
        What it is called.
    mass : float
        Take-off mass [kg].
    propeller : Propeller
        Propeller of every rotor.
    mounts : tuple of Mount
        One per rotor, in the order of the rotor speeds.
    air : Air
        By default the paper's.
    body, wing : Body, Wing or None
        What else carries or drags.
    powertrain : Powertrain
        What turns the rotors, as far as it is known.
    wakes : Wakes or None
        How the rotors' wakes act on each other; None for not at all, as in the paper.  A file
        without [wakes] has ``SLIPSTREAMS`` where rotors are above each other.
    sensor : tuple of 3 float
        Where the accelerometer of its logs is, from the centre of mass [m].
    inertia : tuple of 3 float, or None
        Moments of inertia about its axes through the centre of mass [kg m^2]; None where they are
        not known.
    rotor_inertia : float
        Moment of inertia of one rotor with what turns with it, about its axis [kg m^2].

    Raises
    ------
    InputError
        For a mass, a spin or an axis that cannot be.
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
            raise InputError(f"mass is {self.mass} kg", "give the take-off mass in kg")
        if not self.mounts:
            raise InputError("the vehicle has no rotor", "add a [[rotors]] table per rotor")
        if self.inertia is not None:
            largest, what = max(self.inertia), f"inertia is {list(self.inertia)} kg m^2"
            if not min(self.inertia) > 0.0:
                raise InputError(what, "give three numbers above zero, or leave it out")
            if largest > (sum(self.inertia) - largest) * 1.001:
                found = f"{what}, one of which is more than the other two together"
                raise InputError(found, "check the order [about x, about y, about z] and the units")
        if not 0.0 <= self.rotor_inertia < 0.1 * self.mass:
            remedy = "give that of one rotor with its motor's bell about its axis, or leave it out"
            raise InputError(f"rotor_inertia is {self.rotor_inertia:g} kg m^2", remedy)
        for k, mount in enumerate(self.mounts, start=1):
            if mount.spin not in SPINS:
                fault = f"rotor {k}: spin is {mount.spin!r}"
                raise InputError(fault, "give 'ccw' or 'cw', seen from above")
            length = sum(a * a for a in mount.axis) ** 0.5
            if abs(length - 1.0) > 1e-6:
                fault = f"rotor {k}: the axis has length {length:g}"
                raise InputError(fault, "give a unit vector, [0, 0, 1]")

    @property
    def hub_positions(self) -> Floats:
        """Positions of the k hubs relative to the centre of mass, (k, 3) [m]."""
        return np.array([mount.position for mount in self.mounts])

    @property
    def rotor_axes(self) -> Floats:
        """Unit vectors along the thrust of the k rotors, (k, 3) [-]."""
        return np.array([mount.axis for mount in self.mounts])
