"""Targets ``gazebo``, ``rotorpy``, ``jsbsim``, ``multinomial``, and the table in other files."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from propmap.errors import InputError
from propmap.export.files import (
    Files,
    Samples,
    errors,
    identifier,
    literal,
    middle_omega,
    note,
    rendered,
    sample,
    slope,
    static_loads,
    vehicle_name,
    vehicle_note,
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
#
# With the velocity through the air split along and across the axis, the plugin applies thrust =
# motorConstant Omega^2, torque = momentConstant thrust, drag = |Omega| rotorDragCoefficient
# v_across and, about v_across, |Omega| rollingMomentCoefficient v_across.  It has no side force and
# no pitching moment.


@dataclass(frozen=True)
class MotorModel:
    """The plugin's parameters [N s^2], [m], [N s^2/m], [N s^2], by its formulas."""

    motor_constant: float
    moment_constant: float
    rotor_drag_coefficient: float
    rolling_moment_coefficient: float

    def loads(self, omega: Floats, inplane: Floats) -> dict[str, Floats]:
        """Loads (n,) [N], [N m] at n points [rad/s], [m/s]."""
        thrust, across = self.motor_constant * omega**2, omega * inplane
        return {
            "thrust": thrust,
            "drag": self.rotor_drag_coefficient * across,
            "torque": self.moment_constant * thrust,
            "roll_moment": self.rolling_moment_coefficient * across,
        }


def fit_motor_model(table: LoadTable, samples: Samples) -> MotorModel:
    """Static thrust and torque as they are; drag and roll moment by least squares."""
    omega = middle_omega(table)
    static = static_loads(table, np.array([omega]))
    thrust, torque = float(static["thrust"][0]), float(static["torque"][0])
    drag, roll = slope(samples, "drag"), slope(samples, "roll_moment")
    return MotorModel(thrust / omega**2, torque / thrust, drag, roll)


def gazebo_files(table: LoadTable) -> Files:
    """The SDF elements and the note."""
    samples = sample(table)
    fitted = fit_motor_model(table, samples)
    found = errors(samples, fitted.loads(samples.omega, samples.inplane))
    rpm = middle_omega(table) / RPM
    return {
        f"{identifier(table)}_motor.sdf": rendered("motor.sdf", table, fitted=fitted),
        "README-gazebo.txt": note(table, "gazebo", found, rpm=rpm),
    }


# -------------------------------------------------------------------------------------------------
# Target ``rotorpy``: the rotor's part of a RotorPy vehicle.
#
# RotorPy's rotor gives thrust = k_eta Omega^2 + k_h v_across^2 - k_z Omega v_axial, torque = k_m
# Omega^2, drag = k_d Omega v_across, and a flapping moment k_flap Omega v_across about the axis to
# the left of the in-plane velocity, which is minus the pitching moment.  It has no rolling moment
# and
# no side force: the exported module adds k_roll and k_side times Omega v_across.


@dataclass(frozen=True)
class RotorPyRotor:
    """RotorPy's coefficients [N s^2], [N m s^2], [kg], [kg], [kg/m], and of in-plane loads by Omega
    and the in-plane speed [kg m], [kg m], [kg]."""

    k_eta: float
    k_m: float
    k_d: float
    k_z: float
    k_h: float
    k_flap: float
    k_roll: float
    k_side: float

    def loads(self, omega: Floats, axial: Floats, inplane: Floats) -> dict[str, Floats]:
        """Loads (n,) [N], [N m] at n points [rad/s], [m/s]."""
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
    """Static thrust and torque as they are, the rest by least squares."""
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
    """The parameters as a Python module, and the note."""
    samples = sample(table)
    fitted = fit_rotor(table, samples)
    found = errors(samples, fitted.loads(samples.omega, samples.axial, samples.inplane))
    rpm = middle_omega(table) / RPM
    return {
        f"{identifier(table)}_rotorpy.py": rendered("rotorpy.py", table, fitted=fitted),
        "README-rotorpy.txt": note(table, "rotorpy", found, rpm=rpm),
    }


# -------------------------------------------------------------------------------------------------
# Target ``rotorpy`` of a vehicle: a RotorPy multirotor with propmap's force and moment of the air.
#
# The module that is written needs propmap: it reads the map beside it and asks ``VehicleForces``.

ROTORS = 4
"""RotorPy's Multirotor inverts the matrix from its rotors' thrusts to thrust and moments."""


def vehicle_rotorpy_files(vehicle: Vehicle, table: LoadTable) -> Files:
    """The module, the map and the note.

    Parameters
    ----------
    vehicle : Vehicle
        With four rotors.
    table : LoadTable
        Loads of its rotors.

    Raises
    ------
    InputError
        For another number of rotors, and where the table is of another propeller or air, see
        ``VehicleForces``.
    """
    if len(vehicle.mounts) != ROTORS:
        raise InputError(
            f"the vehicle has {len(vehicle.mounts)} rotors, RotorPy's Multirotor {ROTORS}",
            "write a multirotor of your own around propmap.VehicleForces",
        )
    Rotors.of(vehicle, table)
    name = vehicle_name(vehicle, table)
    text = rendered(
        "rotorpy_vehicle.py",
        table,
        v=name,
        vehicle=vehicle,
        made=literal(replace(vehicle, powertrain=Powertrain())),
        directions=[-spin_sign(mount.spin) for mount in vehicle.mounts],
        fitted=fit_rotor(table, sample(table)),
    )
    return {
        f"{name}_rotorpy.py": text,
        f"{identifier(table)}.npz": table.save,
        "README-rotorpy.txt": vehicle_note(vehicle, table, "rotorpy", v=name),
    }


# -------------------------------------------------------------------------------------------------
# Target ``jsbsim``: a propeller of thrust and power coefficients against J = V/(n D).
#
# JSBSim's propeller has thrust and torque alone.  The four loads by the in-plane velocity are
# external reactions: a line in Omega and the axial velocity, times the in-plane velocity, as in
# ``multinomial``.

POINTS = 121
"""Of the table.  JSBSim interpolates linearly: 1e-4 of the static coefficient between these."""


def coefficients(table: LoadTable) -> tuple[Floats, Floats, Floats]:
    """J, C_T = T/(rho n^2 D^4) and C_P = P/(rho n^3 D^5), (k,) each, rising J.

    With descent, J < 0, down to where the map has no values.  Each is taken at the middle omega,
    or at the largest that reaches that J within the envelope.
    """
    low, high = table.envelope["beta"]
    if low > 1e-9:
        raise InputError(
            f"the map's beta begins at {np.degrees(low):g} deg, without axial flight",
            "build it with --beta 0:...",
        )
    radius, (_, fastest) = table.content.radius, table.envelope["speed"]
    advance = np.linspace(0.0, float(table.content.advance[-1]), POINTS)
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


def model_loads(table: LoadTable, samples: Samples, forms: Forms) -> dict[str, Floats]:
    """What JSBSim makes of the samples' velocities with these ``forms``, (n,) [N], [N m]."""
    thrust, torque = _axial_loads(table, samples.omega, samples.axial)
    across = multinomial_loads(forms, samples, table.content.density)
    found = {name: across[name] for name, load in LOADS.items() if load.inplane}
    return found | {"thrust": thrust, "torque": torque}


def jsbsim_files(table: LoadTable) -> Files:
    """The propeller's XML, that of the reactions across its axis, and the note."""
    samples = sample(table)
    forms = fit_multinomial(samples, table.content.density)
    found = errors(samples, model_loads(table, samples, forms))
    of_thrust, of_torque = axial_error(table)
    advance, thrust, power = coefficients(table)
    values = {"advance": advance, "thrust": thrust, "power": power}
    inches = 2.0 * table.content.radius / INCH
    told = {"advance": advance, "of_thrust": of_thrust, "of_torque": of_torque}
    return {
        f"{identifier(table)}.xml": rendered("jsbsim.xml", table, inches=inches, **values),
        f"{identifier(table)}_reactions.xml": rendered(
            "jsbsim_reactions.xml", table, forms=forms, **_reaction_units()
        ),
        "README-jsbsim.txt": note(table, "jsbsim", found, **told),
    }


def _reaction_units() -> dict[str, float]:
    """Of the reactions' factors: density in slug/ft^3, a velocity in ft/s, force and moment in lbf
    and lbf ft."""
    per_pound = SLUG_PER_FT3 * FOOT / POUND
    return {
        "per_lbs": per_pound,
        "per_lbsft": per_pound / FOOT,
        "rad_s_per_rpm": RPM,
        "m_per_ft": FOOT,
    }


def axial_error(table: LoadTable) -> tuple[float, float]:
    """Worst errors of thrust and torque in axial climb, as shares of static loads."""
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
    """JSBSim's thrust [N] and torque [N m] at n axial velocities, (n,)."""
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
    """Loads (n,) [N], [N m] at the samples' points, in air of a density [kg/m^3]."""
    return {name: density * _terms(name, samples) @ forms[name] for name in LOADS}


def fit_multinomial(samples: Samples, density: float) -> Forms:
    """The least squares of the errors as shares of static loads, where simple models are meant."""
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
    """The expressions in Python and C, and the note."""
    samples, density = sample(table), table.content.density
    forms = fit_multinomial(samples, density)
    found = errors(samples, multinomial_loads(forms, samples, density))
    name, values = f"{identifier(table)}_multinomial", {"forms": forms, "density": density}
    return {
        f"{name}.py": rendered("multinomial.py", table, **values),
        f"{name}.h": rendered("multinomial.h", table, **values),
        "README-multinomial.txt": note(table, "multinomial", found),
    }


def _terms(name: str, at: Samples) -> Floats:
    """What the factors of a load's form stand before, (n, 4) or (n, 2)."""
    if LOADS[name].inplane:
        return np.stack([at.omega * at.inplane, at.axial * at.inplane], axis=-1)
    return np.stack([at.omega**2, at.omega * at.axial, at.axial**2, at.inplane**2], axis=-1)


# -------------------------------------------------------------------------------------------------
# Targets ``npz``, ``nc`` and ``csv``: the map itself, in other files.


def npz_files(table: LoadTable) -> Files:
    """The map as ``propmap.table.LoadTable`` reads it."""
    return {f"{identifier(table)}.npz": table.save, "README-npz.txt": note(table, "npz")}


def nc_files(table: LoadTable) -> Files:
    """The map as NetCDF."""
    from propmap.table.files import write_netcdf

    return {
        f"{identifier(table)}.nc": lambda path: write_netcdf(table, path),
        "README-nc.txt": note(table, "nc"),
    }


def csv_files(table: LoadTable) -> Files:
    """The map's knots as rows of numbers."""
    return {f"{identifier(table)}.csv": _rows(table), "README-csv.txt": note(table, "csv")}


def _rows(table: LoadTable) -> str:
    content = table.content
    text = io.StringIO()
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
    return text.getvalue()
