"""Computing time and error of four methods to compute a rotor's loads: `make bench ONLY=choice`.

The methods are hover model, closed form, table and full model.  The rotor is the APC 8x6E with
constants fitted to thrust and torque of ``DATA`` (results/identification.json).  Loads are compared
with the full model over the range of these data, relative to static loads, and with the data.
Hover model and full model with constants fitted to UIUC's axial rows are also compared with the
data, which this fit does not contain.  Writes results/choice.json.
"""

from __future__ import annotations

import json
import math
import time
import types
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

import propmap
from benchmarks.c_header import c_nanoseconds
from benchmarks.results_file import RESULTS, machine, write_results
from propmap.catalogue.lookup import measurement
from propmap.export import export_table
from propmap.hover import HoverModel
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.table import LoadTable, build_table
from propmap.typing import Floats

RPM = np.pi / 30.0
OMEGA, SPEED, BETA = (3700.0 * RPM, 8000.0 * RPM), (0.0, 14.0), (0.0, 0.5 * np.pi)
TOLERANCE = 0.01
DATA = "gill-dandrea-2019-8x6e-fit"
"""The closed-form blade-element model of the oblique campaign of 2019, not its measurements."""
POINTS, SEED = 4096, 2017
SINGLE = 200


@dataclass(frozen=True)
class Way:
    """A method to compute loads."""

    name: str
    loads: Callable[[Floats, Floats, Floats], Floats]  # from omega, speed, beta (n,) to (4, n)
    one: Callable[[float, float, float], Any]
    """Function of one operating point, called as in a simulation."""


COMPARED = ("thrust", "drag", "torque", "roll_moment")
"""Loads that all four methods compute."""


def fitted_rotor(data: str) -> Rotor:
    """Return the rotor with four constants and zero-lift angle fitted to thrust and torque.

    ``data`` names the measurement.
    """
    found = json.loads((RESULTS / "identification.json").read_text(encoding="utf-8"))
    (case,) = (
        c
        for c in found["published"]
        if c["data"] == data
        and c["loads"] == ["thrust", "torque"]
        and "zero_lift_angle" in c["parameters"]
    )
    section = propmap.Airfoil(**case["parameters"], name=f"fitted to {data}")
    return Rotor(Model(propmap.propeller("apc-8x6e"), section))


def ends(rotor: Rotor) -> tuple[Way, Way]:
    """Return the fastest and the slowest method: hover model and full model."""
    hover = HoverModel.from_rotor(rotor)

    def hover_loads(w: Floats, _: Floats, __: Floats) -> Floats:
        return np.stack([hover.thrust(w), 0.0 * w, hover.torque(w), 0.0 * w])

    def model(w: Floats, v: Floats, b: Floats) -> Floats:
        return _stacked(rotor.loads(w, v, b))

    return (
        Way("hover model", hover_loads, lambda w, _, __: (hover.thrust(w), hover.torque(w))),
        Way("full model", model, rotor.loads),
    )


def between(table: LoadTable) -> tuple[Way, Way]:
    """Return the methods based on a table: the closed form, and the table itself."""
    closed = _multinomial(table)

    def closed_loads(w: Floats, v: Floats, b: Floats) -> Floats:
        x, z = v * np.sin(b), v * np.cos(b)
        slopes = closed.drag_slope(w, z) * x, closed.roll_slope(w, z) * x
        return np.stack(
            [closed.thrust(w, x, 0.0, z), slopes[0], closed.torque(w, x, 0.0, z), slopes[1]]
        )

    def closed_one(w: float, v: float, b: float) -> Any:
        x, z = v * math.sin(b), v * math.cos(b)
        return closed.force(w, x, 0.0, z, 1), closed.moment(w, x, 0.0, z, 1)

    return (
        Way("closed form", closed_loads, closed_one),
        Way("table, NumPy", lambda w, v, b: _stacked(table.loads(w, v, b)), table.loads),
    )


def _multinomial(table: LoadTable) -> Any:
    """Import the module that ``propmap export --to multinomial`` writes."""
    with TemporaryDirectory() as folder:
        (path,) = (p for p in export_table(table, "multinomial", folder) if p.suffix == ".py")
        module = types.ModuleType("multinomial")
        exec(compile(path.read_text(encoding="utf-8"), path.name, "exec"), module.__dict__)
    return module


def _stacked(found: Any) -> Floats:
    return np.stack([np.asarray(getattr(found, name)) for name in COMPARED])


def seconds(call: Callable[[], Any], repeats: int) -> float:
    """Return the shortest time of ``call`` [s], because other processes only lengthen it.

    A first call is not timed.
    """
    call()
    taken = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        taken.append(time.perf_counter() - start)
    return min(taken)


def measured_errors(way: Way) -> dict[str, float]:
    """Return the rms error over the rms of the measured load, by load."""
    data = measurement(DATA)
    found = way.loads(data.omega, data.speed, data.beta)
    scale = data.air_density / propmap.Air().density
    errors = {}
    for k, name in enumerate(COMPARED):
        truth = data.loads[name]
        off = found[k] * scale - truth
        errors[name] = float(np.sqrt(np.nanmean(off**2) / np.mean(truth**2)))
    return errors


def measure() -> dict[str, Any]:
    """Measure times and errors of all methods."""
    place = machine()
    rotor = fitted_rotor(DATA)
    begin = time.perf_counter()
    table = build_table(rotor, omega=OMEGA, speed=SPEED, beta=BETA, tolerance=TOLERANCE)
    build_seconds = time.perf_counter() - begin
    with TemporaryDirectory() as folder:
        table.save(Path(folder) / "table.npz")
        size = (Path(folder) / "table.npz").stat().st_size
    rng = np.random.default_rng(SEED)
    points = [rng.uniform(*ends, POINTS) for ends in (OMEGA, SPEED, BETA)]
    flight = (6000.0 * RPM, 10.0, float(np.radians(60.0)))
    cheapest, dearest = ends(rotor)
    every = (cheapest, *between(table), dearest)
    truth = dearest.loads(*points)
    still = rotor.loads(points[0], 0.0, 0.0)
    thrust, torque = still.thrust, still.torque
    static = np.stack([thrust, thrust, torque, thrust * rotor.model.propeller.radius])
    told = []
    for way in every:
        share = (way.loads(*points) - truth) / static
        rms = np.sqrt(np.nanmean(share**2, axis=1))
        told.append(
            {
                "name": way.name,
                "microseconds_single": 1e6 * seconds(lambda w=way: w.one(*flight), SINGLE),  # type: ignore[misc]
                "microseconds_batch": 1e6
                * seconds(lambda w=way: w.loads(*points), 7)  # type: ignore[misc]
                / POINTS,
                "model_error": None
                if way is dearest
                else dict(zip(COMPARED, rms.tolist(), strict=True)),
                "measured": measured_errors(way),
            }
        )
    elsewhere = fitted_rotor("uiuc-8x6e")
    in_c = c_nanoseconds(table)
    return {
        "machine": place,
        "rotor": f"{rotor.model.propeller.name}, {rotor.model.airfoil.name}",
        "data": DATA,
        "envelope": {"omega": OMEGA, "speed": SPEED, "beta": BETA},
        "points": POINTS,
        "ways": told,
        "unseen": [{"name": w.name, "measured": measured_errors(w)} for w in ends(elsewhere)],
        "table": {
            "tolerance": TOLERANCE,
            "build_seconds": build_seconds,
            "bytes": size,
            "microseconds_in_c": None if in_c is None else 1e-3 * in_c,
            "certificate": table.certificate,
        },
    }


def main() -> None:
    """Measure, print, and write the results."""
    found = measure()
    for way in found["ways"]:
        print(way)
    print({k: v for k, v in found["table"].items() if k != "certificate"})
    print(write_results("choice.json", found))


if __name__ == "__main__":
    main()
