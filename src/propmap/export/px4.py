"""Target ``px4``: parameters of PX4's control allocation, estimator and simulator.

The definitions come from PX4's source, in the file that each parameter names.  The file format is
the one of QGroundControl.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from propmap.aircraft.trim import Aircraft
from propmap.errors import InputError
from propmap.export.autopilot import (
    SEA_LEVEL,
    AutopilotParameters,
    DragFilter,
    Explained,
    Flights,
    NotWritten,
    ParameterSet,
    comment_lines,
    common_remarks,
)
from propmap.export.steady_loads import (
    CLOSE,
    SignalCurve,
    StaticLoads,
    curve_factor,
    known_curve,
    mean_loads,
    static_loads,
)
from propmap.typing import Floats
from propmap.units import GRAVITY, INCH, RPM
from propmap.vehicle.vehicle import Vector, Vehicle

FILTER = DragFilter(
    momentum="EKF2_MCOEF",
    ballistic="EKF2_BCOEF_",
    power=0.5,
    whole=True,
    # PX4's script mc_wind_estimator_tuning.py writes 0 for larger values.
    largest=200.0,
    source="PX4-Autopilot src/modules/ekf2/EKF/aid_sources/drag/drag_fusion.cpp, Ekf::fuseDrag",
    between="In directions between x and y, an ellipse interpolates the coefficients. ",
)

SIGNALS = np.linspace(0.0, 1.0, 101)  # signals at which the thrust curve is fitted
INT, REAL = 6, 9  # MAV_PARAM_TYPE_INT32 and MAV_PARAM_TYPE_REAL32
REMARKS = [
    "The filter uses these coefficients if EKF2_DRAG_CTRL is 1. The files do not set it: fly "
    "first, and check the innovations of the specific force.",
    "QGroundControl loads the files with Parameters, Tools, Load from file. They apply to vehicle "
    "id 1: check that your vehicle has this id.",
]


def parameters(aircraft: Aircraft, flights: Flights) -> AutopilotParameters:
    """Compute PX4's parameters of an aircraft from level ``flights`` along x and y."""
    vehicle = aircraft.vehicle
    places = geometry(vehicle)
    drag, comparisons = FILTER.parameters(flights, vehicle)
    still = static_loads(aircraft, flights[0].hover_speed)
    real, left_out = [*drag, *places, moment_ratio(vehicle, still, flights)], []
    curve, why = known_curve(aircraft)
    if curve is None:
        regulated = "If the speed controller makes the rotor speed proportional to the signal"
        left_out.append(NotWritten("THR_MDL_FAC", f"{why}. {regulated}, the value is 1"))
        left_out.append(
            NotWritten("CA_ROTORn_CT", f"{why}: full-signal thrust is unknown. {NORMALIZED}")
        )
    else:
        if curve.full_thrust <= LARGEST_THRUST:
            real.append(thrust_coefficient(vehicle, still, curve))
        else:
            above = f"{curve.full_thrust:.0f} N exceeds its maximum, {LARGEST_THRUST:g} N"
            left_out.append(NotWritten("CA_ROTORn_CT", f"{above}. {NORMALIZED}"))
        real.append(_curve_factor(aircraft, still, curve))
    sets = [ParameterSet("px4.params", "wind estimation and control allocation", real)]
    simulated, why = simulator(vehicle, flights, still, curve)
    if simulated:
        sets.append(ParameterSet("px4_sih.params", "simulation in hardware (SIH)", simulated))
    else:
        left_out.append(NotWritten("SIH_T_MAX, SIH_Q_MAX, SIH_KDV and other SIH_ parameters", why))
    fastest = flights[0].hover_speed if curve is None else curve.full_speed
    remarks = [*common_remarks(aircraft, fastest), *REMARKS, _gazebo(flights, still)]
    return AutopilotParameters("PX4", sets, left_out, comparisons, remarks, file_text)


def file_text(part: ParameterSet, vehicle: Vehicle) -> str:
    """Write a parameter file as QGroundControl saves it: columns between tabs, # comments."""
    head = [*comment_lines(part, vehicle, "px4"), "", "Vehicle-Id Component-Id Name Value Type"]
    lines = [f"# {line}".rstrip() for line in head]
    for name, value in part.values.items():
        kind = INT if isinstance(value, int) else REAL
        lines.append(f"1\t1\t{name}\t{value:.9g}\t{kind}")
    return "\n".join(lines) + "\n"


def _curve_factor(aircraft: Aircraft, still: StaticLoads, curve: SignalCurve) -> Explained:
    found = curve_factor(aircraft, curve, still, _shares, (0.0, 1.0))
    return Explained(
        title="THR_MDL_FAC",
        values={"THR_MDL_FAC": round(found.factor, 4)},
        unit="-",
        std=found.std,
        meaning=(
            "Thrust over maximum thrust = f s^2 + (1 - f) s, where the signal s is 0 at the "
            "minimum output and 1 at the maximum; the firmware inverts this equation. s is assumed "
            "to be the fraction of the battery voltage at the motor. With a speed controller that "
            "regulates the rotor speed, f is 1 for any motor."
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
        "Gazebo's multicopter motor model has thrust = motorConstant omega^2 and torque = "
        f"momentConstant thrust. In hover, at {speed:.0f} rad/s, motorConstant is "
        f"{still.thrust / speed**2:.4g} N s^2 and momentConstant "
        f"{still.torque / still.thrust:.4g} m. `propmap export TABLE --to gazebo` writes these "
        "coefficients, and those of drag and rolling moment, from a table of the propeller."
    )


# --- Parameters of PX4's control allocation: positions, axes, thrust and torque of the rotors ----

MOST_ROTORS, LARGEST_THRUST = 12, 100.0  # limits of control allocation: rotors, CA_ROTORn_CT [N]
ALLOCATOR = "PX4-Autopilot src/modules/control_allocator"
ROTORS = f"{ALLOCATOR}/VehicleActuatorEffectiveness/ActuatorEffectivenessRotors.cpp"
NORMALIZED = "Control allocation is normalized: a factor common to all rotors has no effect"


def in_frd(vector: Vector) -> Vector:
    """Convert a ``vector`` from x forward, y left, z up to x forward, y right, z down."""
    x, y, z = vector
    return x, 0.0 - y, 0.0 - z


def geometry(vehicle: Vehicle) -> list[Explained]:
    """Return number, positions and axes of the rotors; ``InputError`` for more than 12 rotors."""
    count = len(vehicle.mounts)
    if count > MOST_ROTORS:
        found = f"the vehicle has {count} rotors, but PX4 accepts at most {MOST_ROTORS}"
        raise InputError(found, "choose another autopilot")
    places, axes = {}, {}
    for k, mount in enumerate(vehicle.mounts):
        for letter, place, axis in zip(
            "XYZ", in_frd(mount.position), in_frd(mount.axis), strict=True
        ):
            places[f"CA_ROTOR{k}_P{letter}"] = float(place)
            axes[f"CA_ROTOR{k}_A{letter}"] = float(axis)
    number, exact = "Number of rotors.", "Exact: copied from the vehicle file."
    hub = "Position of the hub from the center of mass, x forward, y right, z down."
    thrust = "Direction of the thrust, in the same frame."
    return [
        Explained("CA_ROTOR_COUNT", {"CA_ROTOR_COUNT": count}, "-", None, number, ROTORS, exact),
        Explained("CA_ROTORn_PX, _PY, _PZ", places, "m", None, hub, ROTORS, exact),
        Explained("CA_ROTORn_AX, _AY, _AZ", axes, "-", None, thrust, ROTORS, exact),
    ]


def moment_ratio(vehicle: Vehicle, still: StaticLoads, flights: Flights) -> Explained:
    """Return torque over thrust in hover, from the loads at rest ``still``."""
    arm = flights[0].hover_arm
    arms = np.concatenate([flight.arm for flight in flights]) / arm
    return Explained(
        title="CA_ROTORn_KM",
        values={
            f"CA_ROTOR{k}_KM": round(arm if mount.spin == "ccw" else -arm, 7)
            for k, mount in enumerate(vehicle.mounts)
        },
        unit="m",
        std=still.std_of(-arm / still.thrust, 1.0 / still.thrust),
        meaning=(
            "Torque = CA_ROTORn_KM times thrust. The value is positive for a rotor that turns "
            "counter-clockwise seen from above: its reaction turns the vehicle clockwise."
        ),
        source=f"{ROTORS}, computeEffectivenessMatrix, and module.yaml",
        holds=(
            "This is the value in hover. In the level flights below, the ratio is "
            f"{arms.min():.2f} to {arms.max():.2f} times the value in hover."
        ),
    )


def thrust_coefficient(vehicle: Vehicle, still: StaticLoads, curve: SignalCurve) -> Explained:
    """Return the thrust at the full signal, at most ``LARGEST_THRUST``."""
    share = still.std_of(1.0 / still.thrust, 0.0)
    return Explained(
        title="CA_ROTORn_CT",
        values={f"CA_ROTOR{k}_CT": round(curve.full_thrust, 4) for k in range(len(vehicle.mounts))},
        unit="N",
        std=None if share is None else share * curve.full_thrust,
        meaning=(
            "Thrust = CA_ROTORn_CT u^2 with the signal u: the thrust at u = 1, at rest. "
            f"{NORMALIZED}."
        ),
        source=(
            f"{ALLOCATOR}/module.yaml, and for the normalization src/lib/control_allocation/"
            "control_allocation/ControlAllocationPseudoInverse.cpp"
        ),
        holds=curve.full_signal(vehicle.powertrain.motor),
    )


SIH = "PX4-Autopilot src/modules/simulation/simulator_sih/sih.cpp, generate_force_and_torques"

SIH_QUAD = ((1, 1, "ccw"), (-1, -1, "ccw"), (1, -1, "cw"), (-1, 1, "cw"))
"""Signs of x (forward) and y (right), and spins, of the rotors of the simulated quadrotor."""


def simulator(
    vehicle: Vehicle, flights: Flights, still: StaticLoads, curve: SignalCurve | None
) -> tuple[list[Explained], str]:
    """Return the simulator's parameters from ``flights`` along x and y, or a reason for none."""
    if curve is None:
        return [], "they require the thrust at the full signal, see THR_MDL_FAC"
    places = [in_frd(mount.position) for mount in vehicle.mounts]
    arms = np.abs(np.array(places))[:, :2]
    pattern = tuple(
        (int(np.sign(place[0])), int(np.sign(place[1])), mount.spin)
        for place, mount in zip(places, vehicle.mounts, strict=True)
    )
    equal = np.ptp(arms, axis=0) <= 0.01 * arms.max()
    if pattern != SIH_QUAD or not equal.all():
        return [], (
            "the simulator only models a quadrotor in X with equal arms. Rotors 1 to 4 are front "
            "right, back left, front left, back right; rotors 1 and 2 turn counter-clockwise. This "
            "vehicle differs"
        )
    weight = vehicle.mass * GRAVITY
    speed = np.concatenate([flight.speed for flight in flights])
    needed = np.concatenate([weight * np.tan(flight.pitch) for flight in flights])
    drag = float(np.sum(speed * needed) / np.sum(speed**2))
    worst = float(np.abs(drag * speed - needed).max())
    changes = np.concatenate([flight.errors for flight in flights], axis=1) * vehicle.mass
    spread = float(np.linalg.norm(changes @ speed) / np.sum(speed**2)) if changes.size else None
    share = still.std_of(1.0 / still.thrust, 0.0)
    whole = still.std_of(0.0, 1.0 / still.torque)
    linear = "In the simulator, thrust and torque are linear in the signal: THR_MDL_FAC is 0."
    full = curve.full_signal(vehicle.powertrain.motor)
    mass = "Exact: copied from the vehicle file. Set the moments of inertia, SIH_IXX etc."
    fitted = f"Fitted to the drag in the level flights below, within {worst:.2g} N."
    thrust, torque = round(curve.full_thrust, 4), round(curve.full_torque, 6)
    arm = {"SIH_L_ROLL": float(arms[:, 1].mean()), "SIH_L_PITCH": float(arms[:, 0].mean())}
    rows: list[tuple[str, dict[str, float], str, float | None, str, str]] = [
        ("SIH_VEHICLE_TYPE", {"SIH_VEHICLE_TYPE": 0}, "-", None, "0 for a quadrotor.", "Exact."),
        ("SIH_MASS", {"SIH_MASS": float(vehicle.mass)}, "kg", None, "Take-off mass.", mass),
        ("SIH_T_MAX", {"SIH_T_MAX": thrust}, "N",
         None if share is None else share * curve.full_thrust,
         f"Thrust of a rotor = SIH_T_MAX u. {linear}", full),
        ("SIH_Q_MAX", {"SIH_Q_MAX": torque}, "N m",
         None if whole is None else whole * curve.full_torque,
         "Torque of a rotor = SIH_Q_MAX u.", full),
        ("SIH_L_ROLL, SIH_L_PITCH", arm, "m", None,
         "Distances of the rotors from the planes of symmetry.", "Exact."),
        ("SIH_KDV", {"SIH_KDV": round(drag, 5)}, "N s/m", spread,
         "Force on the vehicle = -SIH_KDV V, in all directions.", fitted),
        ("THR_MDL_FAC", {"THR_MDL_FAC": 0.0}, "-", None, linear,
         "For the simulator only: the real vehicle needs another value."),
    ]  # fmt: skip
    return [Explained(*row[:5], SIH, row[5]) for row in rows], ""


# -------------------------------------------------------------------------------------------------
# The simulator's propeller for airplanes, tailsitters and pushers, a function of advance ratio.

THRUSTER = "PX4-Autopilot src/modules/simulation/simulator_sih/aero.hpp, Thruster"
RATIOS = np.linspace(0.0, 2.0, 201)  # advance ratios J of the fit
THROTTLES = np.array([0.25, 0.5, 1.0])  # of the fit; rotor speed grows with their square root


def forward_propeller(aircraft: Aircraft) -> AutopilotParameters:
    """Fit the simulator's propeller for airplanes, tailsitters and pushers to an ``aircraft``.

    Raises ``InputError`` if the rotor speed at full throttle is not known, and without static
    thrust at this speed.
    """
    vehicle, (curve, why) = aircraft.vehicle, known_curve(aircraft)
    if curve is None:
        remedy = "add [motor] and [battery]; a table must reach full throttle"
        raise InputError(f"{why}: the rotor speed at full throttle is not known", remedy)
    turns = curve.full_speed * np.sqrt(THROTTLES)[:, None] / (2.0 * np.pi)
    diameter, density = 2.0 * vehicle.propeller.radius, vehicle.air.density
    thrust, torque = mean_loads(aircraft, turns * 2.0 * np.pi, RATIOS * turns * diameter)
    size = density * turns**2 * diameter**4
    pulls = np.logical_and.accumulate(thrust > 0.0, axis=1)
    if pulls[-1].sum() < RATIOS.size // 20:
        found = "at full throttle, the thrust is not positive at rest or in slow axial flow"
        raise InputError(found, "check the propeller, or give a table from --speed 0 and --beta 0")
    still = static_loads(aircraft, curve.full_speed)
    rest = [still.std_of(1.0 / still.thrust, 0.0), still.std_of(0.0, 1.0 / still.torque)]
    remarks = [
        *common_remarks(aircraft, curve.full_speed),
        REMARKS[1],
        f"The simulator's air density is {SEA_LEVEL:g} kg/m^3 at any height. The vehicle file has "
        f"{density:g}.",
        "In the simulator, the rotor torque turns an airplane to the right, as with spin cw. A "
        "tailsitter has two rotors, the right one of which is cw.",
    ]
    kinds = []
    each = (thrust / size, 2.0 * np.pi * torque / (size * diameter))
    words = ("Thrust = C_T rho n^2 D^4", "Torque = C_P / (2 pi) rho n^2 D^5")
    for letter, values, meaning, std in zip("TP", each, words, rest, strict=True):
        ratio, value = np.broadcast_to(RATIOS, pulls.shape)[pulls], values[pulls]
        constants = _falling_parabola(ratio, value)
        error = np.abs(np.polynomial.polynomial.polyval(ratio, constants) - value)
        share, at = float(error.max() / value.max()), float(ratio[error.argmax()])
        title, law = f"SIH_F_C{letter}0, _C{letter}1, _C{letter}2", f"C_{letter}"
        holds = (
            f"Range: J from 0 to {ratio.max():.2f}, where the thrust reaches 0 or the table ends, "
            f"and throttle of a quarter or more. Error within {error.max():.4f}, {share:.1%} of "
            f"the largest {law}. At larger J, and in backward flight, the quadratic extrapolates."
        )
        if std is not None:
            holds += f" The model's standard deviation at rest is {std:.1%}."
        if share > CLOSE:
            largest = f"an error of {share:.1%}, largest at J = {at:.2f}"
            remarks.append(f"{law} is not quadratic in J: a quadratic has {largest}.")
        named = {f"SIH_F_C{letter}{k}": float(c) for k, c in enumerate(constants)}
        meaning = f"{meaning}, n in rev/s; {law} quadratic in J = V / (n D), V along the axis."
        kinds.append(Explained(title, named, "-", None, meaning, THRUSTER, holds))
    inches, rpm = round(diameter / INCH, 4), round(curve.full_speed / RPM, 1)
    full = f"{curve.full_signal(vehicle.powertrain.motor)} The same speed is used in flight."
    root = "Rotor speed = SIH_F_RPM_MAX sqrt(u) with the throttle u."
    linear = "Thrust at rest is linear in u."
    kinds += [
        Explained("SIH_F_DIA_INCH", {"SIH_F_DIA_INCH": inches}, "in", None, "Diameter D.", THRUSTER,
                  "Exact."),
        Explained("SIH_F_RPM_MAX", {"SIH_F_RPM_MAX": rpm}, "1/min", None, root, THRUSTER, full),
        Explained("THR_MDL_FAC", {"THR_MDL_FAC": 0.0}, "-", None, linear, THRUSTER,
                  "For the simulator only: the real vehicle needs another value."),
    ]  # fmt: skip
    purpose = "propeller of simulation in hardware (SIH) since PX4 1.17"
    left_out = [
        NotWritten("SIH_F_T_MAX, SIH_F_Q_MAX", "the simulator computes them from the other values"),
        NotWritten(
            "SIH_L_ROLL", "for a tailsitter, set the distance of a rotor from the plane of symmetry"
        ),
        NotWritten("SIH_VEHICLE_TYPE and the airframe", "set the vehicle type and the outputs"),
    ]
    sets = [ParameterSet("px4_sih.params", purpose, kinds)]
    return AutopilotParameters("PX4", sets, left_out, [], remarks, file_text)


def _falling_parabola(ratio: Floats, values: Floats) -> Floats:
    """Fit a quadratic (3,) whose last constant is at most zero, as PX4 requires."""
    fit = np.polynomial.polynomial.polyfit
    found = fit(ratio, values, 2)
    if found[2] > 0.0:
        found = np.append(fit(ratio, values, 1), 0.0)
    return np.asarray(found.round(5))
