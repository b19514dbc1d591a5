"""How accurate numerically: `make convergence`.  Writes results/convergence.json.

Two comparisons for the three parameter sets of Table I on the APC 8x6E: the settings against about
twice the nodes of "fine", at random points from climb to descent; and against the frozen loads of
the independent, literal reference in tests/oracle.  A third one for random section laws on ten
blades, from climb to edgewise flight, against twice the nodes of "fine" with stall followed
everywhere; there points with the status "coarse" are counted apart.

Errors are shares of the static thrust (T, D), torque (tau) or thrust times radius (rolling moment)
at the same rotational speed, as in a table's certificate; where the blade is stalled at rest, of
rho A (Omega R)^2 / 2 times the solidity in place of thrust.
"""

from __future__ import annotations

import csv
import dataclasses
import itertools
import time
from pathlib import Path
from typing import Any

import numpy as np

import propmap
from benchmarks.results_file import write_results
from propmap.engine.accuracy import ACCURACIES, Accuracy
from propmap.engine.evaluation import evaluate, prepare, tail_share
from propmap.engine.rotor_arrays import rotor_arrays
from propmap.loads import LOADS, error_scales
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.solve.rotor_loads import RotorLoads
from propmap.typing import Floats
from tests.other_laws import error_scales_of, other_flow, other_rotors

SEED = 2017
POINTS = 3000
RPM = np.pi / 30.0
ROTORS, POINTS_EACH = 60, 50
"""Random section laws, and points of each."""

SETS = ("paper-soft", "paper-stiff", "paper-apc")
BANDS = (0.0, 0.1, 0.2, 0.3, 0.5, 1.0, np.inf)
"""Edges of the bands of advance ratio V sin(beta)/(Omega R)."""

REFERENCE = Path(__file__).parents[1] / "tests" / "oracle" / "reference_loads.csv"


def dense() -> Accuracy:
    """About twice the nodes of "fine" in either direction."""
    fine = ACCURACIES["fine"]
    azimuths = tuple((limit, 2 * count) for limit, count in fine.azimuths)
    return dataclasses.replace(
        fine,
        azimuths=azimuths,
        free=2 * fine.free,
        stalled=2 * fine.stalled,
        fast=2 * fine.fast,
        largest_tail=0.5 * fine.largest_tail,
        finer=tuple((2 * nodes, 0.5 * limit) for nodes, limit in fine.finer),
    )


def random_flow() -> tuple[Floats, Floats, Floats]:
    """omega [rad/s], v_axial, v_inplane [m/s], (POINTS,): 2000-10000 rpm, 0-20 m/s, 0-180 deg."""
    rng = np.random.default_rng(SEED)
    rpm, speed = rng.uniform(2000.0, 10000.0, POINTS), rng.uniform(0.0, 20.0, POINTS)
    beta = np.radians(rng.uniform(0.0, 180.0, POINTS))
    return rpm * RPM, speed * np.cos(beta), speed * np.sin(beta)


def shares(found: RotorLoads, truth: dict[str, Floats], scales: dict[str, Floats]) -> Floats:
    """Errors (loads, N) [-] against a ``truth``, as shares of ``scales``, (N,) each."""
    loads = found.loads._asdict()
    return np.array([np.abs((loads[k] - truth[k]) / scales[k]) for k in LOADS])


def summary(errors: Floats, advance: Floats) -> list[dict[str, Any]]:
    """Largest error and 95th percentile by band, all points last; errors (loads, N)."""
    rows = []
    for low, high in [*itertools.pairwise(BANDS), (BANDS[0], BANDS[-1])]:
        mine = (advance >= low) & (advance < high)
        if not mine.any():
            continue
        row: dict[str, Any] = {
            "advance_ratio": [low, None if np.isinf(high) else high],
            "points": int(mine.sum()),
        }
        for load, values in zip(LOADS, errors[:, mine], strict=True):
            row[load] = {
                "largest": float(values.max()),
                "percentile_95": float(np.percentile(values, 95)),
            }
        rows.append(row)
    return rows


def against_dense(rotors: dict[str, Rotor]) -> dict[str, Any]:
    """Each setting against the dense one at random points, all sets together."""
    omega, axial, inplane = random_flow()
    tip = next(iter(rotors.values())).model.propeller.radius
    still = np.zeros_like(omega)
    found: dict[str, list[Floats]] = {name: [] for name in ACCURACIES}
    for rotor in rotors.values():
        reference = evaluate(prepare(rotor.arrays), dense(), omega, axial, inplane)
        hover = evaluate(prepare(rotor.arrays), ACCURACIES["fine"], omega, still, still)
        truth, scales = reference.loads._asdict(), error_scales(hover.loads._asdict(), tip)
        for name, setting in ACCURACIES.items():
            loads = evaluate(prepare(rotor.arrays), setting, omega, axial, inplane)
            found[name].append(shares(loads, truth, scales))
    advance = np.tile(inplane / (omega * tip), len(rotors))
    return {name: summary(np.hstack(parts), advance) for name, parts in found.items()}


def against_reference(rotors: dict[str, Rotor]) -> dict[str, Any]:
    """Each setting against the frozen loads of the literal reference."""
    with REFERENCE.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    found: dict[str, list[Floats]] = {name: [] for name in ACCURACIES}
    advance = []
    for name, rotor in rotors.items():
        mine = [row for row in rows if row["set"] == name.removeprefix("paper-")]
        column = {k: np.array([float(row[k]) for row in mine]) for k in rows[0] if k != "set"}
        static = {load: column[f"static_{load}"] for load in ("thrust", "torque")}
        scales = error_scales(static, rotor.model.propeller.radius)
        flow = (column["rpm"] * RPM, column["v_axial"], column["v_inplane"])
        for accuracy, setting in ACCURACIES.items():
            loads = evaluate(prepare(rotor.arrays), setting, *flow)
            found[accuracy].append(shares(loads, column, scales))
        advance.append(flow[2] / (flow[0] * rotor.model.propeller.radius))
    everywhere = np.concatenate(advance)
    return {name: summary(np.hstack(parts), everywhere) for name, parts in found.items()}


def other_laws() -> dict[str, Any]:
    """Each setting at random points of random section laws; "coarse" points count apart."""
    # No tail is small enough: all points are evaluated again, and there stall is followed.
    truth_setting = dataclasses.replace(dense(), largest_tail=0.0)
    errors: dict[str, list[Floats]] = {name: [] for name in ACCURACIES}
    coarse = dict.fromkeys(ACCURACIES, 0)
    advance: dict[str, list[Floats]] = {name: [] for name in ACCURACIES}
    for k, one in enumerate(other_rotors(ROTORS, SEED)):
        model = Model(one.resampled(), one.airfoil)
        rotor, flow = prepare(rotor_arrays(model)), other_flow(POINTS_EACH, SEED + k)
        truth = evaluate(rotor, truth_setting, *flow).loads._asdict()
        scales = error_scales_of(model, flow[0])
        for name, setting in ACCURACIES.items():
            found = evaluate(rotor, setting, *flow)
            said = tail_share(rotor, *flow, found) > setting.finer[-1][1]
            coarse[name] += int(said.sum())
            errors[name].append(shares(found, truth, scales)[:, ~said])
            advance[name].append((flow[2] / (flow[0] * model.propeller.radius))[~said])
    return {
        "rotors": ROTORS,
        "coarse": coarse,
        "against_twice_fine": {
            name: summary(np.hstack(errors[name]), np.concatenate(advance[name]))
            for name in ACCURACIES
        },
    }


def table(title: str, found: dict[str, Any]) -> None:
    """Print errors in per cent of the static load."""
    print(title)
    print(f"{'setting':9} {'advance ratio':>13} {'points':>6}", end="")
    print("".join(f"{load + ' 95 %':>17}{'largest':>10}" for load in LOADS))
    for name, rows in found.items():
        for row in rows:
            low, high = row["advance_ratio"]
            band = f"{low:g}-" + ("" if high is None else f"{high:g}")
            print(f"{name:9} {band:>13} {row['points']:>6}", end="")
            print(
                "".join(
                    f"{100.0 * row[k]['percentile_95']:17.5f}{100.0 * row[k]['largest']:10.5f}"
                    for k in LOADS
                )
            )


def main() -> None:
    """Compare, print, and write the results."""
    start = time.perf_counter()
    blade = propmap.propeller("apc-8x6e")
    rotors = {name: Rotor(Model(blade, propmap.airfoil(name))) for name in SETS}
    found: dict[str, Any] = {
        "propmap": propmap.__version__,
        "unit": "share of the static load at the same rotational speed",
        "against_reference": against_reference(rotors),
        "against_twice_fine": against_dense(rotors),
        "other_laws": other_laws(),
    }
    table("errors [% of static load] against the literal reference", found["against_reference"])
    table("errors [% of static load] against twice fine's nodes", found["against_twice_fine"])
    others = found["other_laws"]
    table("the same for random section laws", others["against_twice_fine"])
    print("and coarse: " + ", ".join(f"{n} of {name}" for name, n in others["coarse"].items()))
    print(f"{time.perf_counter() - start:.0f} s")
    print(write_results("convergence.json", found))


if __name__ == "__main__":
    main()
