"""Units in SI (multiply by a unit to get SI, divide to convert from SI), and standard constants."""

from __future__ import annotations

import math

RPM = math.pi / 30.0  # a revolution per minute [rad/s]
DEGREE = math.pi / 180.0  # [rad]
INCH, FOOT = 0.0254, 0.3048  # [m]
MM = 1e3  # millimeters in a meter: multiply to convert from SI, for pictures
KMH, MPH = 1.0 / 3.6, 0.44704  # a kilometer and a mile per hour [m/s]
KNOT, HORSEPOWER = 1852.0 / 3600.0, 745.69987  # [m/s]; mechanical horsepower [W]
MICROSECOND = 1e-6  # [s]
GRAVITY = 9.80665  # standard gravity [m/s^2], and the weight of a kilogram [N]
POUND = 4.4482216152605  # the weight of a pound [N], sixteen ounces
SLUG_PER_FT3 = 515.378818393  # [kg/m^3]
SPEED_OF_SOUND = 340.3  # at sea level, 15 degrees Celsius (ISO 2533, ICAO Doc 7488/3) [m/s]
