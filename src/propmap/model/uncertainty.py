"""How far loads computed with a set of constants may err, and by what."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from propmap.errors import InputError
from propmap.model.section_covariance import SectionCovariance

SOURCES = ("parameters", "geometry", "discrepancy", "tunnel")
"""What a load's error is made of; independent of each other."""

TUNNEL_GAIN = 0.08
"""Standard deviation of a tunnel's readings of one propeller about another tunnel's, as a share of
the load.  Loads identified from the UIUC database differ from those of the 2019 campaign (Gill and
D'Andrea, Drones 3(4):77, doi 10.3390/drones3040077) by 6-18 % in thrust and 3-14 % in torque."""

TUNNEL_TILT = 1.0
"""The same of the thrust's slope by the advance ratio V/(Omega R): 0.10 per 0.1 in axial flow.  In
flow along the disk it is taken to be as large, where one propeller was measured: the 8x6E's thrust
there grows in the campaign of 2019 and falls by the constants of UIUC's axial loads, which stall
earlier (``propmap demo``)."""

INPLANE_SHARES = {"drag": 0.10, "roll_moment": 0.10, "side_force": 0.5, "pitch_moment": 0.5}
"""Standard deviations of what the theory itself errs by in loads that no axial test has seen, as
shares of the load: rotor drag of bare blades is within about 20 % of a free-wake lifting line, of
Ribner's fin analogy and of measurements, rolling moments within 0 to -18 % of the lifting line, and
pitching moments differ by a factor of about 2 (docs/validation.md)."""


UNKNOWN_SHARE = 0.5
"""The same of a load of which there is no such judgement."""

DISCREPANCIES = ("thrust_coefficient", "power_coefficient")
"""Loads of an axial test, as coefficients, and fields of ``SectionUncertainty``."""


@dataclass(frozen=True, eq=False)
class SectionUncertainty:
    """How well a set of section constants is known.

    Attributes
    ----------
    covariance : SectionCovariance
        Of the constants.  Where the blade was not measured it holds what is not known of chord and
        twist, too, as changes of the constants that have the same loads.
    thrust_coefficient, power_coefficient : float
        Standard deviations of the errors of C_T and C_P that the best constants would leave [-].
    another_tunnel : bool
        Whether the constants rest on a tunnel other than the one, or the flight, that the loads
        are to agree with, so that ``TUNNEL_GAIN`` and ``TUNNEL_TILT`` count.
    with_blade : SectionCovariance or None
        What ``covariance`` would be with the blade measured; None where it was.

    Raises
    ------
    InputError
        For a standard deviation that is negative or no number.
    """

    covariance: SectionCovariance
    thrust_coefficient: float = 0.0
    power_coefficient: float = 0.0
    another_tunnel: bool = True
    with_blade: SectionCovariance | None = None

    def __post_init__(self) -> None:
        for name in DISCREPANCIES:
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0.0):
                raise InputError(f"{name} is {value}", "give a standard deviation, 0 or more")
        if self.with_blade is not None and self.with_blade.names != self.covariance.names:
            raise InputError(
                f"the covariances are of {self.with_blade.names} and {self.covariance.names}",
                "give them for the same constants",
            )

    def without(self, name: str) -> SectionUncertainty:
        """The same with the constant ``name`` taken as known."""
        names = [each for each in self.covariance.names if each != name]
        kept = self.covariance.of(names)
        blade = None if self.with_blade is None else self.with_blade.of(names)
        return replace(self, covariance=kept, with_blade=blade)

    def as_dict(self) -> dict[str, Any]:
        """Plain data, as ``filed_uncertainty`` reads it."""
        return {
            "names": list(self.covariance.names),
            "covariance": self.covariance.matrix.tolist(),
            **{name: getattr(self, name) for name in DISCREPANCIES},
            "another_tunnel": self.another_tunnel,
            **({} if self.with_blade is None else {"with_blade": self.with_blade.matrix.tolist()}),
        }


def filed_uncertainty(table: Any) -> SectionUncertainty | None:
    """What the table ``[uncertainty]`` of a parameter file says; None where there is none.

    Parameters
    ----------
    table : mapping or None
        As ``SectionUncertainty.as_dict`` gives it.

    Raises
    ------
    InputError
        Where an entry is missing or of another kind.
    """
    if table is None:
        return None
    try:
        names, other = tuple(map(str, table["names"])), bool(table["another_tunnel"])
        _ = table["covariance"]
        matrices: Any = {
            key: SectionCovariance(names, np.array(table[key], np.float64))
            for key in ("covariance", "with_blade")
            if key in table
        }
        left: Any = {name: float(table[name]) for name in DISCREPANCIES}
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"the table [uncertainty] is damaged ({error})", "remove it, or write the file anew"
        ) from None
    return SectionUncertainty(**matrices, **left, another_tunnel=other)


def fitted_uncertainty(table: Any, names: Collection[str]) -> SectionUncertainty | None:
    """What the table ``[fit]`` of a fit's file says of the constants; None where there is none.

    Parameters
    ----------
    table : mapping or None
        With the names "free", their "covariance", and a table "discrepancy".
    names : collection of str
        Those of the free parameters that belong to the section law.

    Raises
    ------
    InputError
        Where the covariance does not fit the names.
    """
    if not isinstance(table, Mapping):
        return None
    try:
        free, left = table["free"], table.get("discrepancy", {})
        matrix = np.array(table["covariance"], np.float64).reshape(len(free), len(free))
        every = SectionCovariance(tuple(free), matrix)
        kept = [name for name in free if name in names]
        shares: Any = {name: float(left[name]) for name in DISCREPANCIES if name in left}
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(
            f"the table [fit] is damaged: covariance ({error})", "write it again with propmap fit"
        ) from None
    return SectionUncertainty(every.of(kept), **shares, another_tunnel=False)
