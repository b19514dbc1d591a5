"""Twin experiments of fits of all forces and moments: `make bench ONLY=flight_twins`.

Two flights of half a minute each are simulated with known parameters: section constants, position
of the accelerometer, gains of wakes, thrust scales.  These parameters are identified once without
noise and a hundred times with correlated noise.  The noisy fits start at the truth.  The benchmark
counts how often the 95 % intervals contain the truth.  For comparison, it also counts this for
intervals that assume independent rows.  Writes results/flight_twins.json.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from benchmarks.results_file import machine, write_results
from propmap.fit.fit import Fitted, Settings, fit
from propmap.fit.parameters import Choice, Prior, described
from propmap.typing import Floats
from tests.fit.flight_twin import BEFOREHAND, FIXED, FREE, TRUTH, Noise, Twin

Bools = NDArray[np.bool_]
REPETITIONS = 100
ONCE = Settings(starts=1, folds=0)


def noise_free(twin: Twin) -> dict[str, Any]:
    """Identify the parameters without noise, from a start with a wrong lift slope."""
    priors = {name: Prior(TRUTH[name], deviation) for name, deviation in BEFOREHAND.items()}
    choice = Choice(FREE, FIXED, priors, start={"c_l1": 5.0})
    exact = replace(twin.rows, measured=twin.measured(TRUTH))
    found = fit(exact, choice, ONCE)
    return {
        name: {
            "truth": TRUTH[name],
            "found": float(found.x[k]),
            "relative_error": float(found.x[k] / TRUTH[name] - 1.0),
        }
        for k, name in enumerate(FREE)
    }


def as_if_independent(found: Fitted) -> tuple[Floats, Floats]:
    """Return the ends of the 95 % intervals under the assumption of independent rows."""
    slopes, residual = found.minimum.slopes, found.minimum.residual
    variance = float(residual @ residual) / (residual.size - found.x.size)
    by_prior = np.sqrt(variance) * found.choice.prior_residuals(found.x)[1]
    information = slopes.T @ slopes + by_prior.T @ by_prior
    deviation = np.sqrt(variance * np.diag(np.linalg.inv(information)))
    half = float(stdtrit(residual.size - found.x.size, 0.975)) * deviation
    return found.x - half, found.x + half


def coverage(twin: Twin, noise: Noise) -> Iterator[dict[str, Any]]:
    """Fit the noisy twins; after each fit, yield the coverage of the intervals by parameter."""
    shape = REPETITIONS, len(FREE)
    inside, alone, good = np.zeros((3, *shape), bool)
    width, off = np.zeros((2, *shape))
    for k in range(REPETITIONS):
        begin = time.process_time()
        rows, choice, truth = twin.noisy(k, noise)
        found = fit(rows, choice, ONCE)
        wanted = np.array([truth[name] for name in FREE])
        sure = found.uncertainty
        inside[k] = (sure.low <= wanted) & (wanted <= sure.high)
        low, high = as_if_independent(found)
        alone[k] = (low <= wanted) & (wanted <= high)
        good[k] = sure.identified
        width[k] = sure.high - sure.low
        off[k] = (found.x - wanted) / np.sqrt(np.diag(sure.covariance))
        took = time.process_time() - begin
        print(k, f"{inside[k].sum()} of {len(FREE)}, {took:.1f} s", flush=True)
        done = slice(k + 1)
        yield told(inside[done], alone[done], good[done], width[done], off[done])


def told(inside: Bools, alone: Bools, good: Bools, width: Floats, off: Floats) -> dict[str, Any]:
    """Return coverage, width and spread by parameter.

    The arguments have one row per twin and one column per parameter.
    """
    return {
        name: {
            "called_identified": int(good[:, k].sum()),
            "of_these_truth_inside": float(inside[good[:, k], k].mean())
            if good[:, k].any()
            else None,
            "of_all_truth_inside": float(inside[:, k].mean()),
            "if_rows_were_independent": float(alone[:, k].mean()),
            "median_width": float(np.median(width[:, k])),
            "spread_of_z": float(off[:, k].std()),
            "unit": described(name).unit,
        }
        for k, name in enumerate(FREE)
    }


def main() -> None:
    """Fit the twins, print and write the results; any argument skips the noisy twins."""
    begin = time.process_time()
    twin, noise = Twin(), Noise()
    found: dict[str, Any] = {"machine": machine()}
    found["rows"] = int(twin.rows.measured.size)
    found["stretches"] = int(np.unique(twin.log.segments(1.0)).size)
    found["noise"] = {"white": noise.white, "alike": noise.alike, "lasting_s": noise.lasting}
    found["noise_free"] = noise_free(twin)
    print(json.dumps(found, indent=1), flush=True)
    if len(sys.argv) > 1:
        return
    for count, found["coverage"] in enumerate(coverage(twin, noise), start=1):
        found["repetitions"] = count
        found["processor_s"] = round(time.process_time() - begin, 1)
        # Results are written after each twin, because all twins take about ten minutes.
        write_results("flight_twins.json", found)
    print(json.dumps(found["coverage"], indent=1))


if __name__ == "__main__":
    main()
