"""The numbers that the theory works on: blade, section, air, and how finely to resolve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from propmap.arrays.namespace import Array


class Blade(NamedTuple):
    """Geometry of one propeller, a pytree that can be differentiated.

    station : shape (n,) [m], radii of the measured stations, rising.
    chord : shape (n,) [m], chord at the stations.
    twist : shape (n,) [rad], angle of the chord line to the disk plane at the stations.
    cubics : shape (n - 1, 10), the curves between them, a row per interval (``blade_shape``).
    blades : scalar [-], number of blades N_b.
    root : scalar [m], radius at which integration starts (first station or root cut-out).
    """

    station: Array
    chord: Array
    twist: Array
    cubics: Array
    blades: Array
    root: Array

    @property
    def tip(self) -> Array:
        """Blade radius R [m], the last station."""
        return self.station[-1]


class Section(NamedTuple):
    """Parameters of the section law, eqs. (3)(4); all scalars.

    c_l1 : [1/rad], slope of the attached lift.
    c_l2 : [-], amplitude of the separated lift.
    c_d : [-], amplitude of the pressure drag.
    alpha_0 : [rad], angle of attack about which the stall blend is centred.
    zero_lift_angle : [rad], angle of attack of zero lift; (3)(4) see alpha minus it.
    c_d0 : [-], constant drag.
    c_p : [-], skin-friction constant of the 1/sqrt(Re) term.
    sharpness : [1/rad], the blend's M.
    attached : [-], 1 for eq. (3); 0 for the simplified lift of footnote 1, with c_l2 as c_l.
    drag_factor : [-], multiplies the rotor drag (14); 1 in the paper.
    """

    c_l1: Array
    c_l2: Array
    c_d: Array
    alpha_0: Array
    zero_lift_angle: Array
    c_d0: Array
    c_p: Array
    sharpness: Array
    attached: Array
    drag_factor: Array | float = 1.0


class Medium(NamedTuple):
    """The air; scalars.

    density : [kg/m^3].  viscosity : [Pa s], dynamic.
    """

    density: Array
    viscosity: Array


@dataclass(frozen=True)
class Resolution:
    """How finely one evaluation is resolved; static under ``jit``.

    azimuths : azimuth nodes over a full turn (even), or 1 for flow along the axis alone.
    stations : radial nodes on the whole blade.
    follow_stall : split the blade at branch jumps of the inflow (``stall_split``).  Needed
        wherever some of the blade stalls, hover first of all.
    """

    azimuths: int = 48
    stations: int = 48
    follow_stall: bool = True

    def __post_init__(self) -> None:
        if self.azimuths != 1 and (self.azimuths < 4 or self.azimuths % 2):
            raise ValueError(
                f"azimuths is {self.azimuths}: it must be 1 (axial flow) or an even number >= 4"
            )
        if self.stations < 16:
            raise ValueError(f"stations is {self.stations}: it must be at least 16")

    @property
    def panels(self) -> tuple[int, ...]:
        """Radial nodes on each panel, from the root outwards."""
        if not self.follow_stall:
            return (self.stations,)
        inner, middle = self.stations // 4, 3 * self.stations // 8
        return (inner, middle, self.stations - inner - middle)
