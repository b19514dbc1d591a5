"""What a step costs in MuJoCo: `make bench-sim`.  Writes results/sim.json.

A quadrotor of 1.2 kg on APC 8x6E in oblique flight, each rotor at another speed, in steps of a
millisecond by Euler: one evaluation of the forces a step.  Times are wall time, the least of many
short flights, since others may be at work on the machine; compare within one run.  With the core,
a flight begins with the steady inflow.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
from rich.console import Console
from rich.table import Table

import propmap
from benchmarks.results_file import machine, write_results
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.sim.mujoco import MujocoRotors
from propmap.table import build_table
from propmap.vehicle.vehicle import Body, Mount, Vehicle, Wakes

STEPS, FLIGHTS = 50, 100
FLOWN = (4.0, 1.0, 0.5, 0.1, 0.2, 0.1)  # velocity [m/s], rates [rad/s]
SPEEDS = (640.0, 655.0, 650.0, 645.0)  # rad/s
CORNERS = ((1, -1, "ccw"), (-1, 1, "ccw"), (1, 1, "cw"), (-1, -1, "cw"))


def mjcf(vehicle: Vehicle, actuator: str) -> str:
    """The vehicle without shape, each rotor with an ``actuator``."""
    sites = actuators = ""
    for k, mount in enumerate(vehicle.mounts, start=1):
        place, spin = " ".join(map(str, mount.position)), "-" if mount.spin == "ccw" else ""
        sites += f'<site name="rotor_{k}" pos="{place}"/>'
        name = f'name="rotor_{k}" site="rotor_{k}"'
        actuators += f"<general {name} {actuator.replace('SPIN', spin)}/>"
    body = f'<freejoint/><inertial pos="0 0 0" mass="{vehicle.mass}" diaginertia=".01 .01 .02"/>'
    return (
        f'<mujoco><option timestep="0.001"/><worldbody><body>{body}{sites}</body></worldbody>'
        f"<actuator>{actuators}</actuator></mujoco>"
    )


def microseconds(
    text: str, forces: Callable[[Any], Any] | None, speeds: tuple[float, ...] = SPEEDS
) -> float:
    """Least time of a step [us], with ``mj_step``, in flights of a few steps."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.set_mjcb_passive(forces(model) if forces else None)
    least = np.inf
    for _ in range(FLIGHTS):
        mujoco.mj_resetData(model, data)
        data.qvel[:], data.ctrl[:], data.act[:] = FLOWN, speeds, speeds[: model.na]
        start = time.perf_counter()
        for _ in range(STEPS):
            mujoco.mj_step(model, data)
        least = min(least, (time.perf_counter() - start) / STEPS)
    mujoco.set_mjcb_passive(None)
    return 1e6 * least


def hover_callback(vehicle: Vehicle, constant: float, arm: float) -> Callable[[Any], Any]:
    """Thrust k Omega^2 and its torque in a callback with NumPy, as one would write it."""
    spin = np.array([1.0 if mount.spin == "ccw" else -1.0 for mount in vehicle.mounts])
    x, y, _ = vehicle.hub_positions.T
    loads = np.stack([np.ones_like(x), y, -x, -arm * spin]) * constant

    def forces(model: Any, data: Any) -> None:  # noqa: ARG001
        thrust, *moment = loads @ data.act**2
        data.qfrc_passive[:3] += data.xmat[1].reshape(3, 3)[:, 2] * thrust
        data.qfrc_passive[3:6] += moment

    return lambda _: forces


def measure() -> dict[str, float]:
    """Times of a step [us] by case."""
    blade, law = propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")
    rotor, full = Rotor(Model(blade, law)), Rotor(propmap.catalogue_model("apc-8x6e"))
    mounts = tuple(Mount((0.16 * x, 0.16 * y, 0.02), spin=spin) for x, y, spin in CORNERS)
    vehicle = Vehicle("quad", 1.2, blade, mounts, body=Body((0.015, 0.015, 0.03)))
    together = replace(vehicle, wakes=Wakes())
    table = build_table(
        rotor, omega=(400.0, 850.0), speed=(0.0, 10.0), beta=(0.0, np.pi), tolerance=0.02
    )
    constant = float(rotor.loads(650.0, 0.0, 0.0).thrust) / 650.0**2
    arm = float(rotor.loads(650.0, 0.0, 0.0).torque) / (constant * 650.0**2)
    lag = mjcf(vehicle, 'gainprm="0" dyntype="filter" dynprm="0.05"')
    own = mjcf(vehicle, f'gear="0 0 {constant} 0 0 SPIN{constant * arm}"')
    square = tuple(omega**2 for omega in SPEEDS)

    def flown(craft: Vehicle, loads: Any) -> Callable[[Any], Any]:
        return lambda model: MujocoRotors(model, craft, loads)

    lagging = propmap.correction("pitt-peters")
    others = tuple(one for one in full.model.corrections if one != lagging)
    static = replace(full.model, corrections=(*others, propmap.correction("drees")))
    return {
        "mj_step without air": microseconds(lag, None),
        "hover model, MuJoCo's own actuators": microseconds(own, None, square),
        "hover model, callback with NumPy": microseconds(
            lag, hover_callback(vehicle, constant, arm)
        ),
        "table": microseconds(lag, flown(vehicle, table)),
        "table, with wakes": microseconds(lag, flown(together, table)),
        "core, paper's model, dynamic inflow": microseconds(lag, flown(vehicle, rotor)),
        "core, recommended model, dynamic inflow": microseconds(lag, flown(vehicle, full)),
        "core, recommended model, dynamic inflow, with wakes": microseconds(
            lag, flown(together, full)
        ),
        "core, recommended model with the static inflow of Drees": microseconds(
            lag, flown(vehicle, Rotor(static))
        ),
    }


def main() -> None:
    """Measure, print, and write the results."""
    place, found = machine(), measure()
    shown = Table("quadrotor in MuJoCo", "step [us]", "beside mj_step [us]")
    bare = found["mj_step without air"]
    for name, cost in found.items():
        shown.add_row(name, f"{cost:.1f}", f"{round(cost - bare, 1) + 0.0:.1f}")
    console = Console()
    console.print(
        f"{place['cpu']}, {place['cores']} cores, load {place['load_before']}, "
        f"MuJoCo {mujoco.__version__}, core for {place['instructions']}"
    )
    console.print(shown)
    results = {"machine": place, "mujoco": mujoco.__version__, "step_us": found}
    console.print(str(write_results("sim.json", results)))


if __name__ == "__main__":
    main()
