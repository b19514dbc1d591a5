"""Target ``ardupilot``: parameters of ArduPilot's Kalman filter and of its thrust curve.

Each definition was read in ArduPilot's source, whose files the parameters name; the file format is
that of Mission Planner and MAVProxy.
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
    # The end of the documented range.
    largest=1000.0,
    source=(
        "ardupilot libraries/AP_NavEKF3/AP_NavEKF3_AirDataFusion.cpp, "
        "NavEKF3_core::FuseDragForces, and AP_NavEKF3.cpp"
    ),
    between="",
)

SPIN_MIN, SPIN_MAX = 0.15, 0.95  # defaults of MOT_SPIN_MIN and MOT_SPIN_MAX
SIGNALS = SPIN_MIN + (SPIN_MAX - SPIN_MIN) * np.linspace(0.0, 1.0, 101)  # for the fit
EXPO_LIMITS = (-1.0, 1.0)

REMARKS = [
    "The filter estimates the wind as soon as one of the EK3_DRAG parameters is set (MCOEF above "
    "0.001, BCOEF above 1). Releases before pull request 28495 (merged at the end of 2024) scale "
    "density and EK3_DRAG_MCOEF with (1.225 / rho)^(1/4) instead of rho / 1.225: the same at sea "
    "level, another at height.",
    "The documentation's page airspeed-estimation says that EK3_DRAG_MCOEF is normally 1.1 to 2.0; "
    "the parameter's own range is 0 to 1 with an example of 0.1, which fits the code.",
]


def parameters(aircraft: Aircraft, flights: autopilot.Flights) -> autopilot.AutopilotParameters:
    """Find what ArduPilot takes of an aircraft flown along x and y."""
    vehicle = aircraft.vehicle
    kinds, comparisons = FILTER.parameters(flights, vehicle)
    left_out = []
    curve, why = steady_loads.known_curve(aircraft)
    if curve is None:
        regulated = steady_loads.fitted_factor(_shares(np.square), EXPO_LIMITS)
        left_out.append(
            autopilot.NotWritten(
                "MOT_THST_EXPO",
                f"{why}. A speed controller that regulates the rotor speed, in proportion to the "
                f"output, would have {regulated:.2f} between MOT_SPIN_MIN {SPIN_MIN:g} and "
                f"MOT_SPIN_MAX {SPIN_MAX:g}; one that linearises the thrust, 0",
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
    """Write a file as Mission Planner saves it: NAME,VALUE, comments in lines of their own."""
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
            "Thrust over the largest = e x^2 + (1 - e) x with x from 0 at MOT_SPIN_MIN to 1 at "
            "MOT_SPIN_MAX of the output's range; the firmware inverts it. The output is taken as "
            f"the share of the battery's voltage at the motor, MOT_SPIN_MIN as {SPIN_MIN:g} and "
            f"MOT_SPIN_MAX as {SPIN_MAX:g}, their defaults. Thrust counts from that at "
            f"MOT_SPIN_MIN on, which is {ends[0] / ends[1]:.1%} of the largest: what comes "
            "exceeds what is commanded by a constant."
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
