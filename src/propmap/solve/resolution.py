"""Numbers of azimuth and radial nodes of one evaluation."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Resolution:
    """Numbers of nodes of one evaluation; static under ``jit``.

    Attributes
    ----------
    azimuths : int
        Azimuth nodes over a full turn, even; or 1 for axial flow.
    stations : int
        Radial nodes on the whole blade, at least 16.
    follow_stall : bool
        Whether radial panels are split where the inflow jumps, see ``solve.split``.  Needed where
        some of the blade stalls, as in hover.

    Raises
    ------
    ValueError
        If a number is not allowed.
    """

    azimuths: int = 48
    stations: int = 48
    follow_stall: bool = True

    def __post_init__(self) -> None:
        if self.azimuths != 1 and (self.azimuths < 4 or self.azimuths % 2):
            raise ValueError(
                f"azimuths is {self.azimuths}: it must be 1 (axial flow) or an even number >= 4"
            )
        if self.stations < 16:
            raise ValueError(f"stations is {self.stations}: it must be at least 16")

    @property
    def panels(self) -> tuple[int, ...]:
        """Radial nodes on each panel, from the root outwards."""
        if not self.follow_stall:
            return (self.stations,)
        inner, middle = self.stations // 4, 3 * self.stations // 8
        return (inner, middle, self.stations - inner - middle)
