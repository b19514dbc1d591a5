"""Target ``px4``: parameters of PX4's Kalman filter, control allocation and simulator.

Each definition was read in PX4's source, whose files the parameters name; the file format is that
of QGroundControl.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from propmap.aircraft.steady import Aircraft
from propmap.export.curve_factor import curve_factor
from propmap.export.drag_filter import DragFilter
from propmap.export.parameter_set import (
    AutopilotParameters,
    Explained,
    Flights,
    LeftOut,
    ParameterSet,
    comment_lines,
    common_remarks,
)
from propmap.export.px4_allocation import (
    LARGEST_THRUST,
    NORMALISED,
    geometry,
    moment_ratio,
    thrust_coefficient,
)
from propmap.export.px4_simulator import simulator
from propmap.export.static_loads import StaticLoads, static_loads
from propmap.export.thrust_curve import ThrustCurve, known_curve
from propmap.typing import Floats
from propmap.vehicle.vehicle import Vehicle

FILTER = DragFilter(
    momentum="EKF2_MCOEF",
    ballistic="EKF2_BCOEF_",
    power=0.5,
    whole=True,
    # PX4's own script, mc_wind_estimator_tuning.py, writes 0 beyond.
    largest=200.0,
    source="PX4-Autopilot src/modules/ekf2/EKF/aid_sources/drag/drag_fusion.cpp, Ekf::fuseDrag",
    between=", and in flight between x and y the two are joined by an ellipse",
)

SIGNALS = np.linspace(0.0, 1.0, 101)
"""At which the thrust curve is fitted."""

INT, REAL = 6, 9
"""MAV_PARAM_TYPE_INT32 and MAV_PARAM_TYPE_REAL32."""

REMARKS = [
    "The filter uses these coefficients once EKF2_DRAG_CTRL is 1, which is not written here: "
    "fly first, and compare the innovations of the specific force.",
    "QGroundControl loads the files by Parameters, Tools, Load from file; the vehicle id in them "
    "is 1, which has to be that of the vehicle.",
]


def parameters(aircraft: Aircraft, flights: Flights) -> AutopilotParameters:
    """What PX4 takes of an aircraft flown along x and y."""
    vehicle = aircraft.vehicle
    places = geometry(vehicle)
    drag, comparisons = FILTER.parameters(flights, vehicle)
    still = static_loads(aircraft, flights[0].hover_speed)
    real, left_out = [*drag, *places, moment_ratio(vehicle, still, flights)], []
    curve, why = known_curve(aircraft)
    if curve is None:
        regulated = "A speed controller that regulates the rotor speed, in proportion to the signal"
        left_out.append(LeftOut("THR_MDL_FAC", f"{why}. {regulated}, would have 1"))
        left_out.append(
            LeftOut("CA_ROTORn_CT", f"{why}, hence no thrust at the full signal. {NORMALISED}")
        )
    else:
        if curve.full_thrust <= LARGEST_THRUST:
            real.append(thrust_coefficient(vehicle, still, curve))
        else:
            above = f"{curve.full_thrust:.0f} N is above the {LARGEST_THRUST:g} that it takes"
            left_out.append(LeftOut("CA_ROTORn_CT", f"{above}. {NORMALISED}"))
        real.append(_curve_factor(aircraft, still, curve))
    sets = [ParameterSet("px4.params", "wind estimation and control allocation", real)]
    simulated, why = simulator(vehicle, flights, still, curve)
    if simulated:
        sets.append(ParameterSet("px4_sih.params", "simulation in hardware (SIH)", simulated))
    else:
        left_out.append(LeftOut("SIH_T_MAX, SIH_Q_MAX, SIH_KDV and the like", why))
    remarks = [*common_remarks(aircraft), *REMARKS, _gazebo(flights, still)]
    return AutopilotParameters("PX4", sets, left_out, comparisons, remarks)


def file_text(part: ParameterSet, vehicle: Vehicle) -> str:
    """A parameter file as QGroundControl saves and loads it: columns between tabs, # comments."""
    head = [*comment_lines(part, vehicle, "px4"), "", "Vehicle-Id Component-Id Name Value Type"]
    lines = [f"# {line}".rstrip() for line in head]
    for name, value in part.values.items():
        kind = INT if isinstance(value, int) else REAL
        lines.append(f"1\t1\t{name}\t{value:.9g}\t{kind}")
    return "\n".join(lines) + "\n"


def _curve_factor(aircraft: Aircraft, still: StaticLoads, curve: ThrustCurve) -> Explained:
    found = curve_factor(aircraft, curve, still, _shares, (0.0, 1.0))
    return Explained(
        title="THR_MDL_FAC",
        values={"THR_MDL_FAC": round(found.factor, 4)},
        unit="-",
        std=found.std,
        meaning=(
            "Thrust over the largest = f s^2 + (1 - f) s, s the signal from 0 to 1 between the "
            "outputs' least and largest value; the firmware inverts it. Here s is the share of "
            "the battery's voltage at the motor. A speed controller that regulates the rotor "
            "speed has 1, whatever the motor."
        ),
        source=(
            "PX4-Autopilot src/lib/mixer_module/motor_params.yaml and "
            "functions/FunctionMotors.hpp, updateValues"
        ),
        holds=found.holds,
    )


def _shares(thrust: Callable[[Floats], Floats]) -> Floats:
    return np.asarray(thrust(SIGNALS) / thrust(SIGNALS[-1:]))


def _gazebo(flights: Flights, still: StaticLoads) -> str:
    speed = flights[0].hover_speed
    return (
        "Gazebo's multicopter motor model takes thrust = motorConstant omega^2 and torque = "
        f"momentConstant thrust: in hover, at {speed:.0f} rad/s, {still.thrust / speed**2:.4g} "
        f"N s^2 and {still.torque / still.thrust:.4g} m. With drag and rolling moment of a rotor "
        "they are what `propmap export MAP --to gazebo` writes from a map of the propeller."
    )
