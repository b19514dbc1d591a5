"""What an aircraft is for, and what propellers are ranked by."""

from __future__ import annotations

from dataclasses import dataclass

from propmap.aircraft.mission import Mission
from propmap.errors import InputError

MEASURES = {
    "hover": {"energy": "power in hover", "time": "time in hover on one battery"},
    "cruise": {
        "energy": "energy per distance at the speed",
        "time": "time at the speed on one battery",
        "range": "distance at the speed on one battery",
    },
    "fast": {"speed": "top speed"},
    "mission": {"energy": "energy of the mission"},
}
"""What candidates may be ranked by for each task, the first by default."""

UNITS = {"energy": "W", "time": "s", "range": "m", "speed": "m/s"}
ENERGIES = {"cruise": "J/m", "mission": "J"}
"""Of scores: of the measures, and of the energy of tasks that are not held."""

SPEED = 10.0
"""[m/s] at which propellers are looked at besides hover where no speed is asked for."""


@dataclass(frozen=True, eq=False)
class Task:
    """What an aircraft is for.

    Attributes
    ----------
    name : str
        A key of ``MEASURES``.
    speed : float or None
        Of the cruise [m/s]; None where the task has none.
    mission : Mission or None
        For the task "mission".
    thrust_margin : float
        That hover must leave.
    measure : str
        Of the task's ``MEASURES``; empty for the first.

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
            raise InputError(
                f"the thrust margin is {self.thrust_margin:g}",
                "give 1 or more: with less thrust than weight nothing flies",
            )
        known = MEASURES[self.name]
        if self.measure and self.measure not in known:
            raise InputError(
                f"the task {self.name} is not ranked by {self.measure}",
                f"choose from {', '.join(known)}",
            )

    @property
    def ranked_by(self) -> str:
        """A key of its ``MEASURES``."""
        return self.measure or next(iter(MEASURES[self.name]))

    @property
    def most_is_best(self) -> bool:
        """Whether the largest score is the best."""
        return self.ranked_by != "energy"

    @property
    def words(self) -> str:
        """What is ranked by."""
        return MEASURES[self.name][self.ranked_by]

    @property
    def unit(self) -> str:
        """Of a score."""
        unit = UNITS[self.ranked_by]
        return ENERGIES.get(self.name, unit) if self.ranked_by == "energy" else unit

    @property
    def probed_speed(self) -> float:
        """At which propellers are looked at besides hover [m/s]."""
        return SPEED if self.speed is None else self.speed
