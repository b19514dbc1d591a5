"""Which propeller an aircraft flies best with: every candidate judged, feasible ones first."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from propmap.aircraft.candidates import Candidate
from propmap.aircraft.mission import fly as fly_mission
from propmap.aircraft.performance import endurance
from propmap.aircraft.steady import Aircraft
from propmap.aircraft.steady_states import STATUSES, SteadyStates
from propmap.aircraft.task import Task
from propmap.aircraft.top_speed import top_speed
from propmap.model.corrections import Correction
from propmap.model.model import Model
from propmap.rotor import Rotor
from propmap.tasks import InThreads, Workers, cores, in_order
from propmap.vehicle.vehicle import Vehicle

ALONE = 1e-3
"""Distance of two axes over the radius below which rotors are one above the other [-]."""


@dataclass(frozen=True, eq=False)
class Judged:
    """A candidate on an aircraft.

    Attributes
    ----------
    candidate : Candidate
        The propeller.
    score : float
        Of the task, in its unit; NaN where it is not feasible.
    deviation : float
        Standard deviation of the score from that of the constants; NaN where it is not known.
    hover_power, cruise_power : float
        Electrical if known, else of the shafts [W]; the second is NaN where the task has no speed.
    hover_time, cruise_time : float
        On one battery [s]; NaN without one.
    thrust_margin : float
        In hover.
    top_speed : float
        [m/s]; NaN where it was not looked for or no limit was met.
    limit : str
        Of the top speed, a status.
    why_not : str
        In words; empty where it is feasible.
    """

    candidate: Candidate
    score: float
    deviation: float
    hover_power: float
    cruise_power: float
    hover_time: float
    cruise_time: float
    thrust_margin: float
    top_speed: float
    limit: str
    why_not: str

    @property
    def feasible(self) -> bool:
        """Whether the task can be flown with it."""
        return not self.why_not


class Ranking:
    """Judges candidates.

    Parameters
    ----------
    vehicle : Vehicle
        With any propeller; candidates take its place.
    task : Task
        What it is for.
    corrections : tuple of Correction
        Of all models; candidates whose constants know their own keep them.
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
        """All candidates, the best first, then those that are not feasible, by thrust margin.

        Parameters
        ----------
        candidates : sequence of Candidate
            To choose from.
        progress : callable, optional
            Called after each.
        workers : Workers, optional
            Who judges; by default threads of this process.
        """
        found = self._each(_judge, candidates, progress, workers)
        sign = -1.0 if self.task.most_is_best else 1.0
        order = sorted(
            range(len(found)),
            key=lambda k: (
                (False, sign * found[k].score)
                if found[k].feasible
                else (True, -np.nan_to_num(found[k].thrust_margin))
            ),
        )
        return [found[k] for k in order]

    def with_deviations(
        self,
        judged: Sequence[Judged],
        progress: Callable[[], None] | None = None,
        workers: Workers | None = None,
    ) -> list[Judged]:
        """The same with the standard deviation of the scores, from seven more trims of each.

        Parameters
        ----------
        judged : sequence of Judged
            Candidates, as ``judged`` gives them.
        progress : callable, optional
            Called after each.
        workers : Workers, optional
            Who computes; by default threads of this process.
        """
        deviations = self._each(_deviation, judged, progress, workers)
        return [replace(one, deviation=d) for one, d in zip(judged, deviations, strict=True)]

    def _each(
        self,
        work: Callable[[Ranking, Any], Any],
        of: Sequence[Any],
        progress: Callable[[], None] | None,
        workers: Workers | None,
    ) -> list[Any]:
        """``work`` of each, in order."""
        found = []
        for one in (workers or InThreads(cores())).results(work, self, of):
            found.append(one)
            if progress is not None:
                progress()
        return in_order(found)

    def aircraft(self, candidate: Candidate) -> Aircraft:
        """The vehicle with the ``candidate``."""
        air = self.vehicle.air
        vehicle = replace(self.vehicle, propeller=candidate.propeller)
        own = getattr(candidate.airfoil, "corrections", None)
        corrections = self.corrections if own is None else ()
        model = Model(candidate.propeller, candidate.airfoil, air, corrections)
        rotor = Rotor(model)
        return Aircraft(
            vehicle, rotor, maximum_rotor_speed=self.maximum_rotor_speed, charge=self.charge
        )

    def judge(self, candidate: Candidate) -> Judged:
        """One ``candidate``, without the deviation of its score."""
        overlap = _overlap(self.vehicle, candidate.propeller.radius)
        if overlap:
            return _refused(candidate, overlap)
        craft, task = self.aircraft(candidate), self.task
        states = craft.steady([0.0, task.probed_speed])
        time = endurance(craft, states)
        cruises = task.speed is not None
        why_not = self._why_not(states)
        top, limit = math.nan, ""
        if not why_not:
            top, limit = top_speed(craft, states, 0.0)
        score = math.nan
        if not why_not:
            score, why_not = self._score(craft, states, top)
        return Judged(
            candidate,
            score,
            math.nan,
            float(states.power[0]),
            float(states.power[1]) if cruises else math.nan,
            float(time[0]),
            float(time[1]) if cruises else math.nan,
            float(states.thrust_margin[0]),
            top,
            limit,
            why_not,
        )

    def deviation(self, judged: Judged) -> float:
        """Standard deviation of the score of one ``judged``, to first order; NaN if not known."""
        if not judged.feasible or judged.candidate.covariance is None:
            return math.nan
        changes = [self._score_of(one) - judged.score for one in judged.candidate.varied()]
        return math.sqrt(sum(change**2 for change in changes)) if changes else math.nan

    def _score_of(self, candidate: Candidate) -> float:
        craft = self.aircraft(candidate)
        states = craft.steady([0.0, self.task.probed_speed], margin=False)
        top = math.nan
        if self.task.name == "fast":
            top, _ = top_speed(craft, states, 0.0)
        return self._score(craft, states, top)[0]

    def _score(self, craft: Aircraft, states: SteadyStates, top: float) -> tuple[float, str]:
        """The score, and why there is none."""
        task = self.task
        if task.name == "fast":
            return top, "" if math.isfinite(top) else "no top speed was found"
        if task.mission is not None:
            flown = fly_mission(craft, task.mission)
            lost = ~flown.lasted
            if lost.any():
                leg = int(np.argmax(lost))
                return math.nan, f"leg {leg + 1}: {flown.told(leg)}"
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


def _judge(ranking: Ranking, candidate: Candidate) -> Judged:
    return ranking.judge(candidate)


def _deviation(ranking: Ranking, judged: Judged) -> float:
    return ranking.deviation(judged)


def _refused(candidate: Candidate, why: str) -> Judged:
    unknown = math.nan
    return Judged(
        candidate, unknown, unknown, unknown, unknown, unknown, unknown, unknown, unknown, "", why
    )


def _overlap(vehicle: Vehicle, radius: float) -> str:
    """Why disks of this radius do not fit beside each other on the vehicle; empty where they do.

    Rotors one above the other, on one axis, may have any radius.
    """
    place = np.array([mount.position for mount in vehicle.mounts])
    axis = np.array([mount.axis for mount in vehicle.mounts])
    closest = math.inf
    for k in range(len(place)):
        for j in range(k):
            apart = place[k] - place[j]
            height = float(apart @ axis[k])
            across = float(np.linalg.norm(apart - height * axis[k]))
            if across > ALONE * radius and abs(height) < radius:
                closest = min(closest, across)
    if closest >= 2.0 * radius:
        return ""
    return f"the rotors overlap: hubs are {closest:.3g} m apart, the disks {2.0 * radius:.3g} m"
