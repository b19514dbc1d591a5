"""Targets ``gazebo``, ``rotorpy``, ``jsbsim``, ``multinomial``, and the table in other files.

What each target's equations are stands in its note.
"""

from __future__ import annotations

import csv
import dataclasses
import io
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from propmap.errors import InputError
from propmap.export.files import (
    SIMPLE,
    Files,
    Samples,
    errors,
    identifier,
    middle_omega,
    note,
    rendered,
    rests_on,
    sample,
    slope,
    static_loads,
    vehicle_name,
)
from propmap.loads import LOADS
from propmap.results import spin_sign
from propmap.table.query import LoadTable
from propmap.typing import Floats
from propmap.units import FOOT, INCH, POUND, RPM, SLUG_PER_FT3
from propmap.vehicle.powertrain import Powertrain
from propmap.vehicle.vehicle import Vehicle
from propmap.vehicle.vehicle_forces import Rotors

# -------------------------------------------------------------------------------------------------
# Target ``gazebo``: parameters of the multicopter motor model of Gazebo and PX4.


class MotorModel(NamedTuple):
    """The plugin's parameters, by its formulas."""

    motor_constant: float  # [N s^2]
    moment_constant: float  # [m]
    rotor_drag_coefficient: float  # [N s^2/m]
    rolling_moment_coefficient: float  # [N s^2]

    def loads(self, omega: Floats, inplane: Floats) -> dict[str, Floats]:
        """Return loads (n,) [N], [N m] at n points [rad/s], [m/s]."""
        thrust, across = self.motor_constant * omega**2, omega * inplane
        return {
            "thrust": thrust,
            "drag": self.rotor_drag_coefficient * across,
            "torque": self.moment_constant * thrust,
            "roll_moment": self.rolling_moment_coefficient * across,
        }


def fit_motor_model(table: LoadTable, samples: Samples) -> MotorModel:
    """Take static thrust and torque as they are; fit drag and roll moment by least squares."""
    omega = middle_omega(table)
    static = static_loads(table, np.array([omega]))
    thrust, torque = float(static["thrust"][0]), float(static["torque"][0])
    drag, roll = slope(samples, "drag"), slope(samples, "roll_moment")
    return MotorModel(thrust / omega**2, torque / thrust, drag, roll)


def gazebo_files(table: LoadTable) -> Files:
    """Write the SDF elements and the note."""
    samples = sample(table)
    fitted = fit_motor_model(table, samples)
    found = errors(samples, fitted.loads(samples.omega, samples.inplane))
    text = f"""The multicopter motor model knows thrust = motorConstant omega^2, torque =
        momentConstant thrust, drag = omega rotorDragCoefficient v, rolling moment = omega
        rollingMomentCoefficient v, with v the velocity across the axis. Thrust and torque do not
        change with the flight speed: they are those of hover, at {middle_omega(table) / RPM:.0f}
        rpm. The coefficients of drag and rolling moment are least squares over {SIMPLE}.

        The plugin has no side force and no pitching moment: these two loads, which are zero where
        the inflow does not vary around the disk, are lost, and have the errors of zero below.

        The plugin of PX4's Gazebo Classic multiplies the thrust by 1 - |v_axial|/25 m/s, whatever
        the propeller, which is not in the errors below.

        PX4's Gazebo Classic plugin turns the rolling moment's sign with turningDirection; gz-sim's
        MulticopterMotorModel and RotorS do not: for them, negate rollingMomentCoefficient where
        turningDirection is cw."""
    return {
        f"{identifier(table)}_motor.sdf": rendered("motor.sdf", table, fitted=fitted),
        "README-gazebo.txt": note("gazebo", text, table, found),
    }


# -------------------------------------------------------------------------------------------------
# Target ``rotorpy``: the rotor's part of a RotorPy vehicle, or a whole RotorPy vehicle.


class RotorPyRotor(NamedTuple):
    """RotorPy's coefficients, and two of the module's mix-in."""

    k_eta: float  # [N s^2]
    k_m: float  # [N m s^2]
    k_d: float  # [kg]
    k_z: float  # [kg]
    k_h: float  # [kg/m]
    k_flap: float  # [kg m]
    k_roll: float  # [kg m]
    k_side: float  # [kg]

    def loads(self, omega: Floats, axial: Floats, inplane: Floats) -> dict[str, Floats]:
        """Return loads (n,) [N], [N m] at n points [rad/s], [m/s]."""
        thrust = self.k_eta * omega**2 + self.k_h * inplane**2 - self.k_z * omega * axial
        across = omega * inplane
        return {
            "thrust": thrust,
            "drag": self.k_d * across,
            "torque": self.k_m * omega**2,
            "roll_moment": self.k_roll * across,
            "side_force": self.k_side * across,
            "pitch_moment": -self.k_flap * across,
        }


def fit_rotor(table: LoadTable, samples: Samples) -> RotorPyRotor:
    """Take static thrust and torque as they are; fit the rest by least squares."""
    middle = middle_omega(table)
    static = static_loads(table, np.array([middle]))
    k_eta, k_m = (float(static[load][0]) / middle**2 for load in ("thrust", "torque"))
    chosen = samples.simple
    omega, axial, inplane = (x[chosen] for x in (samples.omega, samples.axial, samples.inplane))
    scale = samples.static["thrust"][chosen]
    matrix = np.stack([-omega * axial, inplane**2], axis=-1) / scale[:, None]
    rest = (samples.loads["thrust"][chosen] - k_eta * omega**2) / scale
    k_z, k_h = np.linalg.lstsq(matrix, rest, rcond=None)[0].tolist()
    k_d, pitch, k_roll, k_side = (
        slope(samples, load) for load in ("drag", "pitch_moment", "roll_moment", "side_force")
    )
    return RotorPyRotor(k_eta, k_m, k_d, k_z, k_h, -pitch, k_roll, k_side)


def rotorpy_files(table: LoadTable) -> Files:
    """Write the parameters as a Python module, and the note."""
    samples = sample(table)
    fitted = fit_rotor(table, samples)
    found = errors(samples, fitted.loads(samples.omega, samples.axial, samples.inplane))
    name = f"{identifier(table)}_rotorpy.py"
    text = f"""RotorPy's rotor knows thrust = k_eta omega^2 + k_h v^2 - k_z omega v_z, torque = k_m
        omega^2 and drag = k_d omega v, with v the velocity across the axis. k_eta and k_m are those
        of hover, at {middle_omega(table) / RPM:.0f} rpm; the rest are least squares over {SIMPLE}.
        The torque does not change with the flight speed. RotorPy's k_flap omega v is a moment
        across the velocity: minus the pitching moment.

        RotorPy has neither rolling moment nor side force. The module has a mix-in that adds both,
        k_roll omega v and k_side omega v, with the sign of each rotor's spin: class
        Vehicle(HubWrench, Multirotor): pass. Without it they are missing, with the errors of zero.

        {name} holds what the propeller decides. Merge it into a vehicle: quad_params = {{**frame,
        **rotor_params}}, with mass, inertia, rotor positions and the motor's time constant from the
        frame. RotorPy clips omega to the range of the table."""
    return {
        name: rendered("rotorpy.py", table, fitted=fitted),
        "README-rotorpy.txt": note("rotorpy", text, table, found),
    }


ROTORS = 4  # RotorPy's Multirotor inverts the matrix from its rotors' thrusts to thrust and moments


def vehicle_rotorpy_files(vehicle: Vehicle, table: LoadTable) -> Files:
    """Write a module that asks ``VehicleForces``, the table beside it, and the note.

    Raise ``InputError`` for another number of rotors, and a table of another propeller or air.
    """
    if len(vehicle.mounts) != ROTORS:
        raise InputError(
            f"the vehicle has {len(vehicle.mounts)} rotors, RotorPy's Multirotor {ROTORS}",
            "write a multirotor of your own around propmap.VehicleForces",
        )
    Rotors.of(vehicle, table)
    name, rotor = vehicle_name(vehicle, table), identifier(table)
    module = rendered(
        "rotorpy_vehicle.py",
        table,
        v=name,
        vehicle=vehicle,
        made=literal(dataclasses.replace(vehicle, powertrain=Powertrain())),
        directions=[-spin_sign(mount.spin) for mount in vehicle.mounts],
        fitted=fit_rotor(table, sample(table)),
    )
    known, missing = (
        (" moments of inertia,", "") if vehicle.inertia else ("", " and the moments of inertia")
    )
    text = f"""{name}_rotorpy.py has Vehicle, a RotorPy Multirotor whose compute_body_wrench is
        propmap.VehicleForces.wrench: all six loads of each rotor by the table {rotor}.npz, at the
        velocity of its hub, with its axis and spin, and the forces of body and wing. It needs
        propmap beside RotorPy.

        {rests_on(vehicle, table)}

        Make it with quad_params = {{**frame, **vehicle_params}}: mass, rotor positions and
        directions, the range of rotor speeds of the table,{known} and k_eta and k_m of hover, which
        controllers use and Vehicle does not. From the frame come the motor's time
        constant{missing}. RotorPy clips rotor speeds to the range of the table; where the table has
        no loads in speed or angle, a line says so. RotorPy adds the weight; it knows no gyroscopic
        moments of rotors."""
    return {
        f"{name}_rotorpy.py": module,
        f"{rotor}.npz": table.save,
        "README-rotorpy.txt": note(f"rotorpy, {vehicle.name}", text, table),
    }


def literal(value: Any) -> str:
    """Return the Python expression of a dataclass, tuple, array or number, fields by default out.

    Classes stand by their names alone.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        parts = []
        for field in dataclasses.fields(value):
            entry, default = getattr(value, field.name), field.default
            if field.default_factory is not dataclasses.MISSING:
                default = field.default_factory()
            if default is dataclasses.MISSING or not bool(entry == default):
                parts.append(f"{field.name}={literal(entry)}")
        return f"{type(value).__name__}({', '.join(parts)})"
    if isinstance(value, tuple):
        return f"({''.join(f'{literal(each)}, ' for each in value).strip()})"
    if isinstance(value, np.ndarray):
        return repr(value.tolist())
    return repr(value)


# -------------------------------------------------------------------------------------------------
# Target ``jsbsim``: a propeller of thrust and power coefficients against J = V/(n D), and the four
# loads by the in-plane velocity as external reactions, as in ``multinomial``.

JSBSIM_POINTS = 121  # linear in between: 1e-4 of the static coefficient


def coefficients(table: LoadTable) -> tuple[Floats, Floats, Floats]:
    """Tabulate C_T = T/(rho n^2 D^4) and C_P = P/(rho n^3 D^5) over rising J, (k,) each.

    With descent, J < 0, down to where the table has no values.  Each is taken at the middle omega,
    or at the largest that reaches that J within the envelope.
    """
    low, high = table.envelope["beta"]
    if low > 1e-9:
        raise InputError(
            f"the table's beta begins at {np.degrees(low):g} deg, without axial flight",
            "build it with --beta 0:...",
        )
    radius, (_, fastest) = table.content.radius, table.envelope["speed"]
    advance = np.linspace(0.0, float(table.content.advance[-1]), JSBSIM_POINTS)
    parts = []
    for beta, sign in ((high, -1.0), (low, 1.0)):
        if sign < 0.0 and abs(beta - np.pi) > 1e-9:
            continue
        ratio = advance[:0:-1] if sign < 0.0 else advance
        reach = fastest / (np.maximum(ratio, 1e-12) * radius)
        # The largest advance ratio is met at one omega only, to rounding.
        omega = np.maximum(np.minimum(middle_omega(table), reach), table.envelope["omega"][0])
        found = table.loads(omega, np.minimum(ratio * omega * radius, fastest), beta)
        turns, diameter = omega / (2.0 * np.pi), 2.0 * radius
        force = table.content.density * turns**2 * diameter**4
        power = found.power / (force * turns * diameter)
        parts.append(np.stack([sign * np.pi * ratio, found.thrust / force, power]))
    each = np.concatenate(parts, axis=1)
    known = np.isfinite(each).all(axis=0)
    # What JSBSim would draw a line across is left out, with all beyond it.
    gaps = np.flatnonzero(~known & (each[0] < 0.0))
    each = each[:, gaps[-1] + 1 :] if gaps.size else each
    each = each[:, np.isfinite(each).all(axis=0)]
    return each[0], each[1], each[2]


def jsbsim_files(table: LoadTable) -> Files:
    """Write the propeller's XML, that of the reactions across its axis, and the note."""
    samples, name = sample(table), identifier(table)
    forms = fit_multinomial(samples, table.content.density)
    across = multinomial_loads(forms, samples, table.content.density)
    by_axis = _axial_loads(table, samples.omega, samples.axial)
    found = errors(samples, across | dict(zip(("thrust", "torque"), by_axis, strict=True)))
    of_thrust, of_torque = axial_error(table)
    advance, thrust, power = coefficients(table)
    text = f"""JSBSim's fixed-pitch propeller knows thrust and power against J = V/(n D) with the
        velocity along the axis alone: no in-plane velocity, no Reynolds number. The coefficients
        are those of axial flight at J from {advance[0]:.3g} to {advance[-1]:.3g}, beyond which
        JSBSim keeps the last. In axial climb they are within {100 * of_thrust:.2f}% (thrust) and
        {100 * of_torque:.2f}% (torque) of the table, as shares of the static loads; most of it is
        the Reynolds number's.

        {name}_reactions.xml has what the propeller of JSBSim lacks, as external reactions: drag and
        side force, rolling and pitching moment, density times (a omega + b V_axial) times the
        in-plane velocity, by least squares over {SIMPLE}. Name it in the aircraft's file,
        <external_reactions file="{name}_reactions"/>, and set the location of both forces to the
        thruster's. It is written for engine 0 with its thrust along the body's x axis and <sense>
        1, clockwise seen from behind; for -1 set the property propmap/{name}-sense to -1. The
        velocity is the vehicle's through the air at its centre of mass; its turning is not in it.

        ixx is a placeholder, a uniform rod of 1 g per inch of diameter; put the moment of inertia
        of the propeller and what turns with it in its place. JSBSim uses the density of its own
        atmosphere."""
    per_pound = SLUG_PER_FT3 * FOOT / POUND
    return {
        f"{name}.xml": rendered(
            "jsbsim.xml",
            table,
            inches=2.0 * table.content.radius / INCH,
            advance=advance,
            thrust=thrust,
            power=power,
        ),
        f"{name}_reactions.xml": rendered(
            "jsbsim_reactions.xml",
            table,
            forms=forms,
            # Density in slug/ft^3, a velocity in ft/s, force and moment in lbf and lbf ft.
            per_lbs=per_pound,
            per_lbsft=per_pound / FOOT,
            rad_s_per_rpm=RPM,
            m_per_ft=FOOT,
        ),
        "README-jsbsim.txt": note("jsbsim", text, table, found),
    }


def axial_error(table: LoadTable) -> tuple[float, float]:
    """Find the worst errors of thrust and torque in axial climb, as shares of static loads."""
    ends = (table.envelope["omega"], table.envelope["speed"])
    omega, speed = (
        x.ravel() for x in np.meshgrid(*(np.linspace(*end, 41) for end in ends), indexing="ij")
    )
    beta = table.envelope["beta"][0]
    expected, still = table.loads(omega, speed, beta), table.loads(omega, 0.0, beta)
    thrust, torque = _axial_loads(table, omega, speed)
    return (
        float(np.nanmax(abs(thrust - expected.thrust) / still.thrust)),
        float(np.nanmax(abs(torque - expected.torque) / still.torque)),
    )


def _axial_loads(table: LoadTable, omega: Floats, axial: Floats) -> tuple[Floats, Floats]:
    """Return JSBSim's thrust [N] and torque [N m] at n axial velocities, (n,)."""
    advance, thrust, power = coefficients(table)
    turns, diameter = omega / (2.0 * np.pi), 2.0 * table.content.radius
    ratio, force = axial / (turns * diameter), table.content.density * turns**2 * diameter**4
    arm = diameter / (2.0 * np.pi)
    return np.interp(ratio, advance, thrust) * force, np.interp(ratio, advance, power) * force * arm


# -------------------------------------------------------------------------------------------------
# Target ``multinomial``: the explicit polynomial of Gill & D'Andrea, Drones 2019, 3(4), 77.
#
# With lambda_c = V cos(beta)/(Omega R) and mu = V sin(beta)/(Omega R), thrust and torque are
# Omega^2 times a quadratic in lambda_c and, even, in mu; drag and roll moment are Omega^2 mu times
# a line in lambda_c.  Multiplied out, no division by Omega and no root is left: thrust and torque
# are quadratic forms of Omega and the velocity, and the drag is a smooth vector.

Forms = Mapping[str, tuple[float, ...]]
"""By load, factors over the density of Omega^2, Omega z, z^2 and r^2; or, of loads by the in-plane
velocity, of Omega r and z r; z along the axis, r in the disk plane.  [m^4], [m^3], [m^2], for
moments times [m]."""


def multinomial_loads(forms: Forms, samples: Samples, density: float) -> dict[str, Floats]:
    """Return loads (n,) [N], [N m] at the samples' points, in air of a density [kg/m^3]."""
    return {name: density * _terms(name, samples) @ forms[name] for name in LOADS}


def fit_multinomial(samples: Samples, density: float) -> Forms:
    """Fit the errors as shares of static loads by least squares, where simple models are meant."""
    chosen, found = samples.simple, {}
    for name in LOADS:
        scale = 1.0 / samples.static[name][chosen]
        matrix = density * _terms(name, samples)[chosen] * scale[:, None]
        # Columns of one size: those of thrust are of Omega^2 and of V^2.
        size = np.sqrt((matrix**2).mean(axis=0))
        target = samples.loads[name][chosen] * scale
        solved = np.linalg.lstsq(matrix / size, target, rcond=None)[0]
        found[name] = tuple((solved / size).tolist())
    return found


def multinomial_files(table: LoadTable) -> Files:
    """Write the expressions in Python and C, and the note."""
    samples, density = sample(table), table.content.density
    forms = fit_multinomial(samples, density)
    found = errors(samples, multinomial_loads(forms, samples, density))
    name, values = f"{identifier(table)}_multinomial", {"forms": forms, "density": density}
    text = f"""The multinomial of Gill & D'Andrea, Computationally Efficient Force and Moment Models
        for Propellers in UAV Forward Flight Applications, Drones 2019, 3(4), 77, fitted to the
        table by least squares over {SIMPLE}. Its form cannot follow the fast descent, the vortex
        ring state, stall, or the Reynolds number.

        {name}.py is plain arithmetic: numbers, NumPy arrays and CasADi's SX, MX and DM all go
        through. {name}.h is the same in C99."""
    return {
        f"{name}.py": rendered("multinomial.py", table, **values),
        f"{name}.h": rendered("multinomial.h", table, **values),
        "README-multinomial.txt": note("multinomial", text, table, found),
    }


def _terms(name: str, at: Samples) -> Floats:
    """Return what the factors of a load's form multiply, (n, 4) or (n, 2)."""
    if LOADS[name].inplane:
        return np.stack([at.omega * at.inplane, at.axial * at.inplane], axis=-1)
    return np.stack([at.omega**2, at.omega * at.axial, at.axial**2, at.inplane**2], axis=-1)


# -------------------------------------------------------------------------------------------------
# Targets ``npz``, ``nc`` and ``csv``: the table itself, in other files.

SCALES = """forces are rho pi R^4 omega^2 times the coefficient, moments rho pi R^5 omega^2; in
    between, the coefficients are linear in omega^(-1/2) and cubic in the advance ratio V/(omega R)
    and in beta."""


def npz_files(table: LoadTable) -> Files:
    """Write the table as ``propmap.table.LoadTable`` reads it."""
    text = "The table itself, for propmap.table.LoadTable.load, which needs NumPy alone."
    return {f"{identifier(table)}.npz": table.save, "README-npz.txt": note("npz", text, table)}


def nc_files(table: LoadTable) -> Files:
    """Write the table as NetCDF."""
    from propmap.table.files import write_netcdf

    text = f"The table's coefficients with units, for xarray and its like: {SCALES}"
    return {
        f"{identifier(table)}.nc": lambda path: write_netcdf(table, path),
        "README-nc.txt": note("nc", text, table),
    }


def csv_files(table: LoadTable) -> Files:
    """Write the table's knots as rows of numbers, empty where there is no value."""
    content, text = table.content, io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        ["omega_rad_s", "advance", "beta_rad", *(f"{name}_coefficient" for name in LOADS)]
    )
    for omega, level in zip(content.omega.tolist(), content.coefficients, strict=True):
        for i, advance in enumerate(content.advance.tolist()):
            for j, beta in enumerate(content.beta.tolist()):
                values = level[:, i, j].astype(np.float32)
                shown = ["" if np.isnan(value) else str(value) for value in values]
                writer.writerow([omega, advance, beta, *shown])
    about = f"""A row for each knot of the table: {SCALES} Empty where there is no value. Which
        cells between the knots are vortex ring or unresolved is not in it."""
    return {
        f"{identifier(table)}.csv": text.getvalue(),
        "README-csv.txt": note("csv", about, table),
    }
