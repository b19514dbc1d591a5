"""What corrections change in the rotor drag of the APC 8x6E, one after the other."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from propmap.model.airfoil import parameter_set
from propmap.model.corrections import correction
from propmap.model.model import Model
from propmap.papers.gill_dandrea_2017.blades import TUNNEL_PROPELLER, blade
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import RPM

SECTION = "paper-apc"
"""The set of Table I for this propeller, as printed."""

ADDED = ("pitt-peters", "blade-to-hub", "radial-friction")
"""Corrections in the order in which they are added to the paper's physics."""

ROTATION = 6000.0 * RPM
"""Omega [rad/s]."""

ANGLES = np.radians([45.0, 60.0, 75.0, 90.0])
"""beta [rad]."""

SPEEDS = np.array([5.0, 10.0, 15.0])
"""V [m/s]."""


@dataclass(frozen=True, eq=False)
class DragEffect:
    """Rotor drag with some corrections; arrays are (angles, speeds).

    Attributes
    ----------
    corrections : tuple of str
        As ``propmap.correction`` reads them; none for the paper's own physics.
    drag : ndarray
        D [N].
    change : ndarray
        D over that of the paper's physics, less 1 [-].
    """

    corrections: tuple[str, ...]
    drag: Floats
    change: Floats


def drag_effects(added: tuple[str, ...] = ADDED) -> list[DragEffect]:
    """The paper's drag, then that with one more of the corrections ``added`` each."""
    paper = Model(blade(TUNNEL_PROPELLER), parameter_set(SECTION))
    points = (ROTATION, SPEEDS[None, :], ANGLES[:, None])
    found: list[DragEffect] = []
    for count in range(len(added) + 1):
        texts = added[:count]
        model = replace(paper, corrections=tuple(correction(text) for text in texts))
        drag = Rotor(model).loads(*points).drag
        first = found[0].drag if found else drag
        found.append(DragEffect(texts, drag, drag / first - 1.0))
    return found
