"""Compare the final thrust of a disturbed dynamic inflow with the thrust of the steady state.

Usage: python -m tools.disturbed_inflow [NAME...]

For each propeller or parameter set, 1,000 runs of 10 s start from the steady state plus random
disturbances of all states.  The flight states are hover, climb, descent through the vortex ring,
edgewise and oblique flight.  The steps are 0.5 to 50 ms long.  Every step rounds the state to
single precision.  The tool prints a line for each rotor, with the columns of HEADER.
"""

from __future__ import annotations

import sys

import numpy as np

import propmap
from propmap.typing import Floats

NAMES = ("APC 8x6E", "HQ 5x4.3x3", "10x4.5", "paper-stiff", "paper-apc")
RUNS, SECONDS, STEPS = 1000, 10.0, (5e-4, 2e-3, 5e-3, 2e-2, 5e-2)
SAME_BRANCH = 3e-3  # largest error of thrust on the same branch, over the static thrust

HEADER = """Columns; errors are errors of the final thrust, over the static thrust:
1. rotor
2. number of values in a state
3. number of runs with NaN
4. largest inflow of all runs, over the steady inflow or the hover inflow, whichever is larger
5. largest error of runs in which eq. (11) has one solution at all radii (accuracy "fine")
All other runs, if there are any:
6. number of runs
7. fraction of runs that end on the branch of the steady solution
8. largest error on this branch
9. largest error of all these runs
"""


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
    """Run the simulations of all propellers and print a line for each propeller."""
    print(HEADER)
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
        rotor, fine = propmap.Rotor(model), propmap.Rotor(model, accuracy="fine")
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
            # Further steps without rounding remove the rounding errors from the final state.
            for _ in range(40):
                state = inflow.step(state, 0.05, omega, velocity)
            found, want = (inflow.loads(x, omega, velocity).thrust for x in (state, steady))
            at_rest = abs(rotor.loads(omega, 0.0, 0.0).thrust)
            errors.append(abs(found - want) / at_rest)
            stalls.append(fine.loads_at_velocity(omega, velocity).roots > 1)
        error, several = np.concatenate(errors), np.concatenate(stalls)
        line = (
            f"{name}; {inflow.size}; {lost}; {largest:.2f}; {error[~several].max(initial=0.0):.1e}"
        )
        if several.any():
            same = error[several] < SAME_BRANCH
            ends = error[several][same].max(initial=0.0), error[several].max()
            line += f"; {several.sum()}; {same.mean():.0%}; {ends[0]:.1e}; {ends[1]:.1e}"
        print(line, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
