"""Compare the time of a load evaluation with other tools, at given numerical errors.

Usage: `make bench ONLY=peers`.  Writes results/peers.json.

The rotor is the APC 8x6E with the section constants ``paper-apc``.  At 6000 rpm, it hovers, climbs,
and flies at two oblique points at 10 m/s.  The points of the batch ``mixed`` are those of
`benchmarks.speed.oblique`, at 3000 to 10000 rpm.  propmap's model, its table and the C header of
the table are compared with WISDEM's CCBlade (`benchmarks.peer_ccblade`).  The time of RotorPy's
rotor model is listed, too.  This model has no blade geometry; its constants are fitted to the
table.  AeroSandbox is omitted: it computes the power of an actuator disk for a given thrust and has
no blades.

Errors are numerical errors of the thrust, divided by the static thrust at the same rotational
speed.  The reference of propmap is its accuracy ``fine``; the reference of CCBlade is CCBlade with
a much finer grid.  CCBlade is timed with the cheapest grid for each of two limits of the error:
propmap's largest error ("measured"), and 0.1 %, the limit of accuracy ``standard`` ("promised").
All oblique points share one grid per limit.  If no grid is sufficient, the most accurate grid is
used.  Times are medians of the wall time after a first call.  For the C header and
RotorPy, they are the smallest processor times, as in `benchmarks.table`.
"""

from __future__ import annotations

import importlib.metadata
import itertools
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

import propmap
from benchmarks.c_header import c_nanoseconds
from benchmarks.peer_ccblade import (
    CCBladePropeller,
    Grid,
    Point,
    choose,
    evaluate_seconds,
    ladder,
    largest,
    over_package,
    thrust_torque,
)
from benchmarks.results_file import machine, write_results
from benchmarks.speed import BATCH, RPM, median_seconds, oblique
from benchmarks.table import rotorpy_microseconds
from propmap.loads import FLOW
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.table import LoadTable, build_table
from propmap.typing import Floats

OMEGA = 6000.0 * RPM
CASES: dict[str, Point] = {
    "hover": (OMEGA, 0.0, 0.0),
    "axial": (OMEGA, 10.0, 0.0),
    "60 deg": (OMEGA, 10.0, float(np.radians(60.0))),
    "85 deg": (OMEGA, 10.0, float(np.radians(85.0))),
}
"""omega [rad/s], speed [m/s], beta [rad]."""

MIXED = "mixed"
SAMPLE = 8
"""Number of points of the mixed batch at which errors and the time of CCBlade are measured."""

STATIONS, SECTORS = (15, 30, 60, 90, 120, 180, 240), (4, 8, 16, 36)
AXIAL_GRIDS = [Grid(stations, 1) for stations in STATIONS]
TILTED_GRIDS = [Grid(*pair) for pair in itertools.product(STATIONS, SECTORS)]

BOUNDS = ("measured", "promised")
PROMISE = 1e-3
"""Largest error of the accuracy ``standard``, divided by the static thrust."""

CLIMB = (1.0, 5.0, 10.0)
"""Speeds of climb [m/s] at which the loads of CCBlade and propmap are compared."""

ENVELOPE: dict[str, Any] = {
    "omega": (3000.0 * RPM, 10000.0 * RPM),
    "speed": (0.0, 20.0),
    "beta": (0.0, 0.5 * np.pi),
}
TOLERANCE = 0.01
"""Tolerance of the table.  Its envelope contains the mixed batch, hover and climb."""

SINGLE = 200
"""Number of calls of the table in one measurement of time."""


def sample() -> tuple[list[str], list[Point]]:
    """Return names and points of all cases, followed by the first points of ``mixed``."""
    mixed = [tuple(map(float, p)) for p in np.stack(oblique(BATCH), axis=-1)[:SAMPLE]]
    return [*CASES, *[MIXED] * SAMPLE], [*CASES.values(), *mixed]  # type: ignore[list-item]


def repeated(point: Point) -> tuple[Floats, Floats, Floats]:
    """Return omega, speed and beta, (BATCH,) each, of a batch of equal points."""
    omega, speed, beta = (np.full(BATCH, x) for x in point)
    return omega, speed, beta


def by_name(names: list[str], errors: Floats) -> dict[str, float]:
    """Return the largest error of each case."""
    return {name: float(max(errors[k] for k, n in enumerate(names) if n == name)) for name in names}


def times(one: Rotor | LoadTable, calls: int, repeats: int) -> dict[str, dict[str, float]]:
    """Return times [us] of single calls and per point of batches, for each case.

    A measurement of single calls contains ``calls`` calls.
    """

    def single(point: Point) -> float:
        def loop() -> None:
            for _ in range(calls):
                one.loads(*point)

        return 1e6 * median_seconds(loop, repeats) / calls

    def batch(points: tuple[Floats, Floats, Floats]) -> float:
        return 1e6 * median_seconds(lambda: one.loads(*points), 5) / BATCH

    return {
        "single_us": {name: single(point) for name, point in CASES.items()},
        "batch_us": {name: batch(repeated(point)) for name, point in CASES.items()}
        | {MIXED: batch(oblique(BATCH))},
    }


def package(rotor: Rotor, table: LoadTable) -> dict[str, Any]:
    """Return times [us] and errors of model and table, and the static thrust [N] at each point."""
    names, points = sample()
    omega, speed, beta = np.array(points).T
    truth = Rotor(rotor.model, accuracy="fine").loads(omega, speed, beta).thrust
    static = rotor.loads(omega, 0.0, 0.0).thrust

    def error(one: Rotor | LoadTable) -> dict[str, float]:
        off = np.asarray(one.loads(omega, speed, beta).thrust) - truth
        return by_name(names, np.abs(off) / static)

    w, v, b = CASES["60 deg"]
    velocity = [v * np.sin(b), 0.0, v * np.cos(b)]
    slopes = median_seconds(lambda: table.gradient_at_velocity(w, velocity), 100)
    return {
        "static_thrust": static,
        "model": times(rotor, 20, 30)
        | {"error": error(rotor), "gradient_us": gradient_microseconds(rotor, (w, v, b))},
        "table": times(table, SINGLE, 15) | {"error": error(table), "gradient_us": 1e6 * slopes},
    }


def gradient_microseconds(rotor: Rotor, point: Point) -> float:
    """Return the time [us] of all loads and their derivatives by omega and velocity."""
    omega, speed, beta = point
    flow = (omega, speed * np.cos(beta), speed * np.sin(beta))
    return 1e6 * median_seconds(lambda: rotor.gradients(FLOW, *flow), 200)


def ccblade(rotor: Rotor, static: Floats, bounds: dict[str, float]) -> dict[str, Any]:
    """Return grids, errors and times [us] of CCBlade per error limit, and its loads in climb."""
    peer = CCBladePropeller(rotor)
    names, points = sample()
    found: dict[str, Any] = {"reynolds": peer.reynolds}
    found |= {bound: {"allowed_error": allowed} for bound, allowed in bounds.items()}
    for flow, grids in (("axial", AXIAL_GRIDS), ("tilted", TILTED_GRIDS)):
        mine = [
            k for k, n in enumerate(names) if n != "hover" and (n == "axial") == (flow == "axial")
        ]
        tried = ladder(peer, grids, [points[k] for k in mine], static[mine])
        found[f"{flow}_ladder"] = [
            grid._asdict() | {"largest_error": largest(off)} for grid, off in tried.items()
        ]
        for bound, allowed in bounds.items():
            grid, reached = choose(tried, allowed)
            taken: dict[str, list[float]] = {}
            for k in mine:
                seconds = evaluate_seconds(peer.model(grid, points[k][2]), points[k])
                taken.setdefault(names[k], []).append(1e6 * seconds)
            into = found[bound]
            into[flow] = {"grid": grid._asdict(), "reached": reached}
            into.setdefault("single_us", {}).update(
                {n: float(np.mean(t)) for n, t in taken.items()}
            )
            into.setdefault("error", {}).update(by_name([names[k] for k in mine], tried[grid]))
    for bound in bounds:
        grid = Grid(**found[bound]["tilted"]["grid"])
        model = peer.model(grid, CASES["60 deg"][2], derivatives=True)
        found[bound]["gradient_us"] = 1e6 * evaluate_seconds(model, CASES["60 deg"])
    hover, _ = thrust_torque(peer.model(AXIAL_GRIDS[-1], 0.0), CASES["hover"])
    found["hover_thrust"] = None if np.isnan(hover) else hover
    found["hover_note"] = "CCBlade returns zero loads if no air flows along the axis"
    climb = {speed: over_package(peer, AXIAL_GRIDS[-1], (OMEGA, speed, 0.0)) for speed in CLIMB}
    found["over_package_in_climb"] = climb
    return found


def ratios(mine: dict[str, Any], peer: dict[str, Any]) -> dict[str, float]:
    """Return CCBlade's time over propmap's.  A batch requires one call of CCBlade per point."""
    theirs = peer["single_us"]
    found = {}
    for way in ("model", "table"):
        for kind in ("single_us", "batch_us"):
            for name, ours in mine[way][kind].items():
                if name in theirs:
                    found[f"{way}_{kind.removesuffix('_us')}, {name}"] = theirs[name] / ours
        found[f"{way}_gradient, 60 deg"] = peer["gradient_us"] / mine[way]["gradient_us"]
    return found


def measure() -> dict[str, Any]:
    """Return all results."""
    place = machine()
    rotor = Rotor(Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")))
    table = build_table(rotor, **ENVELOPE, tolerance=TOLERANCE)
    mine = package(rotor, table)
    static = mine.pop("static_thrust")
    bounds = {"measured": max(mine["model"]["error"].values()), "promised": PROMISE}
    peer = ccblade(rotor, static, bounds)
    return {
        "machine": place,
        "versions": {name: importlib.metadata.version(name) for name in ("wisdem", "rotorpy")},
        "cases": CASES,
        "batch": BATCH,
        "sample_of_mixed": SAMPLE,
        "package": mine | {"table_tolerance": TOLERANCE, "c_header_ns": c_nanoseconds(table)},
        "ccblade": peer,
        "rotorpy_us_per_rotor": rotorpy_microseconds(table),
        "ccblade_over_package": {bound: ratios(mine, peer[bound]) for bound in bounds},
    }


def show(found: dict[str, Any]) -> None:
    """Print the results."""
    mine, peer = found["package"], found["ccblade"]
    columns = [*CASES, MIXED]
    table = Table(caption=f"mixed: {BATCH} oblique points; CCBlade: {SAMPLE} of them, one by one")
    table.add_column("what")
    for name in columns:
        table.add_column(name, justify="right")

    def row(what: str, figures: dict[str, float], form: str = ".4g") -> None:
        table.add_row(what, *(format(figures[n], form) if n in figures else "-" for n in columns))

    for way in ("model", "table"):
        row(f"{way}, one call [us]", mine[way]["single_us"])
        row(f"{way}, {BATCH} at once [us per point]", mine[way]["batch_us"])
        row(f"{way}, error", mine[way]["error"], ".1e")
    for bound in BOUNDS:
        row(f"CCBlade, {bound}, one call [us]", peer[bound]["single_us"])
        row(f"CCBlade, {bound}, error", peer[bound]["error"], ".1e")
        for kind in ("model_single", "model_batch"):
            over = found["ccblade_over_package"][bound]
            told = {n: over[f"{kind}, {n}"] for n in columns if f"{kind}, {n}" in over}
            row(f"CCBlade, {bound}, over {kind.replace('_', ', ')}", told, ".0f")
    console = Console(width=120)
    console.print(table)
    for bound, flow in itertools.product(BOUNDS, ("axial", "tilted")):
        chosen, allowed = peer[bound][flow], peer[bound]["allowed_error"]
        word = "within" if chosen["reached"] else "the most accurate grid, not within"
        print(f"CCBlade, {flow}: {chosen['grid']}, {word} an error of {allowed:.1e}")
    print(f"hover: {peer['hover_note']}")
    for speed, told in peer["over_package_in_climb"].items():
        print(f"CCBlade over model, climb at {speed} m/s: {told}")
    slopes = {way: mine[way] for way in ("model", "table")}
    slopes |= {f"CCBlade, {bound}": peer[bound] for bound in BOUNDS}
    for name, one in slopes.items():
        print(f"{name}, with derivatives, 60 deg: {one['gradient_us']:.4g} us")
    header, rotorpy = mine["c_header_ns"], found["rotorpy_us_per_rotor"]
    print("C header: " + (f"{header:.0f} ns per point" if header else "no gcc"))
    print("RotorPy's rotor: " + (f"{rotorpy:.2f} us" if rotorpy else "not installed"))


def main() -> None:
    """Measure, print, and write the results."""
    found = measure()
    show(found)
    print(write_results("peers.json", found))


if __name__ == "__main__":
    main()
