"""Units in SI (multiply by one to get SI, divide by it to leave SI), and standard constants."""

from __future__ import annotations

import math

RPM = math.pi / 30.0  # a revolution per minute [rad/s]
DEGREE = math.pi / 180.0  # [rad]
INCH, FOOT = 0.0254, 0.3048  # [m]
MM = 1e3  # millimetres in a metre: multiply by it to leave SI, for pictures
KMH, MPH = 1.0 / 3.6, 0.44704  # a kilometre and a mile per hour [m/s]
KNOT, HORSEPOWER = 1852.0 / 3600.0, 745.69987  # [m/s], and the mechanical one [W]
MICROSECOND = 1e-6  # [s]
GRAVITY = 9.80665  # standard gravity [m/s^2], and a kilogram's weight [N]
POUND = 4.4482216152605  # a pound's weight [N], sixteen ounces
SLUG_PER_FT3 = 515.378818393  # [kg/m^3]
SPEED_OF_SOUND = 340.3  # at sea level, 15 degrees Celsius (ISO 2533, ICAO Doc 7488/3) [m/s]
