"""Accuracy settings: how many nodes an operating point gets, and when it gets more."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.typing import Floats

COUNTS = (8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384)
"""Allowed numbers of azimuth nodes over a full turn."""

STALL_WIDTH = 1.0 / 50.0
"""[rad] Width of stall for which ``Accuracy.azimuths`` hold, that of the paper's law."""


@dataclass(frozen=True)
class Accuracy:
    """One accuracy setting.

    Attributes
    ----------
    azimuths : tuple of (float, int)
        Largest advance ratio V sin(beta)/(Omega R), and azimuth nodes over a full turn up to it.
    free, stalled, fast : int
        Radial nodes where nothing stalls, where the panels follow stall, and where stall is spread
        over azimuth or the flow is reversed.
    largest_tail : float
        Largest accepted ``solve.quadrature.tail``, as a share of the loads at rest.  A point with a
        larger one is evaluated again.
    finer : tuple of (int, float)
        Radial nodes of each further evaluation, with stall followed, and its largest tail.
    """

    azimuths: tuple[tuple[float, int], ...]
    free: int
    stalled: int
    fast: int
    largest_tail: float
    finer: tuple[tuple[int, float], ...]

    def azimuths_at(self, advance: Floats | float) -> NDArray[np.int64]:
        """Azimuth nodes over a full turn at an advance ratio > 0 [-]; of its shape."""
        limits, counts = (np.array(column) for column in zip(*self.azimuths, strict=True))
        found: NDArray[np.int64] = counts[np.searchsorted(limits, advance)]
        return found

    def azimuths_again(self, advance: Floats, times: int) -> NDArray[np.int64]:
        """The same for a further evaluation; ``times`` is 1 for the first of these."""
        more = np.searchsorted(COUNTS, self.azimuths_at(advance)) + times - 1
        found: NDArray[np.int64] = np.array(COUNTS)[np.minimum(more, len(COUNTS) - 1)]
        return found

    @property
    def most_azimuths(self) -> int:
        """Largest number of azimuth nodes in a first evaluation."""
        return self.azimuths[-1][1]

    @property
    def with_few_programs(self) -> Accuracy:
        """The setting whose panels that follow stall have the nodes of a further evaluation.

        Such points take longer, but a program of some seconds to compile is saved.
        """
        return replace(self, stalled=self.finer[0][0])

    def for_stall(self, width: float) -> Accuracy:
        """The setting for a section that stalls over another ``width`` [rad] of angle of attack.

        A sharper stall takes more azimuths in proportion, and errs as much at smaller tails.
        """
        sharper = STALL_WIDTH / width
        if sharper <= 1.0 + 1e-9:
            return self
        places = np.searchsorted(
            COUNTS, [count * sharper * (1.0 - 1e-9) for _, count in self.azimuths]
        )
        counts = [COUNTS[min(int(k), len(COUNTS) - 1)] for k in places]
        limits = (limit for limit, _ in self.azimuths)
        return replace(
            self,
            azimuths=tuple(zip(limits, counts, strict=True)),
            largest_tail=self.largest_tail / sharper**2,
            finer=(
                *((nodes, tail / sharper**2) for nodes, tail in self.finer[:-1]),
                self.finer[-1],
            ),
        )


ACCURACIES = {
    "standard": Accuracy(
        (
            (0.03, 8),
            (0.06, 12),
            (0.12, 16),
            (0.18, 24),
            (0.3, 32),
            (0.5, 64),
            (1.0, 96),
            (np.inf, 128),
        ),
        free=24,
        stalled=48,
        fast=64,
        largest_tail=0.028,
        finer=((80, 0.028), (240, 0.05), (960, 0.09)),
    ),
    "fine": Accuracy(
        ((0.1, 32), (0.15, 48), (0.3, 96), (0.5, 192), (1.0, 256), (np.inf, 384)),
        free=96,
        stalled=160,
        fast=160,
        largest_tail=0.004,
        finer=((320, 0.004), (960, 0.01)),
    ),
}
"""``standard``: 0.1 % of static thrust and torque; ``fine``: 0.01 %."""


def accuracy(name: str) -> Accuracy:
    """The setting of that name; ``InputError`` where there is none."""
    if name not in ACCURACIES:
        raise InputError(f"accuracy is {name!r}: it must be one of {', '.join(ACCURACIES)}")
    return ACCURACIES[name]


FOR_DEVIATIONS = Accuracy(
    ((0.12, 12), (0.3, 24), (np.inf, 48)),
    free=24,
    stalled=32,
    fast=32,
    largest_tail=np.inf,
    finer=((32, np.inf),),
)
"""For derivatives that make standard deviations: these come out within 1 % of those of "standard"
nearly everywhere, in half the time or less."""
