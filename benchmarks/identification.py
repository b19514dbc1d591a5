"""How well and how fast parameters are identified: `make bench ONLY=identification`.

Twin experiments: level flights of a quadrotor with four APC 8x6E are computed with known
parameters, and identified again from the paper's x0 and from random starts; once without noise,
and two hundred times with noise, to count how often the stated 95 % intervals contain the truth;
the last also of a tunnel test.  Writes results/identification.json.  With `coverage --cluster
local:2` these fits are spread over workers, with the same results.
"""

from __future__ import annotations

import functools
import json
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import propmap
from benchmarks.results_file import RESULTS, machine, write_results
from benchmarks.whole_process import whole_process
from propmap.catalogue.lookup import measurement
from propmap.cli.options import workers_of
from propmap.fit.comparison import compare_tunnel
from propmap.fit.fit import Settings, fit
from propmap.fit.flight import ForceModel, level_rows
from propmap.fit.least_squares import Rows
from propmap.fit.parameters import Choice
from propmap.fit.tunnel import TunnelData, first_guess, model_with, tunnel_rows
from propmap.flight.simulate import trim
from propmap.model.airfoil import PAPER_FOUR, parameter_set
from propmap.model.model import Model
from propmap.tasks import Workers
from propmap.vehicle.log import FlightLog, pitch_and_roll
from propmap.vehicle.vehicle import Mount, Vehicle
from tools.interval_coverage import noisy_intervals

SETS = ("paper-soft", "paper-stiff", "paper-apc")
ARM, MASS = 0.2, 1.0
PLACES = ((ARM, ARM, "cw"), (ARM, -ARM, "ccw"), (-ARM, ARM, "ccw"), (-ARM, -ARM, "cw"))
SPEEDS = np.linspace(0.5, 14.5, 20)
NOISE, REPETITIONS = 0.01, 200
TUNNEL_SPEEDS = np.linspace(0.0, 9.5, 20)
TUNNEL_SIX = (*PAPER_FOUR, "zero_lift_angle", "c_d0")


def quadrotor() -> Vehicle:
    """A 1 kg quadrotor with four APC 8x6E."""
    mounts = tuple(Mount((x, y, 0.0), spin=spin) for x, y, spin in PLACES)
    return Vehicle("twin", MASS, propmap.propeller("apc-8x6e"), mounts)


def noise_free(name: str, starts: int) -> dict[str, Any]:
    """One twin without noise."""
    vehicle, truth = quadrotor(), parameter_set(name)
    points = trim(vehicle, truth, SPEEDS)
    choice = Choice()
    rows = level_rows(ForceModel(vehicle, points, first_guess()), choice)
    found = fit(rows, choice, Settings(starts=starts, folds=0))
    return {
        "largest_residual_share_of_weight": float(np.max(np.abs(found.minimum.residual))),
        "relative_errors": {
            n: float(found.x[k] / getattr(truth, n) - 1.0) for k, n in enumerate(choice.free)
        },
        "verdicts": dict(zip(choice.free, found.uncertainty.verdicts, strict=True)),
        "singular_values": found.uncertainty.singular_values.tolist(),
        "starts_within_1e-3_of_the_truth": int(
            sum(
                abs(e.x[0] / truth.c_l1 - 1.0) < 1e-3 and abs(e.x[3] / truth.alpha_0 - 1.0) < 1e-3
                for e in found.minimum.ends
            )
        ),
        "starts": starts,
        "seconds": found.seconds,
    }


def coverage(name: str, what: str, workers: Workers) -> dict[str, Any]:
    """Share of noisy twins whose intervals contain the truth, per parameter of a case."""
    rows, choice = case(name, what)
    truth = parameter_set(name)
    names = choice.free
    found = noisy_intervals(
        rows,
        choice,
        NOISE,
        REPETITIONS,
        workers=workers,
        remake=functools.partial(rows_of_case, name, what),
    )
    inside = found.hold(np.array([getattr(truth, n) for n in names]))
    good, widths = found.identified, found.high - found.low
    return {
        n: {
            "called_identified": int(good[:, k].sum()),
            "of_these_truth_inside": float(inside[good[:, k], k].mean())
            if good[:, k].any()
            else None,
            "of_all_truth_inside": float(inside[:, k].mean()),
            "median_width": float(np.median(widths[:, k])),
        }
        for k, n in enumerate(names)
    }


LEVEL_FOUR, LEVEL_TWO = "level flights, four free", "level flights, two free"
TUNNEL_FOUR = "tunnel, thrust and torque, four free"
CASES = (LEVEL_FOUR, LEVEL_TWO, TUNNEL_FOUR)


def case(name: str, what: str) -> tuple[Rows, Choice]:
    """One set of Table I: level flights with the paper's four parameters free or with two, or a
    tunnel test (axial, and at 40 and 80 deg) with the four."""
    vehicle, truth = quadrotor(), parameter_set(name)
    true_values = {n: getattr(truth, n) for n in PAPER_FOUR}
    four = Choice(start=true_values)
    two = Choice(("c_l1", "alpha_0"), fixed={n: true_values[n] for n in ("c_l2", "c_d")})
    if what == TUNNEL_FOUR:
        model = Model(vehicle.propeller, first_guess())
        return tunnel_rows(model, tunnel_twin(truth), four), four
    flights = ForceModel(vehicle, trim(vehicle, truth, SPEEDS), first_guess())
    choice = four if what == LEVEL_FOUR else two
    return level_rows(flights, choice), choice


def rows_of_case(name: str, what: str) -> Rows:
    """The rows of ``case``, for workers."""
    return case(name, what)[0]


def coverages(cluster: str | None) -> dict[str, Any]:
    """All cases of all sets, by the workers of ``--cluster``."""
    with workers_of(cluster) as workers:
        return {name: {what: coverage(name, what, workers) for what in CASES} for name in SETS}


def tunnel_twin(truth: propmap.Airfoil) -> TunnelData:
    """Computed thrust and torque of the APC 8x6E at 5000 rpm, 60 points."""
    beta, speed = (a.ravel() for a in np.meshgrid(np.radians([0.0, 40.0, 80.0]), TUNNEL_SPEEDS))
    omega = np.full(beta.size, 5000.0 * np.pi / 30.0)
    loads = propmap.Rotor(propmap.Model(propmap.propeller("apc-8x6e"), truth)).loads(
        omega, speed, beta
    )
    measured = {"thrust": np.asarray(loads.thrust), "torque": np.asarray(loads.torque)}
    return TunnelData("twin", omega, speed, beta, measured)


def timing() -> dict[str, float]:
    """Seconds of whole identifications, once compiled and as whole processes."""
    vehicle, truth = quadrotor(), parameter_set("paper-apc")
    points = trim(vehicle, truth, SPEEDS)
    choice = Choice()
    rows = level_rows(ForceModel(vehicle, points, first_guess()), choice)
    rng = np.random.default_rng(1)
    noisy = rows.measured * (1.0 + NOISE * rng.standard_normal(rows.measured.size))
    rows = replace(rows, measured=noisy)
    found = {}
    for what, settings in (("one_start", Settings(1, folds=0)), ("as_the_command", Settings(2))):
        fit(rows, choice, settings)
        begin = time.perf_counter()
        fit(rows, choice, settings)
        found[f"level_flights_four_parameters_{what}_s"] = time.perf_counter() - begin
    data = bundled("uiuc-8x6e")
    six = Choice(TUNNEL_SIX)
    tunnel = tunnel_rows(Model(propmap.propeller("apc-8x6e"), first_guess()), data, six)
    fit(tunnel, six, Settings())
    begin = time.perf_counter()
    fit(tunnel, six, Settings())
    found["tunnel_214_numbers_six_parameters_as_the_command_s"] = time.perf_counter() - begin
    whole = fit_as_a_process(points)
    return found | {f"level_flights_whole_process_{time_of}": s for time_of, s in whole.items()}


def fit_as_a_process(points: FlightLog) -> dict[str, float]:
    """`propmap fit flight` from a table of level flights, as a whole process [s]."""
    pitch, _ = pitch_and_roll(points.up)
    rpm = points.rotor_speed * 30.0 / np.pi
    table = np.column_stack([points.speed, np.degrees(pitch), rpm])
    with tempfile.TemporaryDirectory() as folder:
        flights, vehicle = Path(folder) / "flights.csv", Path(folder) / "vehicle.toml"
        header = "speed_mps,pitch_deg,rpm_1,rpm_2,rpm_3,rpm_4"
        np.savetxt(flights, table, delimiter=",", header=header, comments="")
        rotors = [
            f'[[rotors]]\nposition = [{x}, {y}, 0.0]\nspin = "{spin}"\n' for x, y, spin in PLACES
        ]
        head = f'schema = 1\nname = "twin"\nframe = "flu"\nmass = {MASS}\npropeller = "apc-8x6e"\n'
        vehicle.write_text(head + "".join(rotors), encoding="utf-8")
        fitted = str(Path(folder) / "fit.toml")
        files = [str(flights), "--vehicle", str(vehicle), "-o", fitted]
        return whole_process(["fit", "flight", *files], 1)


def bundled(name: str) -> TunnelData:
    """Measured loads of the catalogue."""
    m = measurement(name)
    return TunnelData(m.name, m.omega, m.speed, m.beta, m.loads)


def published() -> list[dict[str, Any]]:
    """Fits of the APC 8x6E to published data, and each checked on all of the data.

    The oblique data are the closed-form blade-element model of the campaign of 2019.
    """
    model = Model(propmap.propeller("apc-8x6e"), first_guess())
    five = (*PAPER_FOUR, "zero_lift_angle")
    axial, oblique = bundled("uiuc-8x6e"), bundled("gill-dandrea-2019-8x6e-fit")
    cases = (
        (axial, PAPER_FOUR, ("thrust", "torque")),
        (axial, five, ("thrust", "torque")),
        (oblique, five, ("thrust", "torque")),
        (oblique, (*five, "drag_factor"), ("thrust", "torque", "drag")),
    )
    found = []
    for data, free, loads in cases:
        choice = Choice(free)
        fitted = fit(tunnel_rows(model, data, choice, loads=loads), choice)
        found_model = model_with(model, fitted.values)
        checks = {
            other.source: {
                load: {"relative_rms": c.all.relative_rms, "hover": c.all.hover_rms / c.all.rms}
                for load, c in compare_tunnel(found_model, other).items()
            }
            for other in (axial, oblique)
        }
        parameters = {n: float(v) for n, v in zip(free, fitted.x, strict=True)}
        found.append(
            {"data": data.source, "loads": list(loads), "parameters": parameters, "errors": checks}
        )
    return found


def _cluster() -> str | None:
    """What follows ``--cluster`` among the arguments."""
    return sys.argv[sys.argv.index("--cluster") + 1] if "--cluster" in sys.argv else None


PARTS: dict[str, Callable[[], Any]] = {
    "seconds": timing,
    "published": published,
    "noise_free": lambda: {name: noise_free(name, 11) for name in SETS},
    "coverage": lambda: coverages(_cluster()),
}


def main() -> None:
    """Measure, print and write all parts, or those that are named; the rest stays as filed."""
    given = [part for part in sys.argv[1:] if part not in ("--cluster", _cluster())]
    parts = given or list(PARTS)
    path = RESULTS / "identification.json"
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    for part in parts:
        found.setdefault("machines", {})[part] = machine()
        found[part] = PARTS[part]()
        print(part, json.dumps(found[part], indent=2))
        write_results(path.name, found)


if __name__ == "__main__":
    main()
