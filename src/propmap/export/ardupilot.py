"""Target ``ardupilot``: parameters of ArduPilot's Kalman filter and thrust curve.

The definitions come from ArduPilot's source, in the file that each parameter names.  The file
format is the one of Mission Planner and MAVProxy.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from propmap.aircraft.trim import Aircraft
from propmap.export import autopilot, steady_loads
from propmap.typing import Floats
from propmap.vehicle.vehicle import Vehicle

FILTER = autopilot.DragFilter(
    momentum="EK3_DRAG_MCOEF",
    ballistic="EK3_DRAG_BCOEF_",
    power=1.0,
    whole=False,
    # Upper end of the documented range.
    largest=1000.0,
    source=(
        "ardupilot libraries/AP_NavEKF3/AP_NavEKF3_AirDataFusion.cpp, "
        "NavEKF3_core::FuseDragForces, and AP_NavEKF3.cpp"
    ),
    between="",
)

SPIN_MIN, SPIN_MAX = 0.15, 0.95  # defaults of MOT_SPIN_MIN and MOT_SPIN_MAX
SIGNALS = SPIN_MIN + (SPIN_MAX - SPIN_MIN) * np.linspace(0.0, 1.0, 101)  # signals of the fit
EXPO_LIMITS = (-1.0, 1.0)

REMARKS = [
    "The filter estimates the wind as soon as one of the EK3_DRAG parameters is set (MCOEF above "
    "0.001, BCOEF above 1). Releases before pull request 28495 (merged at the end of 2024) scale "
    "density and EK3_DRAG_MCOEF with (1.225 / rho)^(1/4) instead of rho / 1.225. Both factors "
    "are 1 at sea level and differ at altitude.",
    "ArduPilot's documentation is inconsistent: for EK3_DRAG_MCOEF, the page airspeed-estimation "
    "states 1.1 to 2.0, but the parameter list states a range of 0 to 1 (example: 0.1). The code "
    "agrees with the parameter list.",
]


def parameters(aircraft: Aircraft, flights: autopilot.Flights) -> autopilot.AutopilotParameters:
    """Compute ArduPilot's parameters of an aircraft from level ``flights`` along x and y."""
    vehicle = aircraft.vehicle
    kinds, comparisons = FILTER.parameters(flights, vehicle)
    left_out = []
    curve, why = steady_loads.known_curve(aircraft)
    if curve is None:
        regulated = steady_loads.fitted_factor(_shares(np.square), EXPO_LIMITS)
        left_out.append(
            autopilot.NotWritten(
                "MOT_THST_EXPO",
                f"{why}. With a speed controller that regulates the rotor speed in proportion to "
                f"the output, the value is {regulated:.2f} between MOT_SPIN_MIN {SPIN_MIN:g} and "
                f"MOT_SPIN_MAX {SPIN_MAX:g}. With a controller that linearizes the thrust, it is 0",
            )
        )
    else:
        kinds.append(_expo(aircraft, flights, curve))
    sets = [autopilot.ParameterSet("ardupilot.param", "wind estimation and thrust curve", kinds)]
    fastest = flights[0].hover_speed if curve is None else curve.full_speed
    remarks = [*autopilot.common_remarks(aircraft, fastest), *REMARKS]
    return autopilot.AutopilotParameters(
        "ArduPilot", sets, left_out, comparisons, remarks, file_text
    )


def file_text(part: autopilot.ParameterSet, vehicle: Vehicle) -> str:
    """Write a parameter file as Mission Planner saves it: lines NAME,VALUE and comment lines."""
    lines = [f"# {line}" for line in autopilot.comment_lines(part, vehicle, "ardupilot")]
    lines += [f"{name},{value:.9g}" for name, value in part.values.items()]
    return "\n".join(lines) + "\n"


def _expo(
    aircraft: Aircraft, flights: autopilot.Flights, curve: steady_loads.SignalCurve
) -> autopilot.Explained:
    still = steady_loads.static_loads(aircraft, flights[0].hover_speed)
    found = steady_loads.curve_factor(aircraft, curve, still, _shares, EXPO_LIMITS)
    ends = curve.at(np.array([SPIN_MIN, SPIN_MAX]))
    return autopilot.Explained(
        title="MOT_THST_EXPO",
        values={"MOT_THST_EXPO": round(found.factor, 4)},
        unit="-",
        std=found.std,
        meaning=(
            "Thrust over maximum thrust = e x^2 + (1 - e) x, where x is 0 at an output of "
            "MOT_SPIN_MIN and 1 at MOT_SPIN_MAX; the firmware inverts this equation. The output is "
            "assumed to be the fraction of the battery voltage at the motor, with the defaults "
            f"MOT_SPIN_MIN {SPIN_MIN:g} and MOT_SPIN_MAX {SPIN_MAX:g}. Thrust is counted from the "
            f"thrust at MOT_SPIN_MIN, {ends[0] / ends[1]:.1%} of the maximum: the actual thrust "
            "exceeds the commanded thrust by this constant."
        ),
        source=(
            "ardupilot libraries/AP_Motors/AP_Motors_Thrust_Linearization.cpp, "
            "thrust_to_actuator and apply_thrust_curve_and_volt_scaling"
        ),
        holds=f"{found.holds} {curve.full_signal(aircraft.vehicle.powertrain.motor)}",
    )


def _shares(thrust: Callable[[Floats], Floats]) -> Floats:
    low = thrust(SIGNALS[:1])
    return np.asarray((thrust(SIGNALS) - low) / (thrust(SIGNALS[-1:]) - low))
