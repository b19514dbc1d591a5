"""Print the errors of predicted flight loads before and after a fit to static rows alone.

Usage: python -m tools.after_static LOADS [N]

LOADS is the loads.csv of the UIUC database.  The tool fits all propellers with static rows and a
measured blade, or N random propellers, like ``propmap fit static``, without their own constants in
the catalogue.  It then predicts their other rows with at least a fifth of the static thrust.
Errors are rms over the rms of the measured values; coverage is the fraction of rows inside the
95 % intervals.  Without N, the results go into benchmarks/results/after_static.json.
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from propmap import catalogue
from propmap.catalogue.expected import airfoil_at, expected_prior
from propmap.catalogue.identified import PARAMETERS, Identified, all_identified, one_of_each
from propmap.fit.comparison import MODEL_ERROR
from propmap.fit.fit import Settings, fit
from propmap.fit.parameters import Choice, SectionPrior
from propmap.fit.tunnel import TunnelData, rotor_with, tunnel_rows
from propmap.io.csv import replacing
from propmap.loads import LOADS
from propmap.model.model import Model
from propmap.typing import Floats
from tools.catalogue.database import MeasuredPropeller, read_uiuc_database, refiled

RESULTS = Path(__file__).resolve().parent.parent / "benchmarks" / "results" / "after_static.json"
TOLD = ("thrust", "torque")
FEW, SMALL, SEED = 5, 0.2, 1


class Predicted(NamedTuple):
    """Relative errors and coverage of one propeller in flight, (2,) each: thrust, torque."""

    errors: Floats
    coverage: Floats


def predicted(one: Identified, tested: MeasuredPropeller) -> tuple[Predicted, Predicted]:
    """Return the predictions before and after the fit to static rows."""
    blade = replace(catalogue.load(one.propeller), blades=one.blades)
    distribution = expected_prior(one.family, one.size, one.geometry, without=one.tested)
    law = airfoil_at(distribution.mean, "expected", "")
    model = Model(blade, law.with_corrections(["pitt-peters"]))
    turns, diameter = tested.rpm / 60.0, blade.diameter
    force = model.air.density * turns**2 * diameter**4
    size = np.stack([force, force * diameter / (2.0 * np.pi)])
    measured = np.stack([tested.thrust, tested.power]) * size
    omega, speed, still = 2.0 * np.pi * turns, tested.advance * turns * diameter, 0.0 * turns
    rest = tested.advance == 0.0
    loads = dict(zip(TOLD, measured[:, rest], strict=True))
    data = TunnelData(one.tested, omega[rest], still[rest], still[rest], loads)
    start = {name: getattr(law, name) for name in PARAMETERS}
    choice = Choice(
        PARAMETERS,
        start=start,
        expected=SectionPrior(distribution, law, ""),
    )
    fitted = fit(tunnel_rows(model, data, choice), choice, Settings(starts=1, folds=0))
    level = np.median((measured / size)[:, rest], axis=1)[:, None] * size
    flying = ~rest & (measured[0] > SMALL * level[0])
    wanted, level = measured[:, flying], level[:, flying]
    rows = [list(LOADS).index(name) for name in TOLD]

    def compared(x: Floats, covariance: Floats) -> Predicted:
        rotor = rotor_with(model, choice.values(x), "standard")
        found = rotor.gradients(PARAMETERS, omega[flying], speed[flying], still[flying])
        slopes, error = found.slopes[rows], found.loads[rows] - wanted
        variance = np.einsum("lpn,pq,lqn->ln", slopes, covariance, slopes)
        deviation = np.sqrt(variance + (MODEL_ERROR * level) ** 2)
        relative = np.sqrt(np.nanmean(error**2, axis=1) / np.mean(wanted**2, axis=1))
        return Predicted(relative, np.mean(np.abs(error) < 1.96 * deviation, axis=1))

    by_prior = np.linalg.inv(choice.prior_residuals(choice.first)[1])
    before = compared(choice.first, by_prior @ by_prior.T)
    return before, compared(fitted.x, fitted.uncertainty.covariance)


def main(loads: Path, count: int | None) -> None:
    """Print and store median errors and mean coverage over the propellers."""
    every = {tested.name: tested for tested in refiled(read_uiuc_database(loads))}
    chosen = [one for one in one_of_each(all_identified()) if FEW <= one.static_rows < one.rows]
    if count is not None:
        some = np.random.default_rng(SEED).permutation(len(chosen))[:count]
        chosen = [chosen[k] for k in some]
    found = [predicted(one, every[one.tested]) for one in chosen]
    print(f"{len(found)} propellers        thrust  torque")
    results: dict[str, object] = {"propellers": len(found)}
    for when, sides in zip(("before", "after"), zip(*found, strict=True), strict=True):
        half = np.median([one.errors for one in sides], axis=0)
        held = np.mean([one.coverage for one in sides], axis=0)
        print(f"median error, {when:<9} {half[0]:8.1%}{half[1]:8.1%}")
        print(f"inside 95 %, {when:<10} {held[0]:8.1%}{held[1]:8.1%}")
        results[when] = {"error": np.round(half, 4).tolist(), "held": np.round(held, 4).tolist()}
    if count is None:
        with replacing(RESULTS) as path:
            path.write_text(json.dumps(results, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) == 3 else None)
