"""The drag model of an autopilot's Kalman filter: its parameters, and what it makes of flights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.export.drag_fit import Comparison, compare, fit_drag
from propmap.export.parameter_note import holds
from propmap.export.parameter_set import Explained, Flights
from propmap.typing import Floats
from propmap.vehicle.vehicle import Vehicle

SEA_LEVEL = 1.225
"""Density [kg/m^3] at which both PX4 and ArduPilot define the drag of the rotors."""

STEP = 1e-4
"""Share by which a velocity is changed in a difference quotient."""


@dataclass(frozen=True)
class DragFilter:
    """The equation of a filter, in flight along one body axis.

    Specific force against the motion = M (rho / 1.225)^power v + 1/2 rho v s / B, where s is the
    size of the whole velocity or that of its component v along the axis.

    Attributes
    ----------
    momentum, ballistic : str
        Names of M [1/s], and of B [kg/m^2] but for the axis.
    power : float
        Of the density's ratio.
    whole : bool
        Whether s is the size of the whole velocity.
    largest : float
        B beyond which there is no body drag [kg/m^2].
    source : str
        Where the equation stands.
    between : str
        What the filter does in flight between the axes, in words.
    """

    momentum: str
    ballistic: str
    power: float
    whole: bool
    largest: float
    source: str
    between: str

    def force(
        self, values: dict[str, float], axis: str, density: float, along: Floats, through: Floats
    ) -> Floats:
        """Specific force against the motion [m/s^2], of the velocities' shape.

        Parameters
        ----------
        values : dict of str to float
            The parameters by name.
        axis : str
            "x" or "y".
        density : float
            Of the air [kg/m^3].
        along, through : ndarray
            Component of the velocity along the axis, above 0, and the size of it all [m/s].
        """
        ballistic = values[self.ballistic + axis.upper()]
        inverse = 1.0 / ballistic if ballistic > 1.0 else 0.0
        rotors = values[self.momentum] * self.scale(density)
        return np.asarray(rotors * along + 0.5 * inverse * density * self.square(along, through))

    def square(self, along: Floats, through: Floats) -> Floats:
        """v s [m^2/s^2] of velocities as in ``force``."""
        return along * through if self.whole else along**2

    def scale(self, density: float) -> float:
        """What M is multiplied by at a ``density`` [kg/m^3]."""
        return float((density / SEA_LEVEL) ** self.power)

    def parameters(
        self, flights: Flights, vehicle: Vehicle
    ) -> tuple[list[Explained], list[Comparison]]:
        """The parameters, and the flights beside what the filter makes of them.

        Parameters
        ----------
        flights : tuple of 2 InplaneForces
            Along x and y.
        vehicle : Vehicle
            That flies.
        """
        density = vehicle.air.density
        fit = fit_drag(
            flights, lambda one: self.square(one.along, one.through), density, 1.0 / self.largest
        )
        scale = self.scale(density)
        values = {self.momentum: round(fit.momentum / scale, 6)}
        for axis, inverse in zip("XY", fit.inverse, strict=True):
            values[self.ballistic + axis] = round(1.0 / inverse, 4) if inverse else 0.0
        comparisons = [self._compared(values, k, flights, vehicle) for k in (0, 1)]
        where = holds(comparisons)
        slope = flights[0].force[0] / flights[0].along[0] / scale
        std = fit.std
        kinds = [
            Explained(
                title=self.momentum,
                values={self.momentum: values[self.momentum]},
                unit="1/s",
                std=None if std is None else std[0] / scale,
                meaning=self._momentum_words(),
                source=self.source,
                holds=f"{where} At {flights[0].speed[0]:g} m/s alone it would be {slope:.4f}.",
            )
        ]
        for k, axis in enumerate("XY"):
            name, inverse = self.ballistic + axis, fit.inverse[k]
            kinds.append(
                Explained(
                    title=name,
                    values={name: values[name]},
                    unit="kg/m^2",
                    std=None if std is None or not inverse else std[1 + k] / inverse**2,
                    meaning=self._ballistic_words(axis.lower()),
                    source=self.source,
                    holds=f"As {self.momentum}: the two belong together.",
                )
            )
        return kinds, comparisons

    def _compared(
        self, values: dict[str, float], k: int, flights: Flights, vehicle: Vehicle
    ) -> Comparison:
        flight, density = flights[k], vehicle.air.density
        slower, here, faster = (
            self.force(values, flight.axis, density, scale * flight.along, scale * flight.through)
            for scale in (1.0 - STEP, 1.0, 1.0 + STEP)
        )
        slope = (faster - slower) / (2.0 * STEP * flight.along)
        return compare(flight, vehicle.mass, here, slope)

    def _momentum_words(self) -> str:
        ratio = "sqrt(rho / 1.225 kg/m^3)" if self.power == 0.5 else "(rho / 1.225 kg/m^3)"
        return (
            f"Specific force against the motion, along x and y alike: {self.momentum} {ratio} v, v "
            "the component of the velocity through the air. It is what the rotors add, linear in "
            "the speed; below 0.001 the filter leaves it out."
        )

    def _ballistic_words(self, axis: str) -> str:
        name = self.ballistic + axis.upper()
        size = "v |V|" if self.whole else "v^2"
        told = "v the component of the velocity along the axis"
        told += ", |V| the size of it all" if self.whole else ""
        return (
            f"Specific force along {axis} against the motion: 1/2 rho {size} / {name}, {told}"
            f"{self.between}. It is the mass over the drag area of what is quadratic in the speed: "
            "the body, and what of the rotors' drag is not linear. It is 0, which leaves it out, "
            f"where it would be above {self.largest:g}."
        )
