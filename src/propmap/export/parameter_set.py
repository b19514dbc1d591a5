"""Parameters of an autopilot with what they mean, how sure they are, and where they hold."""

from __future__ import annotations

from dataclasses import dataclass

import propmap
from propmap.aircraft.steady import Aircraft
from propmap.export.drag_fit import Comparison
from propmap.export.inplane_drag import InplaneForces, missing_drag
from propmap.vehicle.vehicle import Vehicle


@dataclass(frozen=True)
class Explained:
    """Parameters of one kind.

    Attributes
    ----------
    title : str
        Their name, with n for the number of a rotor.
    values : dict of str to float or int
        By the names that the firmware knows; whole numbers are int.
    unit : str
        Of the values.
    std : float or None
        Their standard deviation, in the unit; None where it is not known.
    meaning, source, holds : str
        The firmware's equation; where it stands; and where the simplification holds.
    """

    title: str
    values: dict[str, float]
    unit: str
    std: float | None
    meaning: str
    source: str
    holds: str


@dataclass(frozen=True)
class ParameterSet:
    """What is written for one use.

    Attributes
    ----------
    suffix : str
        Of the file's name, as in "quad_px4.params".
    purpose : str
        In a sentence.
    kinds : list of Explained
        The parameters.
    """

    suffix: str
    purpose: str
    kinds: list[Explained]

    @property
    def values(self) -> dict[str, float]:
        """All parameters by name."""
        return {name: value for kind in self.kinds for name, value in kind.values.items()}


@dataclass(frozen=True)
class LeftOut:
    """Parameters that are not written: by name, and ``why`` in a sentence."""

    name: str
    why: str


@dataclass(frozen=True)
class AutopilotParameters:
    """All that an export says.

    Attributes
    ----------
    firmware : str
        Its name.
    sets : list of ParameterSet
        What is written, a file each.
    left_out : list of LeftOut
        What is not.
    comparisons : list of Comparison
        The drag model of the firmware beside the full model, along x and y.
    remarks : list of str
        What else to know, a sentence or more each.
    """

    firmware: str
    sets: list[ParameterSet]
    left_out: list[LeftOut]
    comparisons: list[Comparison]
    remarks: list[str]


Flights = tuple[InplaneForces, InplaneForces]
"""Of a vehicle along x and y."""


def comment_lines(part: ParameterSet, vehicle: Vehicle, target: str) -> list[str]:
    """Lines of text for the head of a parameter file, short enough for ArduPilot's own reader."""
    # AP_Param takes lines of 98 characters and reads what is left over as a line of its own.
    clean = "".join(c if c.isprintable() else "?" for c in vehicle.name)[:50]
    return [
        f"{clean}: {part.purpose}"[:90],
        f"written by propmap {propmap.__version__}; see README-{target}.md for definitions, errors",
    ]


def common_remarks(aircraft: Aircraft) -> list[str]:
    """Sentences on what the drag coefficients of an ``aircraft`` have in them and what not."""
    told = [f"{words[:1].upper()}{words[1:]}." for words in missing_drag(aircraft)]
    if any(mount.axis[2] < 0.9999 for mount in aircraft.vehicle.mounts):
        told.append(
            "Rotors are tilted: what their thrust adds along x and y in forward flight is part of "
            "the fitted coefficients."
        )
    return told
