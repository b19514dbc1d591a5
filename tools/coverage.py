"""Print coverage, width and score of the bands, and the numbers for ``propmap.bands``.

Usage: python -m tools.coverage DATA

DATA is the folder of reference data.  The score is the interval score of a 95 % band: its width
plus 40 times the distance of a measurement outside it (Gneiting, Raftery, J. Am. Stat. Assoc. 102,
2007).  Width and score are divided by the rms of the measurements.

Axial flow: for each propeller of the UIUC database with a measured blade, the middle and the
fastest run are held out in turn.  ``tools.catalogue.left_out`` evaluates the bands of predicted
constants, and ``tools.stands`` those of multirotor propellers.

Oblique flow: catalogue predictions are compared with the loads of the APC 8x6E and the in-plane
force of 20 propellers (2019 campaign), and with the loads of a 10x4.7 Slow Flyer (second tunnel).
First, the tool removes the errors of each campaign that its axial rows reveal, see
``CampaignErrors``, and the error ``TORQUE_ARM``.  The remaining error is attributed to the theory.
The shares of this error minimize the score with at least 90 % of each campaign inside the bands.
Lines with "held out" use the shares of the other campaign alone.  In the second tunnel the axes of
the moments are inferred.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from statistics import NormalDist
from typing import Any, NamedTuple
from unittest import mock

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

import propmap
from propmap import bands, catalogue
from propmap.catalogue.identified import (
    PARAMETERS,
    all_identified,
    identified_without_blade,
    one_of_each,
)
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
from tools.catalogue.left_out import BAND, interval_score

SHARES = (0.50, 0.80, 0.95)
LOADS = ("thrust", "torque", "drag", "roll_moment", "side_force", "pitch_moment")
LEAST_INSIDE = 0.90  # minimum share of the rows of each campaign inside the 95 % bands

NEAR_REST = 0.02
"""Minimum advance ratio of a row in oblique flow."""

TORQUE_ARM = 0.0155
"""Error of the torque in the second tunnel, divided by the advance ratio and the thrust [m].

This tunnel tested two rotors that turn in opposite directions.  Their torque residuals have the
same sign in the axes of the balance, 0.013 to 0.018 m, so the balance causes them.  The value is
the middle of this range.  The reference data exclude the second rotor."""

ADVANCE = np.linspace(0.05, 0.25, 5)
"""Advance ratios at which in-plane forces of the 2019 campaign are compared."""

TIP_SPEED = 84.0  # [m/s], about the middle of the 2019 campaign


class CampaignErrors(NamedTuple):
    """Errors of a campaign, estimated from its rows in axial flow, including those at rest.

    Thrust and torque equal ``scale`` times the UIUC values plus ``by_speed`` times the squared
    axial speed.  The second term has the form of the drag of a stand.  The other loads are zero in
    axial flow.  Their measured values are modeled as ``tare`` plus ``interaction`` times the
    thrust.
    """

    scale: Mapping[str, float]
    by_speed: Mapping[str, float]  # [N s^2/m^2], [N m s^2/m^2]
    tare: Mapping[str, float]  # [N], [N m]
    interaction: Mapping[str, float]  # [-], [m]


class Campaign(NamedTuple):
    """Measured loads and catalogue prediction of one propeller at n points."""

    name: str
    model: Model
    flow: tuple[Floats, Floats, Floats]  # omega [rad/s], speed [m/s], beta [rad]
    measured: Mapping[str, Floats]  # (n,) each [N], [N m]
    torque_arm: float = 0.0  # as ``TORQUE_ARM`` [m]

    @property
    def advance(self) -> Floats:
        """V sin(beta) over the tip speed (n,)."""
        omega, speed, beta = self.flow
        return speed * np.sin(beta) / (omega * self.model.propeller.radius)

    def rows(self, which: NDArray[np.bool_]) -> Campaign:
        """Return the campaign with the chosen rows."""
        measured = {name: values[which] for name, values in self.measured.items()}
        omega, speed, beta = (values[which] for values in self.flow)
        return self._replace(flow=(omega, speed, beta), measured=measured)

    def errors(self) -> CampaignErrors:
        """Estimate the errors of the campaign from its axial rows, by least squares."""
        axial = self.rows(self.flow[2] == 0.0)
        omega, speed, _ = axial.flow
        loads = Rotor(self.model).loads(*axial.flow)
        weight = 1.0 / omega**2  # so that all rotational speeds have equal relative errors
        scale, by_speed, tare, interaction = {}, {}, {}, {}
        for name, values in axial.measured.items():
            if name in bands.OBLIQUE:
                terms = np.stack([getattr(loads, name), speed**2], axis=1)
                found = np.linalg.lstsq(terms * weight[:, None], values * weight)[0]
                scale[name], by_speed[name] = map(float, found)
            else:
                terms = np.stack([np.ones_like(values), axial.measured["thrust"]], axis=1)
                tare[name], interaction[name] = map(float, np.linalg.lstsq(terms, values)[0])
        return CampaignErrors(scale, by_speed, tare, interaction)

    def corrected(self) -> Campaign:
        """Return the rows in oblique flow, without the errors of the campaign."""
        found = self.errors()
        _, speed, beta = self.flow
        axial = speed * np.cos(beta)
        measured = {}
        for name, values in self.measured.items():
            if name in found.scale:
                own = values - found.by_speed[name] * axial * np.abs(axial)
                measured[name] = own / found.scale[name]
            else:
                own = found.tare[name] + found.interaction[name] * self.measured["thrust"]
                measured[name] = values - own
        measured["torque"] -= self.torque_arm * self.advance * measured["thrust"]
        return self._replace(measured=measured).oblique()

    def oblique(self) -> Campaign:
        """Return the rows in oblique flow."""
        return self.rows(self.advance > NEAR_REST)

    def bands(self, name: str) -> Bands:
        """Return the errors of a load and its bands with the current shares."""
        loads = Rotor(self.model).loads(*self.flow)
        deviation = np.array(getattr(loads.std, name))
        return Bands(getattr(loads, name) - self.measured[name], deviation, self.measured[name])


class Bands(NamedTuple):
    """Errors of predicted loads (n,), their standard deviations, and the measured loads."""

    error: Floats
    deviation: Floats
    measured: Floats

    @property
    def size(self) -> float:
        """The rms of the measured loads."""
        return float(np.sqrt(np.nanmean(self.measured**2)))

    def inside(self, share: float = 0.95) -> float:
        """Return the fraction of rows inside the band of nominal coverage ``share``."""
        wide = NormalDist().inv_cdf(0.5 + 0.5 * share)
        return float(np.mean(np.abs(self.error) <= wide * self.deviation))

    def half_width(self) -> float:
        """Return the median of half the width of the 95 % band, over the rms."""
        return float(np.nanmedian(BAND * self.deviation)) / self.size

    def score(self) -> float:
        """Return the mean interval score of the 95 % band, over the rms."""
        return float(np.nanmean(interval_score(self.error, self.deviation))) / self.size


def rows_of(path: Path) -> list[dict[str, str]]:
    """Read a CSV file whose comment lines begin with #."""
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def campaign(name: str, propeller: str, path: Path, columns: Mapping[str, str]) -> Campaign:
    """Read a campaign; ``columns`` maps loads to columns, with a minus for the opposite sign."""
    rows = rows_of(path)

    def column(text: str) -> Floats:
        sign = -1.0 if text.startswith("-") else 1.0
        return sign * np.array([float(row[text.lstrip("-")]) for row in rows])

    flow = column("rpm") * RPM, column("speed_mps"), np.radians(column("beta_deg"))
    measured = {load: column(text) for load, text in columns.items()}
    return Campaign(name, propmap.catalogue_model(propeller, air=Air()), flow, measured)


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
        campaign(
            "second tunnel", "APC 10x4.7SF", oblique / "ryerson_apc_10x47.csv", second
        )._replace(torque_arm=TORQUE_ARM),
    ]


# --- Axial flow ----------------------------------------------------------------------------------


class HeldOut(NamedTuple):
    """Coefficients of one run that was held out of the identification of a propeller, (n,)."""

    load: str
    predicted: Floats
    measured: Floats
    own: Floats  # standard deviation without the tunnel term

    def bands(self, gain: float) -> Bands:
        """Return the bands with a standard deviation ``gain`` between specimens or runs."""
        deviation = np.hypot(self.own, gain * self.predicted)
        return Bands(self.predicted - self.measured, deviation, self.measured)


def held_out_runs(data: Path) -> Iterator[HeldOut]:
    """Predict the middle and the fastest run of each propeller from its other rows."""
    rows = {one.name: one for one in refiled(read_uiuc_database(data / "uiuc" / "loads.csv"))}
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
                another_tunnel=False,
            )
            law = airfoil_of(result.constants).with_parameters(uncertainty=known)
            turns, diameter = tested.rpm[left] / 60.0, blade.diameter
            loads = Rotor(Model(blade, law)).loads(
                2.0 * np.pi * turns, tested.advance[left] * turns * diameter, 0.0
            )
            force = Air().density * turns**2 * diameter**4
            per = {"thrust": force, "torque": force * diameter / (2.0 * np.pi)}
            wanted = {"thrust": tested.thrust[left], "torque": tested.power[left]}
            for name, value in wanted.items():
                parts = (
                    getattr(loads, name) / per[name],
                    value,
                    getattr(loads.std, name) / per[name],
                )
                yield HeldOut(name, *parts)


def over_runs(runs: Sequence[HeldOut], gain: float) -> tuple[float, float, float]:
    """Return coverage, half width and score of the 95 % bands, as means over ``runs``."""
    found = [one.bands(gain) for one in runs]
    each = [(one.inside(), one.half_width(), one.score()) for one in found]
    inside, half, score = np.mean(each, axis=0).tolist()
    return inside, half, score


def gain_of(runs: Sequence[HeldOut]) -> float:
    """Return the standard deviation between specimens or runs that minimizes the mean score."""
    found = minimize_scalar(lambda g: over_runs(runs, g)[2], bounds=(0.0, 0.1), method="bounded")
    return float(found.x)


# --- Growth of the static coefficients with the rotational speed ---------------------------------

LEAST_RANGE = 2.0  # ratio of the highest to the lowest rotational speed


class Exponents(NamedTuple):
    """Exponents of static C_T and C_P as powers of the rotational speed, (2,) each."""

    family: str
    measured: Floats
    predicted: Floats


def static_exponents(data: Path) -> Iterator[Exponents]:
    """Fit the exponents of all two-blade propellers with identified constants."""
    rows = {one.name: one for one in refiled(read_uiuc_database(data / "uiuc" / "loads.csv"))}
    entries = [*one_of_each(all_identified()), *identified_without_blade()]
    for one in entries:
        tested = rows.get(one.tested)
        if one.blades != 2 or tested is None or not (tested.advance == 0.0).any():
            continue
        still = with_rows(tested, tested.advance == 0.0)
        if still.rpm.max() < LEAST_RANGE * still.rpm.min():
            continue
        blade = propmap.propeller(one.propeller, blades=2)
        loads = Rotor(Model(blade, one.airfoil)).loads(still.rpm * RPM, 0.0, 0.0)
        log_speed = np.log(still.rpm)
        squares = np.stack([loads.thrust, loads.torque]) / still.rpm**2
        fits = (np.stack([still.thrust, still.power]), squares)
        yield Exponents(one.family, *(np.polyfit(log_speed, np.log(each).T, 1)[0] for each in fits))


def print_exponents(found: Sequence[Exponents]) -> None:
    """Print median exponents by family, and the median of measured minus predicted exponents."""
    print("at rest, exponents over rpm, two blades: C_T measured, predicted; C_P; propellers")
    for family in sorted({one.family for one in found}):
        some = [one for one in found if one.family == family]
        pairs = np.median([(one.measured, one.predicted) for one in some], axis=0).T
        shown = "  ".join(f"{a:+.3f} {b:+.3f}" for a, b in pairs)
        print(f"  {family:<14}{shown}   {len(some):>3}")
    excess = np.median([one.measured - one.predicted for one in found], axis=0)
    print(f"  excess, median of all: C_T {excess[0]:+.3f}, C_P {excess[1]:+.3f}, {len(found)}")


# --- Shares of oblique flow, estimated from the campaigns ----------------------------------------


def with_shares(shares: Mapping[str, float]) -> ExitStack:
    """Replace the shares of oblique flow in ``propmap.bands`` until the returned context ends.

    ``shares`` are by load.
    """
    stack = ExitStack()
    for table in (bands.OBLIQUE, bands.INPLANE):
        own = {name: share for name, share in shares.items() if name in table}
        stack.enter_context(mock.patch.dict(table, own))
    return stack


def shares_of(every: Sequence[Campaign]) -> dict[str, float]:
    """Return the shares that minimize the sum of the scores and reach ``LEAST_INSIDE``."""
    found = {}
    for name in (*bands.OBLIQUE, *bands.INPLANE):
        some = [one for one in every if name in one.measured]
        if some:
            found[name] = _share_of(some, name)
    return found


def _share_of(some: Sequence[Campaign], name: str) -> float:
    def at(share: float) -> list[Bands]:
        with with_shares({name: share}):
            return [one.bands(name) for one in some]

    best = minimize_scalar(
        lambda share: sum(one.score() for one in at(share)),
        bounds=(0.0, 2.0),
        method="bounded",
        options={"xatol": 1e-3},
    )
    share = float(best.x)
    while min(one.inside() for one in at(share)) < LEAST_INSIDE:
        share += 0.01
    return share


class InPlane(NamedTuple):
    """In-plane force of one propeller of the 2019 campaign, at ``ADVANCE``."""

    name: str
    measured: Floats
    installed: Loads
    factor: float  # fitted factor on the drag of the blades, with the typical mount area


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
    """Fit the factor on the drag of the blades to ``measured``, with the typical mount area."""
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
"""Name, propeller of the vehicle or a similar one, number of blades, tip speed in hover [m/s], and
published H/(T mu) of the whole vehicle."""


def vehicles() -> Iterator[tuple[str, str, float, float, float]]:
    """Yield the name of each vehicle and its H/(T mu) at an advance ratio of 0.1.

    The values are: published, bare blades, installed rotor, half width of its 95 % band.
    """
    for name, propeller, blades, tip, published in VEHICLES:
        model = propmap.catalogue_model(propeller, blades)
        flow = (tip / model.propeller.radius, 0.1 * tip, 0.5 * np.pi)
        loads = Rotor(model).loads(*flow)
        bare = Rotor(model.with_mount(Installed(1.0, 0.0))).loads(*flow)
        per = 0.1 * float(loads.thrust)
        half = 1.96 * float(loads.std.drag)
        yield name, published, float(bare.drag) / per, float(loads.drag) / per, half / per


# --- The command ---------------------------------------------------------------------------------


HEADER = f"  {'':<28}rows   inside 50, 80, 95 % bands   half width   score"


def line_of(name: str, of: Bands) -> str:
    """Return a line with the coverage, the half width and the score."""
    held = "  ".join(f"{of.inside(share):6.1%}" for share in SHARES)
    return (
        f"  {name:<28}{of.error.size:>4}   {held}     {of.half_width():6.1%}    {of.score():6.3f}"
    )


def at_advance(of: Bands, advance: Floats) -> float:
    """Return the median ratio of the half width of the 95 % band to the load, near mu = 0.2."""
    near = np.abs(advance - 0.2) < 0.03
    return float(np.median(BAND * of.deviation[near] / np.abs(of.measured[near])))


def main(data: Path) -> None:
    """Print the tables."""
    runs = list(held_out_runs(data))
    print("axial flow, held-out runs: means over runs of coverage, half width and score")
    for name in ("thrust", "torque"):
        own = [one for one in runs if one.load == name]
        inside, half, score = over_runs(own, bands.TUNNEL_GAIN)
        rows = sum(one.measured.size for one in own)
        print(f"  {name:<28}{rows:>4}   {inside:6.1%}  {half:6.1%}  {score:6.3f}", end="")
        print(f"   smallest score at a gain of {gain_of(own):.3f}")
    print(f"  TUNNEL_GAIN = {gain_of(runs):.3f}")
    print_exponents(list(static_exponents(data)))
    every = campaigns(data)
    for one in every:
        print(f"{one.name}, {one.model.propeller.name}: errors of the campaign")
        found = one.errors()
        for name, scale in found.scale.items():
            print(f"  {name:<14}{scale:.3f} times UIUC, {1e4 * found.by_speed[name]:+.2f}e-4 V^2")
        if one.torque_arm:
            print(f"  torque        {one.torque_arm:+.4f} m mu T")
        for name, tare in found.tare.items():
            if tare or found.interaction[name]:
                print(f"  {name:<14}{tare:+.4f} {found.interaction[name]:+.4f} T")
    corrected = [one.corrected() for one in every]
    alone = {one.name: shares_of([one]) for one in corrected}
    for raw, one in zip(every, corrected, strict=True):
        others = shares_of([other for other in corrected if other is not one])
        print(f"{one.name}: as measured; campaign errors removed; with the other campaign's shares")
        print(HEADER)
        for name in LOADS:
            if name not in one.measured:
                continue
            print(line_of(f"{name}, as measured", raw.oblique().bands(name)))
            of = one.bands(name)
            print(
                line_of(name, of),
                f"  half width at mu 0.2: {at_advance(of, one.advance):.0%} of the load",
            )
            if name in others:
                with with_shares(others):
                    print(line_of(f"{name}, held out", one.bands(name)))
    found_forces = list(in_plane(data))
    errors = np.stack([one.installed.drag - one.measured for one in found_forces])
    std = np.stack([one.installed.std.drag for one in found_forces])
    force = np.stack([one.measured for one in found_forces])
    rms = np.sqrt(np.mean((errors / force) ** 2, axis=1))
    print(f"in-plane force of {len(rms)} propellers, 2019, mu {ADVANCE[0]:g} to {ADVANCE[-1]:g}")
    print(line_of("drag", Bands(errors.ravel(), std.ravel(), force.ravel())))
    print(f"  rms errors: median {np.median(rms):.1%}, maximum {np.max(rms):.1%}")
    factors = np.array([one.factor for one in found_forces])
    second = _factor(corrected[1].model, corrected[1].flow, corrected[1].measured["drag"])
    print(
        f"  factor on the drag of the blades, with area {corrections.TYPICAL_AREA[0]:g} R^2: mean "
        f"{factors.mean():.2f}, deviation {factors.std(ddof=1):.2f}; second tunnel {second:.2f}"
    )
    print("H/(T mu) of whole vehicles: published; bare blades; installed, 95 % band")
    for name, published, bare, installed, half in vehicles():
        print(f"  {name:<32}{published:<14}{bare:5.2f}   {installed:.2f} +- {half:.2f}")
    print("shares per advance ratio: each campaign alone, and together")
    together = shares_of(corrected)
    for name in together:
        each = "  ".join(f"{alone[one.name].get(name, np.nan):5.2f}" for one in every)
        print(f"  {name:<14}{each}   {together[name]:5.2f}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
