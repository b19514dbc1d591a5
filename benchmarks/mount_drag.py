"""What a mount in the slipstream explains of the drag of 2019: `make bench ONLY=mount_drag`.

The APC 8x6E, the polynomials of that campaign.  Section constants are fitted to thrust and torque,
then the area of the mount, or a factor on the drag, to the drag; or all of them together.  Writes
results/mount_drag.json.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

import propmap
from benchmarks.results_file import machine, write_results
from propmap.fit.fit import Fitted, Settings, fit
from propmap.fit.parameters import Choice
from propmap.fit.tunnel import TunnelData, first_guess, read_tunnel, rotor_with, tunnel_rows
from propmap.model.corrections import typical_area
from propmap.model.model import Model
from propmap.report.words import rise_by_motor
from propmap.typing import Floats

PROPELLER, DATA = "apc-8x6e", "gill-dandrea-2019-8x6e"
PHYSICS = ("pitt-peters",)
HELD = {"c_l2": 2.0}
CONSTANTS = ("c_l1", "c_d", "alpha_0", "zero_lift_angle", "c_d0")
LOADS = ("thrust", "torque", "drag")
EXPLAINED_BY = {
    "mount, k = 1": (1.0, ("mount_area",)),
    "mount, k = 2": (2.0, ("mount_area",)),
    "factor": (1.0, ("drag_factor",)),
    "mount, k = 2, and factor": (2.0, ("mount_area", "drag_factor")),
}
"""The share of the inflow at the mount, and what is free for the drag."""

SPEEDS = ((0.0, 5.0), (5.0, 9.0), (9.0, 15.0))
"""Bands of the residuals [m/s]."""

SETTINGS = Settings(starts=2, folds=0)


def fitted(
    data: TunnelData,
    free: Sequence[str],
    loads: Sequence[str],
    held: dict[str, float],
    wake: float | None = None,
) -> Fitted:
    """A fit of ``loads``; the model has a mount where its ``wake`` is given."""
    mount = () if wake is None else (f"mount-drag:area_m2=0,wake={wake}",)
    law = first_guess().with_corrections((*PHYSICS, *mount))
    model = Model(propmap.propeller(PROPELLER), law)
    choice = Choice(tuple(free), held)
    return fit(tunnel_rows(model, data, choice, loads=loads), choice, SETTINGS)


def told(found: Fitted, data: TunnelData) -> dict[str, Any]:
    """Values with intervals, relative errors by load, those of the drag by angle and speed."""
    names = found.rows.names
    pairs = {name: found.compared(k) for k, name in enumerate(names)}
    entry: dict[str, Any] = {
        "values": dict(zip(found.choice.free, found.x.tolist(), strict=True)),
        "intervals_95": {
            name: [float(found.uncertainty.low[k]), float(found.uncertainty.high[k])]
            for k, name in enumerate(found.choice.free)
        },
        "relative_rms": {name: relative_rms(*pair) for name, pair in pairs.items()},
    }
    if "drag" in pairs:
        rows = found.rows.point[found.rows.of_load(names.index("drag"))]
        angle, speed = np.round(np.degrees(data.beta[rows])), data.speed[rows]
        groups = {f"{beta:.0f} deg": angle == beta for beta in np.unique(angle) if beta > 0.0}
        groups |= {f"{a:g} to {b:g} m/s": (speed > a) & (speed <= b) for a, b in SPEEDS}
        entry["drag_by_group"] = {
            name: {
                "relative_rms": relative_rms(*(part[mine] for part in pairs["drag"])),
                "mean_ratio": float(
                    np.sum(pairs["drag"][0][mine]) / np.sum(pairs["drag"][1][mine])
                ),
            }
            for name, mine in groups.items()
        }
    return entry


def motor(found: Fitted, data: TunnelData) -> dict[str, float]:
    """By what share a motor in proportion to the propeller raises the drag at the data's points."""
    law = first_guess().with_corrections(PHYSICS)
    rotor = rotor_with(Model(propmap.propeller(PROPELLER), law), found.values, "standard")
    loads = rotor.loads(data.omega, data.speed, data.beta)
    rise = rise_by_motor(rotor, loads, data.speed, data.beta)
    low, median, high = np.nanpercentile(rise, [0.0, 50.0, 100.0]).tolist()
    area = typical_area(rotor.model.propeller.radius)
    return {"area_m2": area, "lowest": low, "median": median, "highest": high}


def relative_rms(modelled: Floats, measured: Floats) -> float:
    """Size of the error, over that of what was measured [-]."""
    return float(np.sqrt(np.mean((modelled - measured) ** 2) / np.mean(measured**2)))


def main() -> None:
    """Fit, write, print."""
    warnings.filterwarnings("ignore", "drag_factor is deprecated")  # the study is what it is for
    data = read_tunnel([DATA], propmap.propeller(PROPELLER), propmap.Air())
    first = fitted(data, CONSTANTS, LOADS[:2], HELD)
    held = HELD | dict(zip(CONSTANTS, first.x.tolist(), strict=True))
    found: dict[str, Any] = {
        "data": DATA,
        "corrections": list(PHYSICS),
        "held": HELD,
        "constants": told(first, data),
        "motor": motor(first, data),
        "afterwards": {},
        "together": {},
    }
    for name, (wake, free) in EXPLAINED_BY.items():
        after = fitted(data, free, LOADS[2:], held, wake)
        found["afterwards"][name] = told(after, data)
        every = fitted(data, (*CONSTANTS, *free), LOADS, HELD, wake)
        found["together"][name] = told(every, data)
    write_results("mount_drag.json", found | {"machine": machine()})
    print(json.dumps(found, indent=2))


if __name__ == "__main__":
    main()
