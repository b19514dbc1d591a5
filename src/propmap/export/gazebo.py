"""Target ``gazebo``: one plugin per rotor, for gz-sim and for PX4's Gazebo Classic.

The equations of the plugins are in ``MulticopterMotorModel.cc`` of gz-sim 8 to 10, and in
``gazebo_motor_model.cpp`` of PX4-SITL_gazebo-classic.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from propmap.aircraft.trim import STATUSES, Aircraft
from propmap.errors import InputError, quoted
from propmap.export import files
from propmap.export.simple_models import fit_rotor
from propmap.export.steady_loads import check_hover, thrust_curve
from propmap.loads import LOADS
from propmap.results import spin_sign
from propmap.table.query import LoadTable
from propmap.typing import Floats
from propmap.units import RPM
from propmap.vehicle.vehicle import SPINS, Vehicle
from propmap.vehicle.vehicle_forces import load_rows

SPEEDS = (0.0, 5.0, 10.0, 15.0)  # airspeeds at which the note states the errors [m/s]
JOINT, LINK = "rotor_{}_joint", "rotor_{}"  # default names; {} is the number of the rotor

Flight = tuple[str, Floats]
"""Description of a flight, and an array (3, k) for its k rotors: rotor speeds [rad/s], velocities
along the axes [m/s], velocities in the disk planes [m/s]."""


def table_files(table: LoadTable, *, joint: str = JOINT, link: str = LINK) -> files.Files:
    """Return the plugins of a counter-clockwise and a clockwise rotor, and the note."""
    omega, beta = files.middle_omega(table), min(0.5 * np.pi, table.envelope["beta"][1])
    flights = [
        (
            f"one rotor at {speed:g} m/s and beta {np.degrees(beta):.0f} deg",
            np.array([[omega], [speed * np.cos(beta)], [speed * np.sin(beta)]]),
        )
        for speed in SPEEDS
        if speed <= table.envelope["speed"][1]
    ]
    known = {"full": False, "states": None, "largest": table.envelope["omega"][1]}
    names = {"joint": joint, "link": link}
    return _files(table, files.identifier(table), SPINS, names, omega, flights, **known)


def vehicle_files(
    vehicle: Vehicle, table: LoadTable, *, joint: str = JOINT, link: str = LINK
) -> files.Files:
    """Return the plugins of all rotors of a ``vehicle``, and the note.

    Raises ``InputError`` for a vehicle that does not hover.
    """
    craft = Aircraft(vehicle, table)
    states = craft.steady(SPEEDS, margin=False)
    check_hover(craft, states)
    turning, hubs = craft.rotor_motion(states)
    axial = np.einsum("nkj,kj->nk", hubs, craft.rotors.axis)
    inplane = np.sqrt(np.maximum(np.sum(hubs**2, axis=-1) - axial**2, 0.0))
    spins = [mount.spin for mount in vehicle.mounts]
    words = "the {} rotors in level flight at {:g} m/s".format
    flown = [words(len(spins), speed) for speed in states.speed[states.found]]
    powered = None not in (vehicle.powertrain.motor, vehicle.powertrain.battery)
    full = thrust_curve(craft, 1.0) if powered else None
    return _files(
        table,
        files.vehicle_name(vehicle, table),
        spins,
        {"joint": joint, "link": link},
        float(turning[0].mean()),
        list(zip(flown, np.stack([turning, axial, inplane], axis=1), strict=True)),
        largest=table.envelope["omega"][1] if full is None else full.full_speed,
        full=full is not None,
        states=states,
        statuses=STATUSES,
        rests_on=files.rests_on(vehicle, table),
    )


def _files(
    table: LoadTable,
    name: str,
    spins: Sequence[str],
    names: Mapping[str, str],
    omega: float,
    flights: Sequence[Flight],
    **values: Any,
) -> files.Files:
    """Return the files of a propeller or vehicle ``name``, for rotors with these ``spins``.

    ``names`` contains the patterns of the names of joints and links.  ``omega`` [rad/s] is the
    rotor speed of the static loads.  The note lists the errors in the ``flights``.
    """
    for kind, pattern in names.items():
        if "{}" not in pattern or not pattern.isprintable():
            fault = f"the {kind} name {quoted(pattern)} does not contain {{}}"
            raise InputError(fault, "write {} for the number of the rotor, as in rotor_{}")
    samples = files.sample(table)
    fitted = fit_rotor(table, samples, omega)._replace(k_z=0.0, k_h=0.0, k_flap=0.0, k_side=0.0)
    near = np.abs(samples.axial[samples.simple])
    loss = (1.0 - samples.loads["thrust"] / samples.static["thrust"])[samples.simple]
    # The lower limit of the loss avoids a division by zero if the thrust does not decrease.
    airspeed = float(near @ near / max(near @ loss, 1e-6 * (near @ near)))
    found, classic = [], []
    for where, (turning, axial, inplane) in flights:
        rows, _ = load_rows(table, turning, axial, inplane)
        if np.isfinite(rows).all():
            loads, static = dict(zip(LOADS, rows, strict=True)), files.static_loads(table, turning)
            share = files.shares(loads, fitted.loads(turning, axial, inplane), static)
            found.append(files.error_sizes(where, share))
            decline = fitted.k_eta * turning**2 * np.minimum(np.abs(axial) / airspeed, 1.0)
            thrust = share[:, list(LOADS).index("thrust")] - decline / static["thrust"]
            classic.append(f"{np.abs(thrust).max():.1%}")
    rotors = [
        {kind: pattern.replace("{}", str(k)) for kind, pattern in names.items()}
        | {"spin": spin, "sign": spin_sign(spin)}
        for k, spin in enumerate(spins)
    ]
    values |= {
        "name": name,
        "fitted": fitted,
        "rotors": rotors,
        "rpm": omega / RPM,
        "airspeed": airspeed,
    }
    note = files.rendered(
        "README-gazebo.txt", table, simple=files.SIMPLE, classic=classic, **values
    )
    return {
        f"{name}_gz.sdf": files.rendered("gazebo.sdf", table, classic=False, **values),
        f"{name}_gazebo_classic.sdf": files.rendered("gazebo.sdf", table, classic=True, **values),
        "README-gazebo.txt": files.note("gazebo", table, found, text=note),
    }
