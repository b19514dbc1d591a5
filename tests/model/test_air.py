"""Density and viscosity of the air."""

from __future__ import annotations

from typing import Any

import pytest

from propmap import Air, InputError


@pytest.mark.parametrize(
    ("altitude", "density", "viscosity"),
    [
        # ICAO Doc 7488/3: kg/m^3 to four decimals, uPa s to three.  2000 m of geometric
        # altitude are 1999.4 m of geopotential, 6e-5 kg/m^3 from the figure tabulated there.
        (0.0, 1.2250, 1.7894e-5),
        (2000.0, 1.0065, 1.7260e-5),
    ],
)
def test_standard_atmosphere_is_icaos(altitude: float, density: float, viscosity: float) -> None:
    air = Air.standard(altitude)
    assert air.density == pytest.approx(density, abs=1.2e-4)
    assert air.viscosity == pytest.approx(viscosity, abs=1e-8)


def test_hotter_air_is_thinner_at_the_same_pressure() -> None:
    altitude = 2000.0
    day, hot = Air.standard(altitude), Air.standard(altitude, 20.0)
    # rho T is p/R; the standard day has 288.15 K less 6.5 K per kilometer, to 1e-2 K.
    kelvin = 288.15 - 0.0065 * altitude
    assert hot.density == pytest.approx(day.density * kelvin / (kelvin + 20.0), rel=1e-5)
    assert hot.viscosity > day.viscosity  # a gas, Sutherland


@pytest.mark.parametrize("bad", [0.0, float("nan"), "1.2", True])
@pytest.mark.parametrize("field", ["density", "viscosity"])
def test_bad_air_is_refused(field: str, bad: Any) -> None:
    with pytest.raises(InputError, match=f"air {field} is"):
        Air(**{field: bad})


@pytest.mark.parametrize(
    ("altitude", "offset", "told"),
    [
        (-5001.0, 0.0, "altitude is"),
        (80001.0, 0.0, "altitude is"),
        (0.0, -61.0, "temperature offset is"),
        (0.0, float("nan"), "temperature offset is"),
    ],
)
def test_air_outside_the_standard_is_refused(altitude: float, offset: float, told: str) -> None:
    with pytest.raises(InputError, match=told):
        Air.standard(altitude, offset)
