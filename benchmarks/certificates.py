"""Whether what certificates state holds on points that nobody chose: `make bench-certificates`.

Five tables of different propellers, section laws, envelopes and tolerances.  On each, the loads of
fresh points, with a seed that the builder does not use, are compared with the model, and their
largest errors with those that the certificate states, by load: in the envelope, and apart in the
cells that are told to be unresolved.
Writes results/certificates.json; with names of tables, these alone, and keeps the others.
"""

from __future__ import annotations

import json
import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

import propmap
from benchmarks.options import sampled
from benchmarks.results_file import RESULTS, machine, write_results
from propmap.loads import LOADS
from propmap.model.airfoil import parameter_set
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.table import LoadTable, build_table
from propmap.table.build import CachedModel
from propmap.table.certificate import compare
from propmap.table.interpolation import UNRESOLVED

RPM = np.pi / 30.0
FRESH, SEED = 100_000, 26
MOST = 1.1
"""Largest fresh error over the stated one."""

IGNORED = 1e-6
"""Share of static loads below which an error is the rounding of a load that is zero."""


@dataclass(frozen=True)
class Case:
    """A model, its envelope in rpm, m/s and degrees, and the table's tolerance."""

    model: Model
    rpm: tuple[float, float]
    speed: tuple[float, float]
    beta_deg: tuple[float, float]
    tolerance: float


def cases() -> dict[str, Case]:
    """What is built; the first is the README's table."""
    inflow = (propmap.correction("pitt-peters"),)
    cambered = parameter_set("paper-stiff").with_parameters(zero_lift_angle=-0.06)
    propeller, law = propmap.propeller, parameter_set
    return {
        "8x6E, climb to edgewise": Case(
            Model(propeller("apc-8x6e"), law("paper-apc")), (3000, 9000), (0, 15), (0, 90), 0.01
        ),
        "8x6E, all angles": Case(
            Model(propeller("apc-8x6e"), law("paper-apc")), (2000, 10000), (0, 20), (0, 180), 0.005
        ),
        "11x7E, cambered, all angles": Case(
            Model(propeller("apc-11x7e"), cambered), (2000, 7000), (0, 12), (0, 180), 0.01
        ),
        "8x4.5MR, Pitt and Peters": Case(
            Model(propeller("apc-8x4.5mr"), law("paper-soft"), corrections=inflow),
            (3000, 9000),
            (0, 12),
            (0, 120),
            0.01,
        ),
        # A table is linear in omega^(-1/2), as friction is; drag linear in ln Re is so nearly.
        "slow flyer 10x4.7, section table": Case(
            Model(propeller("uiuc-apcsf-10x4.7"), sampled("paper-stiff", (2e4, 1e5))),
            (5000, 7000),
            (0, 10),
            (0, 90),
            0.01,
        ),
    }


def ratios(errors: np.ndarray, stated: dict[str, float]) -> dict[str, float]:
    """Largest of the errors (n, L) over that stated, by load; 0 for a load that is always zero."""
    largest = dict(zip(LOADS, np.abs(errors).max(axis=0, initial=0.0), strict=True))
    return {
        load: float(size / stated[load]) if max(size, stated[load]) > IGNORED else 0.0
        for load, size in largest.items()
    }


def fresh_points(table: LoadTable) -> np.ndarray:
    """omega [rad/s], speed [m/s], beta [rad] all over the envelope, (3, FRESH)."""
    low, high = np.array(list(table.envelope.values())).T
    unit = np.random.default_rng(SEED).random((FRESH, 3))
    return np.asarray((low + (high - low) * unit).T)


def measured(case: Case) -> dict[str, Any]:
    """What a case's table states, and the ratios of the fresh points' errors to it."""
    rotor = Rotor(case.model)
    start = time.process_time()
    table = build_table(
        rotor,
        omega=(RPM * case.rpm[0], RPM * case.rpm[1]),
        speed=case.speed,
        beta=(np.radians(case.beta_deg[0]), np.radians(case.beta_deg[1])),
        tolerance=case.tolerance,
    )
    seconds = time.process_time() - start
    model = CachedModel(rotor, table.content.omega)
    found = compare(table, model, *fresh_points(table))
    loose, told = found.code == UNRESOLVED, table.certificate
    return {
        "tolerance": case.tolerance,
        "knots": [table.content.advance.size, table.content.beta.size],
        "processor_s": seconds,
        "model_evaluations": table.info["model_evaluations"],
        "certificate": told,
        "fresh_points": FRESH,
        "fresh_unresolved": int((loose & ~found.lost).sum()),
        "fresh_without_loads": int(found.lost.sum()),
        "fresh_over_stated": ratios(found.errors[~found.lost & ~loose], told["max_error"]),
        "unresolved_fresh_over_stated": ratios(
            found.errors[~found.lost & loose], told["unresolved_max_error"]
        ),
    }


def show(name: str, found: dict[str, Any]) -> None:
    """Print the figures of a case."""
    told = found["certificate"]
    print(
        f"{name}, {found['tolerance']:.1%}: {found['knots'][0]} x {found['knots'][1]} knots, "
        f"{found['model_evaluations']} operating points, processor {found['processor_s']:.1f} s"
    )
    print(
        f"  stated {max(told['max_error'].values()):.3%} by a search of {told['search_points']} "
        f"points; unresolved {told['unresolved_volume']:.3%}, there "
        f"{max(told['unresolved_max_error'].values()):.2%}"
    )
    for what in ("fresh_over_stated", "unresolved_fresh_over_stated"):
        shown = ", ".join(f"{load} {ratio:.3f}" for load, ratio in found[what].items() if ratio)
        print(f"  {what.replace('_', ' ')}: {shown or 'none'}", flush=True)


def main() -> None:
    """Measure, print and write; with names of cases, these anew beside what is written already.

    Exits with a message where a ratio is above ``MOST``.
    """
    names = sys.argv[1:] or list(cases())
    for name in names:
        found = {"machine": machine(), **measured(cases()[name])}
        show(name, found)
        path = RESULTS / "certificates.json"
        known = json.loads(path.read_text(encoding="utf-8"))["tables"] if path.exists() else {}
        tables = known | {name: found}
        ordered = {name: tables[name] for name in cases() if name in tables}
        print(write_results("certificates.json", {"most": MOST, "tables": ordered}), flush=True)
    worst = max(max(ordered[name]["fresh_over_stated"].values()) for name in names)
    if worst > MOST:
        raise SystemExit(f"a fresh point is {worst:.2f} times as far off as was stated")


if __name__ == "__main__":
    main()
