"""Disturb the dynamic inflow in random flight states, and compare the final with the static loads.

Usage: python -m tools.disturbed_inflow [NAME...]

For each propeller or parameter set, 1,000 runs of 10 s start from the steady state plus random
disturbances of all states.  The runs are hover, climb, descent through the vortex ring, edgewise
and oblique flight, with steps of 0.5 to 50 ms.  Every step rounds the state to single precision.
The tool prints the runs with NaN, the largest inflow over that of the steady state, and the errors
of the final thrust, relative to the static thrust at rest, with and without stall.
"""

from __future__ import annotations

import sys

import numpy as np

import propmap
from propmap.typing import Floats

NAMES = ("APC 8x6E", "HQ 5x4.3x3", "10x4.5", "paper-stiff", "paper-apc")
RUNS, SECONDS, STEPS = 1000, 10.0, (5e-4, 2e-3, 5e-3, 2e-2, 5e-2)
SAME_BRANCH = 3e-3  # largest error of thrust on the same branch, over the static thrust at rest


def flights(rotor: propmap.Rotor, random: np.random.Generator) -> tuple[Floats, Floats]:
    """Return omega (n,) [rad/s] and velocity (n, 3) [m/s] of random flight states."""
    count = RUNS // len(STEPS)
    tip = rotor.model.propeller.radius
    omega = 60.0 / tip * random.uniform(0.5, 1.5, count)
    hover = rotor.hover_inflow(omega)
    kind = np.arange(count) % 5
    axial = hover * np.choose(
        kind,
        [
            np.zeros(count),
            random.uniform(0.0, 1.0, count),
            random.uniform(-2.5, 0.0, count),
            random.uniform(-0.2, 0.2, count),
            random.uniform(-1.0, 1.0, count),
        ],
    )
    share = np.choose(kind, [0.0, 0.0, 0.0, 0.25, 0.1]) * random.uniform(0.0, 1.0, count)
    inplane = share * omega * tip
    heading = random.uniform(0.0, 2.0 * np.pi, count)
    return omega, np.stack([inplane * np.cos(heading), inplane * np.sin(heading), axial], axis=-1)


def main(*names: str) -> None:
    """Run all propellers and print one line for each."""
    print(
        "rotor, states: NaN; inflow over steady; final error without stall; stalled: share on the"
    )
    print("same branch, error there, largest error")
    for name in names or NAMES:
        random = np.random.default_rng(57)
        model = (
            propmap.Model(
                propmap.propeller("apc-8x6e"),
                propmap.airfoil(name),
                corrections=(propmap.correction("pitt-peters"),),
            )
            if name.startswith("paper")
            else propmap.catalogue_model(name)
        )
        rotor = propmap.Rotor(model)
        inflow = propmap.DynamicInflow(rotor)
        lost, largest, errors, stalls = 0, 0.0, [], []
        for dt in STEPS:
            omega, velocity = flights(rotor, random)
            steady = inflow.steady(omega, velocity)
            scale = rotor.hover_inflow(omega)[:, None]
            state = steady + scale * random.standard_normal(steady.shape)
            most = abs(state).max(axis=1)
            for _ in range(round(SECONDS / dt)):
                state = inflow.step(state.astype(np.float32), dt, omega, velocity)
                most = np.fmax(most, abs(state).max(axis=1))
            lost += int(np.isnan(state).any(axis=1).sum())
            largest = max(
                largest, float((most / np.maximum(abs(steady).max(axis=1), scale[:, 0])).max())
            )
            # The last states without rounding.
            for _ in range(40):
                state = inflow.step(state, 0.05, omega, velocity)
            found, want = (inflow.loads(x, omega, velocity).thrust for x in (state, steady))
            at_rest = abs(rotor.loads(omega, 0.0, 0.0).thrust)
            errors.append(abs(found - want) / at_rest)
            stalls.append(rotor.loads_at_velocity(omega, velocity).roots > 1)
        error, several = np.concatenate(errors), np.concatenate(stalls)
        line = (
            f"{name}, {inflow.size}: {lost}; {largest:.2f}; {error[~several].max(initial=0.0):.1e}"
        )
        if several.any():
            same = error[several] < SAME_BRANCH
            ends = error[several][same].max(initial=0.0), error[several].max()
            line += f"; {several.sum()} runs: {same.mean():.0%}, {ends[0]:.1e}, {ends[1]:.1e}"
        print(line, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
