"""Which propeller an aircraft flies best with: task, candidates, their order, how sure it is."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from propmap.aircraft.assumptions import hub_distances
from propmap.aircraft.mission import Mission
from propmap.aircraft.mission import fly as fly_mission
from propmap.aircraft.performance import endurance, top_speed
from propmap.aircraft.trim import STATUSES, Aircraft, SteadyStates
from propmap.catalogue.identified import PARAMETERS, all_identified
from propmap.catalogue.lookup import meant_by, own_constants, predicted_constants, propeller
from propmap.errors import InputError
from propmap.model.airfoil import Airfoil, SectionCovariance
from propmap.model.corrections import Correction
from propmap.model.model import Model, Section
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.tasks import InThreads, Workers, cores, in_order
from propmap.units import INCH
from propmap.vehicle.vehicle import Vehicle

COAXIAL = 1e-3  # distance of axes over the radius below which rotors are above each other


@dataclass(frozen=True, eq=False)
class Judged:
    """A candidate on an aircraft.

    Attributes
    ----------
    candidate : Candidate
        The propeller.
    score : float
        Score of the task, in its unit; NaN where it is not feasible.
    deviation : float
        Standard deviation of the score from that of the constants; NaN where it is not known.
    hover_power, cruise_power : float
        Electrical if known, else of the shafts [W]; the second is NaN where the task has no speed.
    hover_time, cruise_time : float
        On one battery [s]; NaN without one.
    thrust_margin : float
        In hover.
    top_speed : float
        [m/s]; NaN where it was not searched for or no limit was met.
    limit : str
        What limits the top speed, a status.
    why_not : str
        In words; empty where it is feasible.
    """

    candidate: Candidate
    score: float = math.nan
    deviation: float = math.nan
    hover_power: float = math.nan
    cruise_power: float = math.nan
    hover_time: float = math.nan
    cruise_time: float = math.nan
    thrust_margin: float = math.nan
    top_speed: float = math.nan
    limit: str = ""
    why_not: str = ""

    @property
    def feasible(self) -> bool:
        """Whether the task can be flown with it."""
        return not self.why_not


class Ranking:
    """The order of candidates for a task, on a vehicle.

    Parameters
    ----------
    vehicle : Vehicle
        With any propeller; candidates take its place.
    task : Task
        What it is for.
    corrections : tuple of Correction
        For all models; candidates whose constants know their own keep them.
    maximum_rotor_speed : float
        [rad/s].
    charge : float
        State of charge at which limits are taken.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        task: Task,
        corrections: tuple[Correction, ...],
        *,
        maximum_rotor_speed: float = math.inf,
        charge: float = 1.0,
    ) -> None:
        self.vehicle, self.task, self.corrections = vehicle, task, corrections
        self.maximum_rotor_speed, self.charge = maximum_rotor_speed, charge

    def judged(
        self,
        candidates: Sequence[Candidate],
        progress: Callable[[], None] | None = None,
        workers: Workers | None = None,
    ) -> list[Judged]:
        """Judge all candidates: the best first, then those that are not feasible, by thrust margin.

        Parameters
        ----------
        candidates : sequence of Candidate
            To choose from.
        progress : callable, optional
            Called after each.
        workers : Workers, optional
            Who judges; by default threads of this process.

        Returns
        -------
        list of Judged
            In order.
        """
        found = self._each(Ranking.judge, candidates, progress, workers)
        sign = 1.0 if self.task.ranked_by == "energy" else -1.0

        def place(one: Judged) -> tuple[bool, float]:
            least = sign * one.score if one.feasible else -float(np.nan_to_num(one.thrust_margin))
            return not one.feasible, least

        return sorted(found, key=place)

    def with_deviations(
        self,
        judged: Sequence[Judged],
        progress: Callable[[], None] | None = None,
        workers: Workers | None = None,
    ) -> list[Judged]:
        """Add the standard deviation of the scores, from seven more trims of each.

        Parameters
        ----------
        judged : sequence of Judged
            Candidates, as ``judged`` gives them.
        progress : callable, optional
            Called after each.
        workers : Workers, optional
            Who computes; by default threads of this process.

        Returns
        -------
        list of Judged
            With deviations, in the order given.
        """
        deviations = self._each(Ranking.deviation, judged, progress, workers)
        return [replace(one, deviation=d) for one, d in zip(judged, deviations, strict=True)]

    def _each(
        self,
        work: Callable[[Ranking, Any], Any],
        of: Sequence[Any],
        progress: Callable[[], None] | None,
        workers: Workers | None,
    ) -> list[Any]:
        """Return ``work`` of each, in order."""
        found = []
        for one in (workers or InThreads(cores())).results(work, self, of):
            found.append(one)
            if progress is not None:
                progress()
        return in_order(found)

    def aircraft(self, candidate: Candidate) -> Aircraft:
        """Return the vehicle with the ``candidate``."""
        air = self.vehicle.air
        vehicle = replace(self.vehicle, propeller=candidate.propeller)
        own = getattr(candidate.airfoil, "corrections", None)
        corrections = self.corrections if own is None else ()
        rotor = Rotor(Model(candidate.propeller, candidate.airfoil, air, corrections))
        return Aircraft(
            vehicle, rotor, maximum_rotor_speed=self.maximum_rotor_speed, charge=self.charge
        )

    def judge(self, candidate: Candidate) -> Judged:
        """Judge one ``candidate``, without the deviation of its score."""
        overlap = _overlap(self.vehicle, candidate.propeller.radius)
        if overlap:
            return Judged(candidate, why_not=overlap)
        craft, task = self.aircraft(candidate), self.task
        states = craft.steady([0.0, task.probed_speed])
        power, time = states.power.tolist(), endurance(craft, states).tolist()
        score, top, limit, why_not = math.nan, math.nan, "", self._why_not(states)
        if not why_not:
            top, limit = top_speed(craft, states, 0.0)
            score, why_not = self._score(craft, states, top)
        cruises = task.speed is not None
        return Judged(
            candidate,
            score,
            hover_power=power[0],
            cruise_power=power[1] if cruises else math.nan,
            hover_time=time[0],
            cruise_time=time[1] if cruises else math.nan,
            thrust_margin=float(states.thrust_margin[0]),
            top_speed=top,
            limit=limit,
            why_not=why_not,
        )

    def deviation(self, judged: Judged) -> float:
        """Return the first-order standard deviation of the score of ``judged``, or NaN."""
        if not judged.feasible or judged.candidate.covariance is None:
            return math.nan
        changes = []
        for candidate in judged.candidate.varied():
            craft = self.aircraft(candidate)
            states = craft.steady([0.0, self.task.probed_speed], margin=False)
            top = top_speed(craft, states, 0.0)[0] if self.task.name == "fast" else math.nan
            changes.append(self._score(craft, states, top)[0] - judged.score)
        return math.sqrt(sum(change**2 for change in changes)) if changes else math.nan

    def _score(self, craft: Aircraft, states: SteadyStates, top: float) -> tuple[float, str]:
        """Return the score, and why there is none."""
        task = self.task
        if task.name == "fast":
            return top, "" if math.isfinite(top) else "no top speed was found"
        if task.mission is not None:
            flown = fly_mission(craft, task.mission)
            lost = ~flown.lasted
            if lost.any():
                leg = int(np.argmax(lost))
                return math.nan, f"leg {leg + 1}: {flown.status_in_words(leg)}"
            return float(flown.energy.sum()), ""
        k = 0 if task.name == "hover" else 1
        if task.ranked_by == "energy":
            power = float(states.power[k])
            return (power / task.probed_speed if k else power), ""
        time = float(endurance(craft, states)[k])
        if not math.isfinite(time):
            return math.nan, "the battery's voltage is too low, or the vehicle has none"
        return (time * task.probed_speed if task.ranked_by == "range" else time), ""

    def _why_not(self, states: SteadyStates) -> str:
        words = ("hover", f"{self.task.probed_speed:g} m/s")
        asked = (True, self.task.name == "cruise")
        for k, what in enumerate(words):
            if asked[k] and not states.found[k]:
                status = str(states.status[k])
                used = states.used.get(status)
                more = f", {100.0 * used[k]:.0f} % of it" if used is not None else ""
                margin = float(states.thrust_margin[k])
                if math.isfinite(margin):
                    needed = "what is needed" if k else "the weight"
                    more += f"; thrust is {margin:.2f} of {needed}"
                return f"{what}: {STATUSES[status]}{more}"
        margin = float(states.thrust_margin[0])
        if not margin >= self.task.thrust_margin:
            return f"thrust margin in hover is {margin:.2f}, less than {self.task.thrust_margin:g}"
        return ""


def _overlap(vehicle: Vehicle, radius: float) -> str:
    """Say why disks of ``radius`` [m], but for coaxial ones, do not fit; empty where they do."""
    height, across = hub_distances(vehicle)
    beside = np.triu((across > COAXIAL * radius) & (height < radius), 1)
    closest = float(across[beside].min(initial=math.inf))
    if closest >= 2.0 * radius:
        return ""
    return f"the rotors overlap: hubs are {closest:.3g} m apart, the disks {2.0 * radius:.3g} m"


# -------------------------------------------------------------------------------------------------
# How sure a ranking is of its neighbours, and what no other propeller beats.


def beats(better: Judged, worse: Judged) -> float:
    """Return the probability that one candidate beats another.

    It is from the uncertainty of their constants alone.  What the model itself gets wrong is not
    counted, and is similar for both; constants of different propellers were found from different
    data and are taken as independent.

    Parameters
    ----------
    better, worse : Judged
        With deviations; the first is ahead of the second in a ranking.

    Returns
    -------
    float
        NaN where either has no deviation.
    """
    spread = math.hypot(better.deviation, worse.deviation)
    gap = abs(worse.score - better.score)
    if not math.isfinite(spread):
        return math.nan
    return 0.5 * (1.0 + math.erf(gap / (spread * math.sqrt(2.0)))) if spread > 0.0 else 1.0


def pareto(judged: Sequence[Judged]) -> NDArray[np.intp]:
    """Number the feasible ones not beaten in both hover power and top speed, by hover power."""
    power = np.array([one.hover_power if one.feasible else math.nan for one in judged])
    speed = np.array([one.top_speed if one.feasible else math.nan for one in judged])
    less, faster = power[:, None] < power, speed[:, None] > speed
    no_worse = (power[:, None] <= power) & (speed[:, None] >= speed)
    beaten = (no_worse & (less | faster)).any(axis=0)
    front = np.flatnonzero(np.isfinite(power + speed) & ~beaten)
    return front[np.argsort(power[front], kind="stable")]


# -------------------------------------------------------------------------------------------------
# Propellers that an aircraft might fly with, and the constants of their blades.


@dataclass(frozen=True, eq=False)
class Candidate:
    """A propeller to choose."""

    name: str  # in the catalogue, or of its file
    propeller: Propeller
    airfoil: Section
    covariance: SectionCovariance | None = None  # of constants identified for this propeller
    verdict: str = "good"  # or what is wrong with the constants

    def varied(self) -> list[Candidate]:
        """List candidates with constants off by one standard deviation along each principal axis of
        their covariance, to the other side or not at all where one would leave its bounds."""
        if self.covariance is None or not isinstance(self.airfoil, Airfoil):
            return []
        known = self.covariance.determined
        variances, axes = np.linalg.eigh(known.matrix)
        found = []
        for variance, axis in zip(variances, axes.T, strict=True):
            for size in (math.sqrt(max(variance, 0.0)), -math.sqrt(max(variance, 0.0))):
                change: Any = {
                    name: getattr(self.airfoil, name) + size * float(part)
                    for name, part in zip(known.names, axis, strict=True)
                }
                try:
                    found.append(replace(self, airfoil=self.airfoil.with_parameters(**change)))
                except InputError:
                    continue
                break
        return found


def catalogue_candidates(
    diameter: tuple[float, float] = (0.0, math.inf), blades: int | None = None
) -> list[Candidate]:
    """List every propeller whose constants were identified.

    Parameters
    ----------
    diameter : tuple of 2 float
        Least and largest [m].
    blades : int, optional
        How many; by default any.

    Returns
    -------
    list of Candidate
        In the order of the catalogue.

    Raises
    ------
    InputError
        Where there is none.
    """
    low, high = diameter
    found = []
    for one in all_identified():
        if blades not in (None, one.blades):
            continue
        blade = propeller(one.propeller, one.blades)
        # 10 in are 0.254 m but for rounding in the catalogue.
        if low - 1e-6 <= blade.diameter <= high + 1e-6:
            name = one.propeller if one.blades == 2 else f"{one.propeller}, {one.blades} blades"
            known = SectionCovariance(PARAMETERS, one.covariance)
            found.append(Candidate(name, blade, one.airfoil, known, one.verdict))
    if not found:
        fault = f"no propeller of the catalogue has {low / INCH:.3g} to {high / INCH:.3g} in"
        fault += f" and {blades} blades" if blades else ""
        raise InputError(fault, "ask for other diameters, see `propmap props`")
    return found


def file_candidate(path: str | os.PathLike[str], section: Section | None = None) -> Candidate:
    """Make a candidate of a file or a name, with constants of its own or predicted ones.

    Parameters
    ----------
    path : path or str
        As for ``propmap.propeller``.
    section : Section, optional
        Its section law; by default the best constants that are known of it, see
        ``propmap.known_model``.

    Returns
    -------
    Candidate
        Named as the path.
    """
    blade = propeller(path)
    law, verdict = section, "section law as given"
    if law is None:
        meant = meant_by(path)
        own = own_constants(meant, blade.blades)
        law = own.airfoil if own else predicted_constants(meant, blade).airfoil
        verdict = own.verdict if own else "constants to be expected, not identified"
    known = getattr(law, "uncertainty", None)
    return Candidate(os.fspath(path), blade, law, known and known.covariance, verdict)


MEASURES = {
    "hover": {"energy": "power in hover", "time": "time in hover on one battery"},
    "cruise": {
        "energy": "energy per distance at the speed",
        "time": "time at the speed on one battery",
        "range": "distance at the speed on one battery",
    },
    "fast": {"speed": "top speed"},
    "mission": {"energy": "energy of the mission"},
}  # what candidates may be ranked by for each task, the first by default

UNITS = {"energy": "W", "time": "s", "range": "m", "speed": "m/s"}
ENERGIES = {"cruise": "J/m", "mission": "J"}  # units of the energy of tasks that are not held
SPEED = 10.0  # [m/s] at which propellers are compared besides hover, unless one is given


@dataclass(frozen=True, eq=False)
class Task:
    """What an aircraft is for.

    Attributes
    ----------
    name : str
        A key of ``MEASURES``.
    speed : float or None
        Speed of the cruise [m/s]; None where the task has none.
    mission : Mission or None
        For the task "mission".
    thrust_margin : float
        That hover must leave.
    measure : str
        One of the task's ``MEASURES``; empty for the first.

    Raises
    ------
    InputError
        For another name or measure, a speed that is not positive or missing, and a missing mission.
    """

    name: str
    speed: float | None = None
    mission: Mission | None = None
    thrust_margin: float = 1.5
    measure: str = ""

    def __post_init__(self) -> None:
        if self.name not in MEASURES:
            raise InputError(f"the task is {self.name!r}", f"choose from {', '.join(MEASURES)}")
        if self.speed is None and self.name == "cruise":
            raise InputError("cruise has no speed", "give a speed in m/s, or the task hover")
        if self.speed is not None and not self.speed > 0.0:
            raise InputError(f"the speed is {self.speed:g} m/s", "give a speed above 0")
        if (self.name == "mission") != (self.mission is not None):
            raise InputError("the task and the mission do not fit", "give a mission for this task")
        if not self.thrust_margin >= 1.0:
            found = f"the thrust margin is {self.thrust_margin:g}"
            raise InputError(found, "give 1 or more: with less thrust than weight nothing flies")
        known = MEASURES[self.name]
        if self.measure and self.measure not in known:
            found = f"the task {self.name} is not ranked by {self.measure}"
            raise InputError(found, f"choose from {', '.join(known)}")

    @property
    def ranked_by(self) -> str:
        """Key of its ``MEASURES`` by which candidates are ranked."""
        return self.measure or next(iter(MEASURES[self.name]))

    @property
    def words(self) -> str:
        """What candidates are ranked by, in words."""
        return MEASURES[self.name][self.ranked_by]

    @property
    def unit(self) -> str:
        """Unit of a score."""
        unit = UNITS[self.ranked_by]
        return ENERGIES.get(self.name, unit) if self.ranked_by == "energy" else unit

    @property
    def probed_speed(self) -> float:
        """Speed at which propellers are compared besides hover [m/s]."""
        return SPEED if self.speed is None else self.speed
