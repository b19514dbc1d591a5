"""Compare the loads of the core in descent with those of a brute-force solution of eq. (11).

Usage: python -m tools.dense_descents FOUND.jsonl [--count 200000] [--each 3 | --by-fine]
       python -m tools.dense_descents FOUND.jsonl --advance-ratio 4 --count 20000
       python -m tools.dense_descents FOUND.jsonl --other-laws --count 100000
       python -m tools.dense_descents --point NAME OMEGA SPEED BETA [--paper]

``tools/dense_descents.cpp``, compiled here, shares the equations of the core, which
``tests/oracle`` checks, but not its panels, forecasts and root searches.  Forces are those at the
middle of strips of equal width.  A scan of the residual of (11) from above, in even steps of the
inflow angle, finds the first change of sign: the largest root.  Azimuths are equal steps; harmonics
are solved by Newton's method with differences.  (The wake states of descent belong to the
equations: the windmill branch has another momentum thrust, the vortex ring a measured inflow.)

``LOOKS`` are four solutions of increasing fineness, so that 200,000 points can be computed.  The
first one solves each point; the second one solves it if the core differs by more than 0.05 % of the
static loads, the next ones if the core differs from the one before by more than 0.09 %.  On the
windmill branch, the inflow may jump by half of the tip speed at a radius; there, only the fourth
one is exact.  An error above 0.1 % is missed only if the first solution errs by more than 0.05 %,
or the second by more than 0.01 %, in the same direction as the core.  The cause can be a stretch of
blade narrower than a 400th of it, or a rise of the residual between trial inflows 0.008 rad apart.

``--each 3`` uses the third solution alone and misses no such error, on a smaller sample.
``--by-fine`` replaces the first one by accuracy ``fine`` of the core, in a tenth of the time, and
misses errors common to both accuracies.

Random points and errors:

- Half are on the propellers ``FAVORED``, whose errors were the largest, half on any propeller of
  the catalogue.  One in four has the paper's model, without corrections.
- Tip speeds are 20 to 200 m/s.  Airspeeds reach 4 static inflows (half of the points) or the tip
  speed.  beta is 90 to 180 deg, with one point in 25 at each end.
- ``--other-laws`` replaces the propellers by 100 rotors with random section laws on ten blades
  (``tests/other_laws.py``).  beta is 0 to 180 deg.  A rotor that is stalled at rest has the static
  loads of ``error_scales_of`` there.
- Errors are relative to static thrust, static torque or, for the two moments, static thrust times
  R, at the same rotational speed.  Beyond an advance ratio of 1, these references are multiplied by
  1 + (V/(Omega R))^2.

FOUND.jsonl gets a line per 500 points.  Points that it contains are not computed again.
"""

from __future__ import annotations

import argparse
import ctypes
import functools
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import propmap as pm
from propmap.catalogue import names
from propmap.loads import LOADS
from propmap.model.propeller import blade_intervals
from propmap.rotor import core_corrections
from propmap.typing import Floats
from tests.other_laws import error_scales_of, other_rotors

HERE = Path(__file__).resolve().parent
FLAGS = (
    "-std=c++20",
    "-O3",
    "-march=native",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-ffp-contract=fast",
)
COMPILER = os.environ.get("CXX", "c++").split()
FAVORED = ("uiuc-apcsp-11x4", "uiuc-mit-5x4")
SEED = 40
NAMES = tuple(LOADS)
CHUNK = 500
LIMIT = 1e-3
"""Largest error that accuracy ``standard`` allows, relative to the static loads."""

CLOSER = (5e-4, 9e-4, 9e-4)
"""Smallest differences for which the next solution is computed."""

TOLD = ("coarse", "not_converged")
"""Statuses that announce a larger error."""


class Look(NamedTuple):
    """Fineness of a brute-force solution."""

    strips: int  # along the blade; 0 for accuracy fine of the core
    step: float  # between trial inflows [rad]
    azimuths: tuple[int, int, int]  # up to an advance ratio of 0.25, to 0.5, and beyond


LOOKS = (
    Look(400, 0.008, (32, 64, 128)),
    Look(1600, 0.005, (64, 128, 256)),
    Look(6000, 0.003, (128, 256, 384)),
    Look(60000, 0.003, (128, 256, 384)),
)

FINE = Look(0, 0.0, (0, 0, 0))


class Point(NamedTuple):
    """A propeller at an operating point [rad/s], [m/s], [deg]; ``paper``: no corrections."""

    name: str
    paper: bool
    omega: float
    speed: float
    beta: float

    @property
    def command(self) -> str:
        """The command that computes this point again."""
        motion = f"{self.omega!r} {self.speed!r} {self.beta!r}"
        paper = " --paper" if self.paper else ""
        return f"python -m tools.dense_descents --point {self.name} {motion}{paper}"


@functools.cache
def library() -> Any:
    """Compile and load the brute-force solution."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "dense.so"
        include = f"-I{HERE.parent / 'core' / 'include'}"
        source = str(HERE / "dense_descents.cpp")
        command = [*COMPILER, *FLAGS, "-shared", "-fPIC", include, source, "-o", str(made)]
        subprocess.run(command, check=True)
        return ctypes.CDLL(str(made))


def dense_loads(model: pm.Model, look: Look, motion: Floats) -> Floats:
    """Compute the loads (N, 6) [N], [N m] at N rows of omega, v_axial and v_inplane."""
    blade, law, with_ = model.propeller, model.airfoil.core_law(), core_corrections(model)
    known = {"inflow", "radial-friction", "installed", "mount-area", "mount-wake"}
    if law["kind"] == "tabulated" or not known.issuperset(with_):
        raise SystemExit(f"{blade.name}: {law['kind']} section, {sorted(set(with_) - known)}")
    numbers = [*model.span, blade.blades, model.air.density, model.air.viscosity]
    numbers += ["inflow" in with_, "radial-friction" in with_, "installed" in with_]
    numbers += [with_.get("installed", 1.0), with_.get("mount-area", 0.0)]
    numbers += [with_.get("mount-wake", 1.0), law["attached"], law["plate"]]
    order = ("c_l1", "c_l2", "c_d", "alpha_0", "zero_lift_angle", "c_d0", "c_p", "sharpness")
    further = ("reynolds_camber", "drag_angle", "reynolds_lift", "reynolds_drag")
    numbers += [law[name] for name in (*order, *further)]
    intervals = blade_intervals(blade, model.span[0])
    looks = np.asarray([look.strips, *look.azimuths], np.int64)
    rows, found = np.ascontiguousarray(motion, np.float64), np.empty((len(motion), len(NAMES)))
    at = [
        np.ascontiguousarray(a)
        for a in (np.asarray(numbers, np.float64), intervals, looks, rows, found)
    ]
    place = [ctypes.c_void_p(a.ctypes.data) for a in at]
    count, step = ctypes.c_int64(len(motion)), ctypes.c_double(look.step)
    library().dense_loads(
        place[0], ctypes.c_int64(len(intervals)), *place[1:3], step, count, *place[3:]
    )
    return found


OTHERS = {f"law-{k}": one for k, one in enumerate(other_rotors(100, SEED))}


@functools.cache
def model_of(name: str) -> pm.Model:
    """Return the recommended model of a catalogue propeller, or a rotor of ``OTHERS``."""
    if one := OTHERS.get(name):
        return pm.Model(one.propeller(), one.airfoil)
    return pm.catalogue_model(name)


@functools.cache
def rotor(name: str, paper: bool, accuracy: str = "standard") -> pm.Rotor:
    """Return a propeller with the recommended model or the paper's."""
    model = model_of(name)
    return pm.Rotor(replace(model, corrections=()) if paper else model, accuracy=accuracy)


def sample(index: int, advance: float = 0.0, others: bool = False) -> Point:
    """Return random point ``index``, with V/(Omega R) above ``advance`` if that is positive."""
    random = np.random.default_rng([SEED, index])
    share, which = random.uniform(size=2)
    pool = tuple(OTHERS) if others else FAVORED if share < 0.5 else tuple(names())
    name, paper = pool[int(which * len(pool))], bool(random.uniform() < 0.25)
    one = rotor(name, paper)
    tip_speed = random.uniform(20.0, 200.0)
    omega = tip_speed / one.model.propeller.radius
    slow = bool(random.uniform() < 0.5)
    most = 4.0 * float(one.hover_inflow(omega)) if slow else tip_speed
    speed = random.uniform(0.0, most)
    beta = float(
        np.clip(random.uniform(0.0 if others else 86.0, 184.0), 0.0 if others else 90.0, 180.0)
    )
    if advance > 0.0:
        # Fast flow past a slow rotor, down to one that is nearly at rest.
        speed, omega = 0.5 * tip_speed, 0.5 * omega / (advance * 10.0 ** (3.0 * random.uniform()))
        beta = random.uniform(0.0, 180.0)
    return Point(name, paper, float(omega), float(speed), beta)


def motions(points: list[Point]) -> Floats:
    """Return Omega, V cos(beta) and V sin(beta) (N, 3), as the package resolves them."""
    omega, speed, beta = np.array([point[2:] for point in points]).T
    turned = pm.operating_points.resolved(omega, speed, np.deg2rad(beta))
    return np.stack([turned.omega, turned.v_axial, turned.v_inplane], axis=-1)


def loads_by(look: Look, of: Point, motion: Floats) -> Floats:
    """Compute the loads (N, 6) of the rotor of point ``of`` at the rows of ``motion``."""
    if look != FINE:
        return dense_loads(rotor(*of[:2]).model, look, motion)
    omega, along, across = motion.T
    velocity = np.stack([across, 0.0 * across, along], axis=-1)
    loads = rotor(*of[:2], "fine").loads_at_velocity(omega, velocity)
    return np.stack([getattr(loads, name) for name in NAMES], axis=-1)


def differences(points: list[Point], looks: tuple[Look, ...]) -> list[dict[str, Any]]:
    """Compare the core with brute-force solutions at ``points`` of one rotor."""
    one, motion = rotor(*points[0][:2]), motions(points)
    omega, speed, beta = np.array([point[2:] for point in points]).T
    loads = one.loads(omega, speed, np.deg2rad(beta))
    core = np.stack([getattr(loads, name) for name in NAMES], axis=-1)
    radius = one.model.propeller.radius
    advance = np.hypot(motion[:, 1], motion[:, 2]) / (motion[:, 0] * radius)
    wind = np.where(advance > 1.0, 1.0 + advance**2, 1.0)
    worst, taken = np.full(len(points), np.inf), np.zeros(len(points), int)
    which = np.full(len(points), -1)
    for look, least in zip(looks, (0.0, *CLOSER), strict=False):
        open_ = np.flatnonzero(worst >= least)
        if open_.size == 0:
            break
        at_rest = motion[open_] * [1.0, 0.0, 0.0]
        scale = np.abs(loads_by(look, points[0], at_rest))
        thrust, torque = scale[:, NAMES.index("thrust")], scale[:, NAMES.index("torque")]
        if points[0].name in OTHERS:
            static = error_scales_of(one.model, motion[open_, 0])
            thrust, torque = static["thrust"], static["torque"]
        per = {"torque": torque, "roll_moment": thrust * radius, "pitch_moment": thrust * radius}
        unit = np.stack([per.get(name, thrust) for name in NAMES], axis=-1)
        off = np.abs(core[open_] - loads_by(look, points[0], motion[open_]))
        off = np.nan_to_num(off / (unit * wind[open_, None]), nan=np.inf)
        worst[open_], which[open_], taken[open_] = (
            off.max(axis=-1),
            off.argmax(axis=-1),
            taken[open_] + 1,
        )
    return [
        {"off": float(o), "load": NAMES[w], "looks": int(t), "status": str(s), "point": list(p)}
        for o, w, t, s, p in zip(worst, which, taken, loads.status, points, strict=True)
    ]


def chunk(
    first: int, count: int, looks: tuple[Look, ...], advance: float, others: bool = False
) -> dict[str, Any]:
    """Compare ``count`` random points from ``first`` on."""
    points = {k: sample(k, advance, others) for k in range(first, first + count)}
    by_rotor: dict[tuple[str, bool], list[int]] = {}
    for k, point in points.items():
        by_rotor.setdefault(point[:2], []).append(k)
    found = [
        row | {"index": k}
        for of_one in by_rotor.values()
        for k, row in zip(of_one, differences([points[k] for k in of_one], looks), strict=True)
    ]
    silent = [row for row in found if row["status"] not in TOLD]
    return {
        "first": first,
        "count": count,
        "looks": dict(Counter(str(row["looks"]) for row in found)),
        "told": dict(Counter(row["status"] for row in found)),
        "worst": max(silent, key=lambda row: row["off"]),
        "above": [row for row in found if not row["off"] <= LIMIT],
    }


def main(arguments: list[str]) -> None:
    """Compute the points that FOUND.jsonl does not contain, and print a summary."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("found", nargs="?", type=Path)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=200_000)
    parser.add_argument("--each", type=int, default=0, help="use this solution alone (1 to 4)")
    parser.add_argument("--by-fine", action="store_true", help="use accuracy fine for the first")
    parser.add_argument("--advance-ratio", type=float, default=0.0)
    parser.add_argument("--other-laws", action="store_true", help="use random section laws")
    parser.add_argument("--point", nargs=4)
    parser.add_argument("--paper", action="store_true")
    given = parser.parse_args(arguments)
    if given.point:
        name, *motion = given.point
        show(Point(name, given.paper, *map(float, motion)))
        return
    looks = LOOKS[given.each - 1 : given.each] if given.each else LOOKS
    looks = (FINE, *LOOKS[1:]) if given.by_fine else looks
    done = [json.loads(line) for line in given.found.open()] if given.found.exists() else []
    have = {line["first"] for line in done}
    with given.found.open("a", encoding="utf-8") as file:
        for first in range(given.first, given.first + given.count, CHUNK):
            if first in have:
                continue
            count = min(CHUNK, given.first + given.count - first)
            done.append(chunk(first, count, looks, given.advance_ratio, given.other_laws))
            print(json.dumps(done[-1]), file=file, flush=True)
    summary(done)


def show(point: Point) -> None:
    """Print the loads at one point by all accuracies and solutions."""
    motion, names_ = motions([point]), " ".join(f"{name:>13}" for name in NAMES)
    print(f"{'':26}{names_}")
    for accuracy in pm.rotor.ACCURACIES:
        loads = rotor(*point[:2], accuracy).loads(point.omega, point.speed, np.deg2rad(point.beta))
        values = " ".join(f"{float(getattr(loads, name)):13.8g}" for name in NAMES)
        print(f"{accuracy + ' ' + str(loads.status):26}{values}")
    for look in LOOKS:
        for title, row in (("", motion), (" at rest", motion * [1.0, 0.0, 0.0])):
            found = dense_loads(rotor(*point[:2]).model, look, row)[0]
            values = " ".join(f"{load:13.8g}" for load in found)
            print(f"{f'{look.strips} strips{title}':26}{values}")


def summary(done: list[dict[str, Any]]) -> None:
    """Print the numbers of points and of errors, and the largest errors."""
    total: dict[str, Counter[str]] = {"looks": Counter(), "told": Counter()}
    for line in done:
        for name, counts in total.items():
            counts.update(line[name])
    above = [row for line in done for row in line["above"]]
    silent = [row for row in above if row["status"] not in TOLD]
    worst = max((line["worst"] for line in done), key=lambda row: row["off"])
    print(f"{sum(line['count'] for line in done)} points, statuses {dict(total['told'])}")
    print(f"points by number of solutions used: {dict(total['looks'])}")
    print(f"above {LIMIT:.1%}: {len(silent)} without a status, {len(above) - len(silent)} with one")
    for row in [worst, *silent]:
        point = Point(*row["point"])
        print(f"{row['off']:.3%} of {row['load']}, {row['status']}: {point.command}")


if __name__ == "__main__":
    main(sys.argv[1:])
