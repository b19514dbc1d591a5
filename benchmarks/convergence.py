"""Numerical errors of the loads: `make bench ONLY=convergence`.  Writes results/convergence.json.

There are three comparisons:

- Both accuracy settings with the stored loads of the independent reference in tests/oracle, for the
  three parameter sets of Table I on the APC 8x6E.
- ``standard`` with ``fine`` for the same parameter sets, at random points from climb to descent.
- ``standard`` with ``fine`` for random section laws on ten blades, from climb to edgewise flight.
  Points with the status "coarse" are counted separately.

Errors are relative to the static loads at the same rotational speed, as in the certificate of a
table: thrust (for T and D), torque (for tau), thrust times radius (for the rolling moment).  For a
blade that is stalled at rest, rho A (Omega R)^2 / 2 times the solidity replaces the thrust.
"""

from __future__ import annotations

import csv
import itertools
import time
from pathlib import Path
from typing import Any

import numpy as np

import propmap
from benchmarks.results_file import write_results
from propmap.loads import LOADS, error_scales
from propmap.model.model import Model
from propmap.results import Loads
from propmap.rotor import ACCURACIES, Rotor
from propmap.typing import Floats
from tests.other_laws import error_scales_of, other_flow, other_rotors

SEED = 2017
POINTS = 3000
RPM = np.pi / 30.0
ROTORS, POINTS_EACH = 60, 50
"""Number of random section laws, and of points for each law."""

SETS = ("paper-soft", "paper-stiff", "paper-apc")
BANDS = (0.0, 0.1, 0.2, 0.3, 0.5, 1.0, np.inf)
"""Edges of the bands of advance ratio V sin(beta)/(Omega R)."""

REFERENCE = Path(__file__).parents[1] / "tests" / "oracle" / "reference_loads.csv"


def random_flow() -> tuple[Floats, Floats, Floats]:
    """Return random omega [rad/s], v_axial and v_inplane [m/s], (POINTS,) each.

    The ranges are 2000 to 10000 rpm, 0 to 20 m/s and beta of 0 to 180 deg.
    """
    rng = np.random.default_rng(SEED)
    rpm, speed = rng.uniform(2000.0, 10000.0, POINTS), rng.uniform(0.0, 20.0, POINTS)
    beta = np.radians(rng.uniform(0.0, 180.0, POINTS))
    return rpm * RPM, speed * np.cos(beta), speed * np.sin(beta)


def at_flow(rotor: Rotor, omega: Floats, axial: Floats, inplane: Floats) -> Loads:
    """Return the loads (N,) at axial and in-plane components of the velocity."""
    return rotor.loads(omega, np.hypot(axial, inplane), np.arctan2(inplane, axial))


def by_name(found: Loads) -> dict[str, Floats]:
    """Return the loads by name, (N,) each."""
    return {name: np.asarray(getattr(found, name)) for name in LOADS}


def shares(found: Loads, truth: dict[str, Floats], scales: dict[str, Floats]) -> Floats:
    """Return the errors (loads, N) [-]: differences from ``truth`` divided by ``scales``."""
    loads = by_name(found)
    return np.array([np.abs((loads[k] - truth[k]) / scales[k]) for k in LOADS])


def summary(errors: Floats, advance: Floats) -> list[dict[str, Any]]:
    """Return largest error and 95th percentile by band of advance ratio, then for all points.

    ``errors`` are (loads, N).
    """
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


def against_fine(models: dict[str, Model]) -> dict[str, Any]:
    """Compare ``standard`` with ``fine`` at random points of all parameter sets."""
    flow = random_flow()
    omega, _, inplane = flow
    errors, advance = [], []
    for model in models.values():
        fine, tip = Rotor(model, accuracy="fine"), model.propeller.radius
        scales = error_scales(by_name(fine.loads(omega, 0.0, 0.0)), tip)
        errors.append(shares(at_flow(Rotor(model), *flow), by_name(at_flow(fine, *flow)), scales))
        advance.append(inplane / (omega * tip))
    return {"standard": summary(np.hstack(errors), np.concatenate(advance))}


def against_reference(models: dict[str, Model]) -> dict[str, Any]:
    """Compare each setting with the stored loads of the reference."""
    with REFERENCE.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    found: dict[str, list[Floats]] = {name: [] for name in ACCURACIES}
    advance = []
    for name, model in models.items():
        mine = [row for row in rows if row["set"] == name.removeprefix("paper-")]
        column = {k: np.array([float(row[k]) for row in mine]) for k in rows[0] if k != "set"}
        # Inflow that is uniform over azimuth causes neither side force nor pitching moment.
        truth = dict.fromkeys(LOADS, np.zeros(len(mine))) | column
        static = {load: column[f"static_{load}"] for load in ("thrust", "torque")}
        scales = error_scales(static, model.propeller.radius)
        flow = (column["rpm"] * RPM, column["v_axial"], column["v_inplane"])
        for accuracy in ACCURACIES:
            loads = at_flow(Rotor(model, accuracy=accuracy), *flow)
            found[accuracy].append(shares(loads, truth, scales))
        advance.append(flow[2] / (flow[0] * model.propeller.radius))
    everywhere = np.concatenate(advance)
    return {name: summary(np.hstack(parts), everywhere) for name, parts in found.items()}


def other_laws() -> dict[str, Any]:
    """Compare ``standard`` with ``fine`` for random section laws.

    Points with the status "coarse" are counted and excluded from the errors.
    """
    errors, advance, coarse = [], [], dict.fromkeys(ACCURACIES, 0)
    for k, one in enumerate(other_rotors(ROTORS, SEED)):
        model, flow = Model(one.propeller(), one.airfoil), other_flow(POINTS_EACH, SEED + k)
        found = {name: at_flow(Rotor(model, accuracy=name), *flow) for name in ACCURACIES}
        said = {name: np.asarray(loads.status == "coarse") for name, loads in found.items()}
        for name, which in said.items():
            coarse[name] += int(which.sum())
        kept = ~(said["standard"] | said["fine"])
        scales = error_scales_of(model, flow[0])
        errors.append(shares(found["standard"], by_name(found["fine"]), scales)[:, kept])
        advance.append((flow[2] / (flow[0] * model.propeller.radius))[kept])
    return {
        "rotors": ROTORS,
        "coarse": coarse,
        "against_fine": {"standard": summary(np.hstack(errors), np.concatenate(advance))},
    }


def table(title: str, found: dict[str, Any]) -> None:
    """Print errors in percent of the static load."""
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
    """Make the comparisons, print and write the results."""
    start = time.perf_counter()
    blade = propmap.propeller("apc-8x6e")
    models = {name: Model(blade, propmap.airfoil(name)) for name in SETS}
    found: dict[str, Any] = {
        "propmap": propmap.__version__,
        "unit": "share of the static load at the same rotational speed",
        "against_reference": against_reference(models),
        "against_fine": against_fine(models),
        "other_laws": other_laws(),
    }
    table("errors [% of static load] against the literal reference", found["against_reference"])
    table("errors [% of static load] against fine", found["against_fine"])
    others = found["other_laws"]
    table("the same for random section laws", others["against_fine"])
    print("and coarse: " + ", ".join(f"{n} of {name}" for name, n in others["coarse"].items()))
    print(f"{time.perf_counter() - start:.0f} s")
    print(write_results("convergence.json", found))


if __name__ == "__main__":
    main()
