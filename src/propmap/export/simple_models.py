"""Targets ``rotorpy``, ``mujoco``, ``jsbsim``, ``multinomial``, and table files.

The note of each target lists its equations.
"""

from __future__ import annotations

import csv
import dataclasses
import io
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from propmap.aircraft.trim import Aircraft
from propmap.errors import InputError
from propmap.export import files
from propmap.export.steady_loads import check_hover
from propmap.loads import LOADS
from propmap.results import spin_sign
from propmap.table.query import LoadTable
from propmap.typing import Floats
from propmap.units import FOOT, INCH, POUND, RPM, SLUG_PER_FT3
from propmap.vehicle.powertrain import Powertrain
from propmap.vehicle.throttle import LAG, USUAL
from propmap.vehicle.vehicle import Vehicle
from propmap.vehicle.vehicle_forces import Rotors

# --- Targets ``rotorpy``, rotor parameters or a whole vehicle for RotorPy, and ``mujoco`` --------


class RotorPyRotor(NamedTuple):
    """RotorPy's coefficients, and k_roll and k_side of the exported mix-in."""

    k_eta: float  # [N s^2]
    k_m: float  # [N m s^2]
    k_d: float  # [kg]
    k_z: float  # [kg]
    k_h: float  # [kg/m]
    k_flap: float  # [kg m]
    k_roll: float  # [kg m]
    k_side: float  # [kg]

    def loads(self, omega: Floats, axial: Floats, inplane: Floats) -> dict[str, Floats]:
        """Return loads (n,) [N], [N m] at n rotor speeds [rad/s] and velocities [m/s]."""
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


def fit_rotor(table: LoadTable, samples: files.Samples, hover: float | None = None) -> RotorPyRotor:
    """Return a rotor with the static thrust and torque of the table at the rotor speed ``hover``
    [rad/s] (default: the middle of the table), and least-squares fits of the other loads."""
    middle = files.middle_omega(table) if hover is None else hover
    static = files.static_loads(table, np.array([middle]))
    k_eta, k_m = (float(static[load][0]) / middle**2 for load in ("thrust", "torque"))
    chosen = samples.simple
    omega, axial, inplane = (x[chosen] for x in (samples.omega, samples.axial, samples.inplane))
    scale = samples.static["thrust"][chosen]
    matrix = np.stack([-omega * axial, inplane**2], axis=-1) / scale[:, None]
    rest = (samples.loads["thrust"][chosen] - k_eta * omega**2) / scale
    k_z, k_h = np.linalg.lstsq(matrix, rest, rcond=None)[0].tolist()
    k_d, pitch, k_roll, k_side = (
        files.slope(samples, load) for load in ("drag", "pitch_moment", "roll_moment", "side_force")
    )
    return RotorPyRotor(k_eta, k_m, k_d, k_z, k_h, -pitch, k_roll, k_side)


def rotorpy_files(table: LoadTable) -> files.Files:
    """Return a Python module with the parameters, and the note."""
    samples = files.sample(table)
    fitted = fit_rotor(table, samples)
    found = files.errors(samples, fitted.loads(samples.omega, samples.axial, samples.inplane))
    name, text = files.identifier(table), files.rendered("rotorpy.py", table, fitted=fitted)
    return {f"{name}_rotorpy.py": text, "README-rotorpy.txt": files.note("rotorpy", table, found)}


ROTORS = 4  # RotorPy's Multirotor inverts the matrix from its rotors' thrusts to thrust and moments


def vehicle_rotorpy_files(vehicle: Vehicle, table: LoadTable) -> files.Files:
    """Return a module that calls ``VehicleForces``, the table and the note.

    Raises ``InputError`` unless four rotors set thrust and moments, or for an unsuitable table.
    """
    if len(vehicle.mounts) != ROTORS:
        found = f"the vehicle has {len(vehicle.mounts)} rotors, but RotorPy needs {ROTORS}"
        raise InputError(found, "write your own multirotor with propmap.VehicleForces")
    directions = [-spin_sign(mount.spin) for mount in vehicle.mounts]
    if np.linalg.matrix_rank([np.ones(ROTORS), directions, *vehicle.hub_positions.T[:2]]) < ROTORS:
        found = "the rotors cannot set the thrust and all three moments independently"
        raise InputError(found, "check spins and positions: RotorPy requires an invertible matrix")
    Rotors.of(vehicle, table)
    name, rotor = files.vehicle_name(vehicle, table), files.identifier(table)
    module = files.rendered(
        "rotorpy_vehicle.py",
        table,
        v=name,
        vehicle=vehicle,
        made=literal(dataclasses.replace(vehicle, powertrain=Powertrain())),
        directions=directions,
        fitted=fit_rotor(table, files.sample(table)),
    )
    return {
        f"{name}_rotorpy.py": module,
        f"{rotor}.npz": table.save,
        "README-rotorpy.txt": files.note("rotorpy", table, vehicle=vehicle),
    }


def vehicle_mujoco_files(vehicle: Vehicle, table: LoadTable) -> files.Files:
    """Return an MJCF model in hover, a script that simulates it, the table and the note.

    Raises ``InputError`` for a vehicle without inertia or hover, and for a table without descent.
    """
    if vehicle.inertia is None:
        fault = "the vehicle file has no inertia, which the simulation needs"
        raise InputError(fault, "add inertia = [about x, about y, about z] in kg m^2")
    low, high = np.degrees(table.envelope["beta"])
    if low > 1e-6 or high < 180.0 - 1e-6:
        fault = f"the table's beta is {low:g} to {high:g} deg, but hover needs both 0 and 180"
        raise InputError(fault, "build the table with --beta 0:180")
    craft = Aircraft(vehicle, table)
    hover = craft.steady(0.0, margin=False)
    check_hover(craft, hover)
    name, rotor, lag = files.vehicle_name(vehicle, table), files.identifier(table), USUAL[LAG]
    (cp, cr), (sp, sr) = (
        f(0.5 * np.array([hover.pitch[0], hover.roll[0]])) for f in (np.cos, np.sin)
    )
    # Quaternion of pitch, then roll, without rounding errors of the solver and negative zeros.
    turned = [round(float(part), 12) + 0.0 for part in (cp * cr, cp * sr, sp * cr, -sp * sr)]
    parts = {"v": name, "vehicle": vehicle, "hover": hover.rotor_speed[0].tolist()}
    parts |= {"made": literal(dataclasses.replace(vehicle, powertrain=Powertrain())), "lag": lag}
    return {
        f"{name}.xml": files.rendered("mujoco.xml", table, turned=turned, **parts),
        f"{name}_mujoco.py": files.rendered("mujoco_fly.py", table, **parts),
        f"{rotor}.npz": table.save,
        "README-mujoco.txt": files.note("mujoco", table, vehicle=vehicle, lag=lag),
    }


def literal(value: Any) -> str:
    """Return the Python expression of a dataclass, tuple, array or number.

    Class names have no module, and fields with their default value are omitted.
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
# Target ``jsbsim``: a propeller with thrust and power coefficients over J = V/(n D), and the four
# loads due to in-plane velocity as external reactions, with the equations of ``multinomial``.

JSBSIM_POINTS = 121  # linear interpolation between them has an error of 1e-4 of the static value


def coefficients(table: LoadTable) -> tuple[Floats, Floats, Floats]:
    """Tabulate C_T = T/(rho n^2 D^4) and C_P = P/(rho n^3 D^5) over rising J, (k,) each.

    Omega is the smaller of ``files.middle_omega`` and the largest omega that reaches J.  Descent is
    included up to the first point without loads.
    """
    low, high = table.envelope["beta"]
    if low > 1e-9:
        fault = f"the table's beta begins at {np.degrees(low):g} deg, without axial flight"
        raise InputError(fault, "build the table with --beta 0:...")
    radius, (_, fastest) = table.content.radius, table.envelope["speed"]
    advance = np.linspace(0.0, float(table.content.advance[-1]), JSBSIM_POINTS)
    parts = []
    for beta, sign in ((high, -1.0), (low, 1.0)):
        if sign < 0.0 and abs(beta - np.pi) > 1e-9:
            continue
        ratio = advance[:0:-1] if sign < 0.0 else advance
        reach = fastest / (np.maximum(ratio, 1e-12) * radius)
        # Only the smallest omega reaches the largest advance ratio; limit rounding errors there.
        omega = np.maximum(np.minimum(files.middle_omega(table), reach), table.envelope["omega"][0])
        found = table.loads(omega, np.minimum(ratio * omega * radius, fastest), beta)
        turns, diameter = omega / (2.0 * np.pi), 2.0 * radius
        force = table.content.density * turns**2 * diameter**4
        power = found.power / (force * turns * diameter)
        parts.append(np.stack([sign * np.pi * ratio, found.thrust / force, power]))
    each = np.concatenate(parts, axis=1)
    known = np.isfinite(each).all(axis=0)
    # JSBSim would interpolate across a gap in descent: omit the gap and all points beyond it.
    gaps = np.flatnonzero(~known & (each[0] < 0.0))
    each = each[:, gaps[-1] + 1 :] if gaps.size else each
    each = each[:, np.isfinite(each).all(axis=0)]
    return each[0], each[1], each[2]


def jsbsim_files(table: LoadTable) -> files.Files:
    """Return the XML files of the propeller and of the in-plane reactions, and the note."""
    samples, name = files.sample(table), files.identifier(table)
    forms = fit_multinomial(samples, table.content.density)
    across = multinomial_loads(forms, samples, table.content.density)
    by_axis = _axial_loads(table, samples.omega, samples.axial)
    found = files.errors(samples, across | dict(zip(("thrust", "torque"), by_axis, strict=True)))
    advance, thrust, power = coefficients(table)
    worst = axial_error(table)
    per_pound = SLUG_PER_FT3 * FOOT / POUND
    return {
        f"{name}.xml": files.rendered(
            "jsbsim.xml",
            table,
            inches=2.0 * table.content.radius / INCH,
            advance=advance,
            thrust=thrust,
            power=power,
        ),
        f"{name}_reactions.xml": files.rendered(
            "jsbsim_reactions.xml",
            table,
            forms=forms,
            # JSBSim's units: density slug/ft^3, velocity ft/s, force lbf, moment lbf ft.
            per_lbs=per_pound,
            per_lbsft=per_pound / FOOT,
            rad_s_per_rpm=RPM,
            m_per_ft=FOOT,
        ),
        "README-jsbsim.txt": files.note("jsbsim", table, found, advance=advance, axial_error=worst),
    }


def axial_error(table: LoadTable) -> tuple[float, float]:
    """Return the largest errors of thrust and torque in axial climb, relative to static loads."""
    ends = (table.envelope["omega"], table.envelope["speed"])
    omega, speed = (
        x.ravel() for x in np.meshgrid(*(np.linspace(*end, 41) for end in ends), indexing="ij")
    )
    beta = table.envelope["beta"][0]
    expected, still = table.loads(omega, speed, beta), table.loads(omega, 0.0, beta)
    thrust, torque = _axial_loads(table, omega, speed)
    of_thrust = np.nanmax(abs(thrust - expected.thrust) / still.thrust)
    return float(of_thrust), float(np.nanmax(abs(torque - expected.torque) / still.torque))


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
# Let lambda_c = V cos(beta)/(Omega R) and mu = V sin(beta)/(Omega R).  Thrust and torque are
# Omega^2 times a quadratic in lambda_c and an even quadratic in mu; drag and roll moment are
# Omega^2 mu times a linear function of lambda_c.  Expanded, these equations contain no division by
# Omega and no root: thrust and torque are quadratic forms of Omega and velocity, and the drag is a
# smooth vector.

Forms = Mapping[str, tuple[float, ...]]
"""Factors by load, over the density: of Omega^2, Omega z, z^2 and r^2 for thrust and torque, of
Omega r and z r for the other loads; z is the axial velocity, r the in-plane velocity.  Units are
[m^4], [m^3], [m^2], for moments times [m]."""


def multinomial_loads(forms: Forms, samples: files.Samples, density: float) -> dict[str, Floats]:
    """Return loads (n,) [N], [N m] at the samples' points, for an air ``density`` [kg/m^3]."""
    return {name: density * _terms(name, samples) @ forms[name] for name in LOADS}


def fit_multinomial(samples: files.Samples, density: float) -> Forms:
    """Fit the forms by least squares of relative errors, at the points for simple models."""
    chosen, found = samples.simple, {}
    for name in LOADS:
        scale = 1.0 / samples.static[name][chosen]
        matrix = density * _terms(name, samples)[chosen] * scale[:, None]
        # Scale the columns to equal size: they contain Omega^2 and V^2.
        size = np.sqrt((matrix**2).mean(axis=0))
        target = samples.loads[name][chosen] * scale
        solved = np.linalg.lstsq(matrix / size, target, rcond=None)[0]
        found[name] = tuple((solved / size).tolist())
    return found


def multinomial_files(table: LoadTable) -> files.Files:
    """Return the polynomials in Python and C, and the note."""
    samples, density = files.sample(table), table.content.density
    forms = fit_multinomial(samples, density)
    found = files.errors(samples, multinomial_loads(forms, samples, density))
    name, values = f"{files.identifier(table)}_multinomial", {"forms": forms, "density": density}
    return {
        f"{name}.py": files.rendered("multinomial.py", table, **values),
        f"{name}.h": files.rendered("multinomial.h", table, **values),
        "README-multinomial.txt": files.note("multinomial", table, found),
    }


def _terms(name: str, at: files.Samples) -> Floats:
    """Return the terms that the factors of a load multiply, (n, 4) or (n, 2)."""
    if LOADS[name].inplane:
        return np.stack([at.omega * at.inplane, at.axial * at.inplane], axis=-1)
    return np.stack([at.omega**2, at.omega * at.axial, at.axial**2, at.inplane**2], axis=-1)


# --- Targets ``npz``, ``nc`` and ``csv``: the table in other file formats ------------------------


def npz_files(table: LoadTable) -> files.Files:
    """Return the table in the format of ``propmap.table.LoadTable``, and the note."""
    name = f"{files.identifier(table)}.npz"
    return {name: table.save, "README-npz.txt": files.note("npz", table)}


def nc_files(table: LoadTable) -> files.Files:
    """Return the table as NetCDF, and the note."""

    name = f"{files.identifier(table)}.nc"
    return {name: table.to_netcdf, "README-nc.txt": files.note("nc", table)}


def csv_files(table: LoadTable) -> files.Files:
    """Return the table's knots as CSV rows, with empty fields for missing values, and the note."""
    content, text = table.content, io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    heads = (f"{name}_coefficient" for name in LOADS)
    writer.writerow(["omega_rad_s", "advance", "beta_rad", *heads])
    for omega, level in zip(content.omega.tolist(), content.coefficients, strict=True):
        for i, advance in enumerate(content.advance.tolist()):
            for j, beta in enumerate(content.beta.tolist()):
                values = level[:, i, j].astype(np.float32)
                shown = ["" if np.isnan(value) else str(value) for value in values]
                writer.writerow([omega, advance, beta, *shown])
    name = f"{files.identifier(table)}.csv"
    return {name: text.getvalue(), "README-csv.txt": files.note("csv", table)}
