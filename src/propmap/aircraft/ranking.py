"""Ranking of propellers for an aircraft: task, candidates, scores and their uncertainty."""

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
from propmap.model.airfoil import CONSTANTS, Airfoil, SectionCovariance
from propmap.model.corrections import Correction
from propmap.model.model import Model, Section
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.tasks import InThreads, Workers, cores, in_order
from propmap.units import INCH
from propmap.vehicle.vehicle import Vehicle

COAXIAL = 1e-3  # largest distance of the axes of coaxial rotors, as a share of the radius


@dataclass(frozen=True, eq=False)
class Judged:
    """Results of a candidate on an aircraft.

    Attributes
    ----------
    candidate : Candidate
        Propeller with its section constants.
    score : float
        Score of the task, in its unit; NaN for an infeasible task.
    deviation : float
        Standard deviation of the score from uncertain section constants; NaN if not known.
    hover_power, cruise_power : float
        Electrical power, or shaft power if the vehicle has no motor [W].  ``cruise_power`` is NaN
        for a task without a speed.
    hover_time, cruise_time : float
        Flight time on one battery [s]; NaN without a battery.
    thrust_margin : float
        Thrust margin in hover; NaN without a known limit of the motors.
    top_speed : float
        Top speed [m/s]; NaN if it was not computed, if no limit was reached, or if it is unknown.
    limit : str
        Status above the top speed.
    why_not : str
        Reason why the task is infeasible; empty for a feasible task.
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
        """Whether the aircraft can fly the task with this candidate."""
        return not self.why_not


class Ranking:
    """Ranking of candidates for a task of a vehicle.

    Parameters
    ----------
    vehicle : Vehicle
        Vehicle; each candidate replaces its propeller.
    task : Task
        Task of the aircraft.
    corrections : tuple of Correction
        Corrections of the models.  A model whose section constants were fitted with known
        corrections uses the corrections of the fit instead.
    maximum_rotor_speed : float
        Largest rotor speed [rad/s].
    charge : float
        State of charge at which the limits of the powertrain are computed, above 0, at most 1.
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
        """Return the results of all candidates, best first, infeasible candidates last.

        Parameters
        ----------
        candidates : sequence of Candidate
            Candidates to rank.
        progress : callable, optional
            Function that is called after each candidate.
        workers : Workers, optional
            Workers for the candidates; by default threads of this process.

        Returns
        -------
        list of Judged
            Feasible candidates by score, then infeasible candidates by thrust margin.
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
        """Return the results with the standard deviations of their scores.

        Each candidate is trimmed again for one change along each principal axis of the covariance
        of its section constants.

        Parameters
        ----------
        judged : sequence of Judged
            Results of the method ``judged``.
        progress : callable, optional
            Function that is called after each candidate.
        workers : Workers, optional
            Workers for the candidates; by default threads of this process.

        Returns
        -------
        list of Judged
            Results with deviations, in the same order.
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
        """Return the results of ``work`` for each item of ``of``, in order."""
        found = []
        for one in (workers or InThreads(cores())).results(work, self, of):
            found.append(one)
            if progress is not None:
                progress()
        return in_order(found)

    def aircraft(self, candidate: Candidate) -> Aircraft:
        """Return the aircraft with the ``candidate``."""
        air = self.vehicle.air
        vehicle = replace(self.vehicle, propeller=candidate.propeller)
        own = getattr(candidate.airfoil, "corrections", None)
        corrections = self.corrections if own is None else ()
        rotor = Rotor(Model(candidate.propeller, candidate.airfoil, air, corrections))
        return Aircraft(
            vehicle, rotor, maximum_rotor_speed=self.maximum_rotor_speed, charge=self.charge
        )

    def judge(self, candidate: Candidate) -> Judged:
        """Return the results of one ``candidate``, without the deviation of its score."""
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
        """Return the first-order standard deviation of the score of ``judged``; NaN if unknown."""
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
        """Return the score, or NaN and the reason."""
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
            return math.nan, "the vehicle has no battery, or its voltage is too low"
        return (time * task.probed_speed if task.ranked_by == "range" else time), ""

    def _why_not(self, states: SteadyStates) -> str:
        words = ("hover", f"{self.task.probed_speed:g} m/s")
        asked = (True, self.task.name == "cruise")
        for k, what in enumerate(words):
            if asked[k] and not states.found[k]:
                status = str(states.status[k])
                used = states.used.get(status)
                more = f" ({100.0 * used[k]:.0f} % of the limit)" if used is not None else ""
                margin = float(states.thrust_margin[k])
                if math.isfinite(margin):
                    needed = "the needed thrust" if k else "the weight"
                    more += f"; thrust is {margin:.2f} of {needed}"
                return f"{what}: {STATUSES[status]}{more}"
        margin = float(states.thrust_margin[0])
        if margin < self.task.thrust_margin:
            return f"thrust margin in hover is {margin:.2f}, less than {self.task.thrust_margin:g}"
        return ""


def _overlap(vehicle: Vehicle, radius: float) -> str:
    """Return the reason if disks of ``radius`` [m] overlap, except coaxial disks; "" otherwise."""
    height, across = hub_distances(vehicle)
    beside = np.triu((across > COAXIAL * radius) & (height < radius), 1)
    closest = float(across[beside].min(initial=math.inf))
    if closest >= 2.0 * radius:
        return ""
    return f"the rotors overlap: hub distance {closest:.3g} m, disk diameter {2.0 * radius:.3g} m"


# --- Uncertainty of a ranking, and Pareto front of hover power and top speed ---------------------


def beats(better: Judged, worse: Judged) -> float:
    """Return the probability that one candidate is better than another.

    Only the uncertainty of the section constants counts.  Errors of the model are ignored, because
    they are similar for both candidates.  Constants of different propellers come from different
    data and are assumed to be independent.

    Parameters
    ----------
    better, worse : Judged
        Results with deviations; ``better`` is ahead of ``worse`` in the ranking.

    Returns
    -------
    float
        Probability; NaN if one of them has no deviation.
    """
    spread = math.hypot(better.deviation, worse.deviation)
    gap = abs(worse.score - better.score)
    if not math.isfinite(spread):
        return math.nan
    return 0.5 * (1.0 + math.erf(gap / (spread * math.sqrt(2.0)))) if spread > 0.0 else 1.0


def pareto(judged: Sequence[Judged]) -> NDArray[np.intp]:
    """Return the indices of the feasible results on the Pareto front of least hover power and
    highest top speed, in the order of hover power."""
    power = np.array([one.hover_power if one.feasible else math.nan for one in judged])
    speed = np.array([one.top_speed if one.feasible else math.nan for one in judged])
    less, faster = power[:, None] < power, speed[:, None] > speed
    no_worse = (power[:, None] <= power) & (speed[:, None] >= speed)
    beaten = (no_worse & (less | faster)).any(axis=0)
    front = np.flatnonzero(np.isfinite(power + speed) & ~beaten)
    return front[np.argsort(power[front], kind="stable")]


# --- Candidates: propellers with the constants of their sections ---------------------------------


@dataclass(frozen=True, eq=False)
class Candidate:
    """Propeller with section constants, for a ranking."""

    name: str  # name in the catalogue, or path of the file
    propeller: Propeller
    airfoil: Section
    covariance: SectionCovariance | None = None  # covariance of the section constants
    verdict: str = "good"  # "good", or a fault of the constants

    def varied(self) -> list[Candidate]:
        """Return candidates with constants changed by one standard deviation along each principal
        axis of the covariance.

        If a constant would leave its bounds, the change has the other sign, or is omitted.
        """
        if self.covariance is None or not isinstance(self.airfoil, Airfoil):
            return []
        own = [name for name in self.covariance.names if name in CONSTANTS]
        known = self.covariance.of(own).determined
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
    """Return the propellers with identified constants as candidates.

    Parameters
    ----------
    diameter : tuple of 2 float
        Least and largest diameter [m].
    blades : int, optional
        Number of blades; by default any.

    Returns
    -------
    list of Candidate
        Candidates in the order of the catalogue.

    Raises
    ------
    InputError
        If no propeller matches.
    """
    low, high = diameter
    found = []
    for one in all_identified():
        if blades not in (None, one.blades):
            continue
        blade = propeller(one.propeller, one.blades)
        # The catalogue rounds diameters: 10 in may differ from 0.254 m.
        if low - 1e-6 <= blade.diameter <= high + 1e-6:
            name = one.propeller if one.blades == 2 else f"{one.propeller}, {one.blades} blades"
            known = SectionCovariance(PARAMETERS, one.covariance)
            found.append(Candidate(name, blade, one.airfoil, known, one.verdict))
    if not found:
        fault = "no propeller of the catalogue has a diameter of "
        fault += f"{low / INCH:.3g} to {high / INCH:.3g} in"
        fault += f" and {blades} blades" if blades else ""
        raise InputError(fault, "choose another diameter or number of blades, see `propmap props`")
    return found


def file_candidate(path: str | os.PathLike[str], section: Section | None = None) -> Candidate:
    """Return the propeller of a file or a name, with a section law, as a candidate.

    Parameters
    ----------
    path : path or str
        Propeller, as for ``propmap.propeller``.
    section : Section, optional
        Section law; by default the best known constants, see ``propmap.catalogue_model``.

    Returns
    -------
    Candidate
        Candidate with the path as its name.
    """
    blade = propeller(path)
    law, verdict = section, "section law as given"
    if law is None:
        meant = meant_by(path)
        own = own_constants(meant, blade.blades)
        law = own.airfoil if own else predicted_constants(meant, blade).airfoil
        verdict = own.verdict if own else "predicted constants, not identified"
    known = getattr(law, "uncertainty", None)
    return Candidate(os.fspath(path), blade, law, known and known.covariance, verdict)


MEASURES = {
    "hover": {"energy": "power in hover", "time": "time in hover on one battery"},
    "cruise": {
        "energy": "energy per distance at the given airspeed",
        "time": "time at the given airspeed on one battery",
        "range": "distance at the given airspeed on one battery",
    },
    "fast": {"speed": "top speed"},
    "mission": {"energy": "energy of the mission"},
}  # measures of the ranking for each task; the first is the default

UNITS = {"energy": "W", "time": "s", "range": "m", "speed": "m/s"}
ENERGIES = {"cruise": "J/m", "mission": "J"}  # units of "energy" for tasks with another unit
SPEED = 10.0  # default speed of comparisons, in addition to hover [m/s]


@dataclass(frozen=True, eq=False)
class Task:
    """Task of an aircraft, which defines the score of a propeller.

    Attributes
    ----------
    name : str
        "hover", "cruise", "fast" or "mission".
    speed : float or None
        Cruise speed [m/s]; None for a task without speed.
    mission : Mission or None
        Mission of the task "mission".
    thrust_margin : float
        Least thrust margin in hover, if the thrust margin is known.
    measure : str
        "energy" or "time" for "hover"; "energy", "time" or "range" for "cruise"; "speed" for
        "fast"; "energy" for "mission".  An empty text selects the first.

    Raises
    ------
    InputError
        For an unknown name or measure, or a thrust margin below 1.  For a speed that is missing or
        not positive.  For a mission that is missing or belongs to another task.
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
            raise InputError("the task cruise has no speed", "give a speed in m/s, or task hover")
        if self.speed is not None and not self.speed > 0.0:
            raise InputError(f"the speed is {self.speed:g} m/s", "give a speed above 0")
        if (self.name == "mission") != (self.mission is not None):
            remedy = "give a mission for the task mission, and only for this task"
            raise InputError("the task and the mission do not match", remedy)
        if not self.thrust_margin >= 1.0:
            found = f"the thrust margin is {self.thrust_margin:g}"
            raise InputError(found, "give 1 or more, because thrust must carry the weight")
        known = MEASURES[self.name]
        if self.measure and self.measure not in known:
            found = f"the task {self.name} cannot be ranked by {self.measure}"
            raise InputError(found, f"rank it by {' or '.join(known)}")

    @property
    def ranked_by(self) -> str:
        """Key in ``MEASURES`` of the measure that ranks candidates."""
        return self.measure or next(iter(MEASURES[self.name]))

    @property
    def words(self) -> str:
        """Description of the measure that ranks candidates."""
        return MEASURES[self.name][self.ranked_by]

    @property
    def unit(self) -> str:
        """Unit of a score."""
        unit = UNITS[self.ranked_by]
        return ENERGIES.get(self.name, unit) if self.ranked_by == "energy" else unit

    @property
    def probed_speed(self) -> float:
        """Speed at which propellers are compared, in addition to hover [m/s]."""
        return SPEED if self.speed is None else self.speed
