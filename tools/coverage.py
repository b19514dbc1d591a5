"""Print the coverage of the bands by measurements, and the numbers for ``propmap.bands``.

Usage: python -m tools.coverage DATA

DATA is the folder of reference data.  Axial flow: each propeller of the UIUC database with a
measured blade; the middle and the fastest run, each held out of the identification.  Oblique flow:
catalogue predictions of the APC 8x6E and of the in-plane force of 20 propellers (2019 campaign),
and of a 10x4.7 Slow Flyer (second tunnel).  Rows with "held out" use the shares of the other
campaign alone.  In the second tunnel the axes of the moments are inferred and tares are included.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import numpy as np
from scipy.optimize import brentq

import propmap
from propmap import bands, catalogue
from propmap.catalogue.identified import PARAMETERS, all_identified, one_of_each
from propmap.model import corrections
from propmap.model.air import Air
from propmap.model.airfoil import SectionCovariance, SectionUncertainty
from propmap.model.corrections import Installed
from propmap.model.model import Model
from propmap.results import Loads
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import RPM
from tools.catalogue.database import read_uiuc_database, refiled, with_rows
from tools.catalogue.identification import AxialTest, airfoil_of, identify

SHARES = (0.50, 0.80, 0.95)
LOADS = ("thrust", "torque", "drag", "roll_moment", "side_force", "pitch_moment")
NEAR_REST = 0.02
"""Minimum advance ratio of a row in oblique flow."""

ADVANCE = np.linspace(0.05, 0.25, 5)
"""Advance ratios of the compared in-plane forces, from the 2019 campaign."""

TIP_SPEED = 84.0  # [m/s], about the middle of the 2019 campaign


class Campaign(NamedTuple):
    """Measured loads and catalogue prediction of one propeller at n points in oblique flow."""

    name: str
    model: Model
    flow: tuple[Floats, Floats, Floats]  # omega [rad/s], speed [m/s], beta [rad]
    measured: Mapping[str, Floats]  # (n,) each [N], [N m]

    def loads(self) -> Loads:
        """Compute the loads with the current shares of ``propmap.bands``."""
        return Rotor(self.model).loads(*self.flow)

    def z_scores(self, name: str) -> Floats:
        """Return the errors of a load over their standard deviations (n,)."""
        found = self.loads()
        return (getattr(found, name) - self.measured[name]) / getattr(found.std, name)


def rows_of(path: Path) -> list[dict[str, str]]:
    """Read a CSV file whose comment lines begin with #."""
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def campaign(name: str, propeller: str, path: Path, columns: Mapping[str, str]) -> Campaign:
    """Read a campaign; ``columns`` maps loads to columns, with a minus for the opposite sign."""
    rows = rows_of(path)

    def column(text: str) -> Floats:
        return np.array([float(row[text.lstrip("-")]) for row in rows])

    omega, speed, beta = column("rpm") * RPM, column("speed_mps"), np.radians(column("beta_deg"))
    model = propmap.catalogue_model(propeller, air=Air())
    oblique = speed * np.sin(beta) > NEAR_REST * omega * model.propeller.radius
    measured = {
        load: (-1.0 if text.startswith("-") else 1.0) * column(text)[oblique]
        for load, text in columns.items()
    }
    return Campaign(name, model, (omega[oblique], speed[oblique], beta[oblique]), measured)


def campaigns(data: Path) -> list[Campaign]:
    """Read both oblique campaigns."""
    first = {name: f"{name}_N" for name in ("thrust", "drag")}
    first |= {name: f"{name}_Nm" for name in ("torque", "roll_moment", "pitch_moment")}
    second = {"thrust": "thrust_N", "torque": "torque_Nm", "drag": "inplane_x_N"}
    second |= {
        "side_force": "inplane_y_N",
        "roll_moment": "-moment_x_Nm",
        "pitch_moment": "moment_y_Nm",
    }
    oblique = data / "oblique"
    return [
        campaign("2019", "APC 8x6E", oblique / "apc_8x6e_published_polynomials.csv", first),
        campaign("second tunnel", "APC 10x4.7SF", oblique / "ryerson_apc_10x47.csv", second),
    ]


# -------------------------------------------------------------------------------------------------
# Axial flow.


def axial_z_scores(data: Path) -> dict[str, Floats]:
    """Return errors over standard deviations (n,) of all rows of the held-out runs."""
    rows = {one.name: one for one in refiled(read_uiuc_database(data / "uiuc" / "loads.csv"))}
    found: dict[str, list[Floats]] = {"thrust": [], "torque": []}
    for one in one_of_each([one for one in all_identified() if one.tested in rows]):
        tested = rows[one.tested]
        blade = replace(catalogue.load(one.propeller), blades=one.blades)
        moving = tested.advance > 0.0
        runs = {int(k): float(tested.rpm[tested.run == k].mean()) for k in set(tested.run[moving])}
        order = sorted(runs, key=lambda k: (runs[k], k))
        for run in {order[len(order) // 2], order[-1]} if len(order) > 1 else ():
            left = tested.run == run
            result = identify(AxialTest(blade, with_rows(tested, ~left)))
            known = SectionUncertainty(
                SectionCovariance(PARAMETERS, result.covariance),
                result.thrust_rms,
                result.power_rms,
            )
            law = airfoil_of(result.constants).with_parameters(uncertainty=known)
            turns, diameter = tested.rpm[left] / 60.0, blade.diameter
            loads = Rotor(Model(blade, law)).loads(
                2.0 * np.pi * turns, tested.advance[left] * turns * diameter, 0.0
            )
            force = Air().density * turns**2 * diameter**4
            wanted = {
                "thrust": tested.thrust[left] * force,
                "torque": tested.power[left] * force * diameter / (2.0 * np.pi),
            }
            for name, value in wanted.items():
                found[name].append((getattr(loads, name) - value) / getattr(loads.std, name))
    return {name: np.concatenate(parts) for name, parts in found.items()}


# -------------------------------------------------------------------------------------------------
# The shares of oblique flow that the campaigns imply.


def share_that_fits(one: Campaign, name: str) -> float:
    """Find the share at which the rms error of a load over its standard deviation is one."""

    def excess(share: float) -> float:
        with with_shares({name: share}):
            return float(np.mean(one.z_scores(name) ** 2)) - 1.0

    return 0.0 if excess(1e-6) < 0.0 else float(brentq(excess, 1e-6, 100.0, xtol=1e-4))


def with_shares(shares: Mapping[str, float]) -> ExitStack:
    """Set the shares of oblique flow by load, until the returned context ends."""
    stack = ExitStack()
    for table in (bands.OBLIQUE, bands.INPLANE):
        own = {name: share for name, share in shares.items() if name in table}
        stack.enter_context(mock.patch.dict(table, own))
    return stack


def shares_of(every: Sequence[Campaign]) -> dict[str, float]:
    """Return the larger share of the campaigns, since two are too few for a scatter."""
    found = {}
    for name in (*bands.OBLIQUE, *bands.INPLANE):
        each = [share_that_fits(one, name) for one in every if name in one.measured]
        if each:
            found[name] = max(each)
    return found


class InPlane(NamedTuple):
    """In-plane force of one propeller of the 2019 campaign, at ``ADVANCE``."""

    name: str
    measured: Floats
    installed: Loads
    factor: float  # best fit of the factor on the drag of the blades, with the typical area


def in_plane(data: Path) -> Iterator[InPlane]:
    """Compare catalogue predictions of edgewise force with ``gill2019_inplane.csv``."""
    for row in rows_of(data / "drag" / "gill2019_inplane.csv"):
        radius = float(row["radius_m"])
        model = propmap.catalogue_model(_named(row["propeller"]), int(row["blades"]))
        omega = TIP_SPEED / radius
        flow = (omega, ADVANCE * TIP_SPEED, 0.5 * np.pi)
        pressure = 0.5 * model.air.density * np.pi * radius**2 * TIP_SPEED**2
        measured = float(row["k4"]) * ADVANCE * pressure
        yield InPlane(
            row["propeller"], measured, Rotor(model).loads(*flow), _factor(model, flow, measured)
        )


def _named(name: str) -> str:
    """Return the catalogue name of a propeller of the campaign."""
    listed = f"uiuc-{name}"
    return listed if listed in catalogue.names() else name.replace("-", " ", 1)


def _factor(model: Model, flow: tuple[Any, Any, Any], measured: Floats) -> float:
    """Fit the factor on the drag of the blades to ``measured`` forces, with the typical area."""
    plain, mount = (
        Rotor(model.with_mount(Installed(factor))).loads(*flow).drag for factor in (1.0, 0.0)
    )
    blades = plain - mount
    return float(blades @ (measured - mount) / (blades @ blades))


VEHICLES = [
    ("Crazyflie 2.0, Förster 2015", "46x20 mm", 2, 50.0, "0.74"),
    ("Parrot Bebop, Sun et al. 2019", "128x76 mm", 3, 60.0, "1.24 to 1.39"),
    ("X500, PX4 and RotorS default", "APC 11x4.7SF", 2, 60.0, "1.32"),
    ("S500, tuned by hand to a log", "10x4.5", 2, 60.0, "3.84"),
]
"""Name, its propeller or a similar one, blades, tip speed in hover [m/s], and published H/(T mu) of
the whole vehicle."""


def vehicles() -> Iterator[tuple[str, str, float, float, float]]:
    """Yield name, then H/(T mu): published, of bare blades, of the installed rotor, and half its
    95 % band, at an advance ratio of 0.1."""
    for name, propeller, blades, tip, published in VEHICLES:
        model = propmap.catalogue_model(propeller, blades)
        flow = (tip / model.propeller.radius, 0.1 * tip, 0.5 * np.pi)
        loads = Rotor(model).loads(*flow)
        bare = Rotor(model.with_mount(Installed(1.0, 0.0))).loads(*flow)
        per = 0.1 * float(loads.thrust)
        half = 1.96 * float(loads.std.drag)
        yield name, published, float(bare.drag) / per, float(loads.drag) / per, half / per


# -------------------------------------------------------------------------------------------------
# The command.


def line_of(name: str, scores: Floats) -> str:
    """Return a line with the coverage and the rms of errors over standard deviations."""
    from statistics import NormalDist

    known = scores[np.isfinite(scores)]
    wide = [NormalDist().inv_cdf(0.5 + 0.5 * share) for share in SHARES]
    held = "  ".join(f"{np.mean(np.abs(known) <= w):6.1%}" for w in wide)
    return f"  {name:<28}{known.size:>6}  {held}   {np.sqrt(np.mean(known**2)):5.2f}"


def main(data: Path) -> None:
    """Print the tables."""
    print("points inside 50, 80, 95 % bands, rms of z-scores    rows")
    print("axial flow, held-out runs")
    for name, scores in axial_z_scores(data).items():
        print(line_of(name, scores))
    every = campaigns(data)
    alone = {one.name: shares_of([one]) for one in every}
    for one in every:
        others = shares_of([other for other in every if other is not one])
        print(f"{one.name}, {one.model.propeller.name}: catalogue; its shares held out")
        for name in LOADS:
            if name not in one.measured:
                continue
            print(line_of(name, one.z_scores(name)))
            if name in others:
                with with_shares(others):
                    print(line_of(f"{name}, held out", one.z_scores(name)))
        relative = {
            name: np.sqrt(np.mean((getattr(one.loads(), name) / one.measured[name] - 1.0) ** 2))
            for name in ("thrust", "torque", "drag")
        }
        print("  rms errors:", ", ".join(f"{name} {error:.1%}" for name, error in relative.items()))
    found = list(in_plane(data))
    scores = np.stack(
        [(one.installed.drag - one.measured) / one.installed.std.drag for one in found]
    )
    rms = [np.sqrt(np.mean((one.installed.drag / one.measured - 1.0) ** 2)) for one in found]
    print(f"in-plane force of {len(found)} propellers, 2019, mu {ADVANCE[0]:g} to {ADVANCE[-1]:g}")
    print(line_of("drag", scores.ravel()))
    print(f"  rms errors: median {np.median(rms):.1%}, maximum {np.max(rms):.1%}")
    factors = np.array([one.factor for one in found])
    second = every[1]
    own = _factor(second.model, second.flow, second.measured["drag"])
    print(
        f"  factor on the drag of the blades, with area {corrections.TYPICAL_AREA[0]:g} R^2: mean "
        f"{factors.mean():.2f}, deviation {factors.std(ddof=1):.2f}; second tunnel {own:.2f}"
    )
    print("H/(T mu) of whole vehicles: published; bare blades; installed, 95 % band")
    for name, published, bare, installed, half in vehicles():
        print(f"  {name:<32}{published:<14}{bare:5.2f}   {installed:.2f} +- {half:.2f}")
    print("shares per advance ratio: each campaign, and the larger")
    together = shares_of(every)
    for name in together:
        each = "  ".join(f"{alone[one.name].get(name, np.nan):5.2f}" for one in every)
        print(f"  {name:<14}{each}   {together[name]:5.2f}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
