"""What an aircraft is for, and what propellers are ranked by."""

from __future__ import annotations

from dataclasses import dataclass

from propmap.aircraft.mission import Mission
from propmap.errors import InputError

TASKS = {
    "hover": "power in hover [W]",
    "cruise": "energy per distance at the speed [J/m]",
    "fast": "top speed [m/s]",
    "mission": "energy of the mission [J]",
}
"""What candidates are ranked by; the least is best, but for the top speed."""


@dataclass(frozen=True, eq=False)
class Task:
    """What an aircraft is for.

    Attributes
    ----------
    name : str
        A key of ``TASKS``.
    speed : float
        Of the cruise [m/s].
    mission : Mission or None
        For the task "mission".
    thrust_margin : float
        That hover must leave.

    Raises
    ------
    InputError
        For another name, a speed that is not positive, and a missing mission.
    """

    name: str
    speed: float
    mission: Mission | None = None
    thrust_margin: float = 1.5

    def __post_init__(self) -> None:
        if self.name not in TASKS:
            raise InputError(f"the task is {self.name!r}", f"choose from {', '.join(TASKS)}")
        if not self.speed > 0.0:
            raise InputError(f"the speed is {self.speed:g} m/s", "give a speed above 0")
        if (self.name == "mission") != (self.mission is not None):
            raise InputError("the task and the mission do not fit", "give a mission for this task")
        if not self.thrust_margin >= 1.0:
            raise InputError(
                f"the thrust margin is {self.thrust_margin:g}",
                "give 1 or more: with less thrust than weight nothing flies",
            )
