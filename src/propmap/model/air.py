"""Density and viscosity of the air, by default those of the paper."""

from __future__ import annotations

import math
from dataclasses import dataclass

from propmap.errors import InputError

PAPER_DENSITY = 1.225
PAPER_VISCOSITY = 1.983e-5


@dataclass(frozen=True)
class Air:
    """Density and viscosity of the air around the propeller, by default those of the paper.

    Attributes
    ----------
    density : float
        rho [kg/m^3].
    viscosity : float
        Dynamic viscosity mu [Pa s].

    Raises
    ------
    InputError
        For values that are not finite and positive.
    """

    density: float = PAPER_DENSITY
    viscosity: float = PAPER_VISCOSITY

    def __post_init__(self) -> None:
        for name, unit in (("density", "kg/m^3"), ("viscosity", "Pa s")):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise InputError(f"air {name} is {value!r}: give a number in {unit}")
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(f"air {name} is {value}: it must be positive and finite [{unit}]")

    @classmethod
    def standard(cls, altitude: float = 0.0, temperature_offset: float = 0.0) -> Air:
        """Return the air of the ICAO standard atmosphere, optionally with another temperature.

        The offset changes the temperature at constant pressure.  The viscosity follows
        Sutherland's law of the same standard (ICAO Doc 7488/3, 1993).

        Parameters
        ----------
        altitude : float
            Geometric altitude above mean sea level [m], -5000 to 80000.
        temperature_offset : float
            Difference from the standard temperature [K], -60 to 60.

        Raises
        ------
        InputError
            For a value outside these ranges.
        """
        if not -5000.0 <= altitude <= 80000.0:
            raise InputError(f"altitude is {altitude} m: it must lie between -5000 and 80000 m")
        if not -60.0 <= temperature_offset <= 60.0:
            raise InputError(
                f"temperature offset is {temperature_offset} K: it must lie between -60 and 60 K"
            )
        from ambiance import CONST, Atmosphere

        day = Atmosphere(altitude)
        temperature = float(day.temperature[0]) + temperature_offset
        density = float(day.pressure[0]) / (CONST.R * temperature)
        viscosity = CONST.beta_s * temperature**1.5 / (temperature + CONST.S)
        return cls(density, float(viscosity))
