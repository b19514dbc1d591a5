"""Steady states as `propmap trim` shows them: tables, lines, and notes on what is odd."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import typer

from propmap.catalogue.identified import Identified, identified
from propmap.cli.aircraft_options import digits, number_or_none
from propmap.cli.output import WideGrid
from propmap.cli.plausibility import say_doubts
from propmap.model.plausibility import doubts_on_points

if TYPE_CHECKING:
    from propmap.aircraft.performance import NamedState, Performance
    from propmap.aircraft.sensitivity import Spread
    from propmap.aircraft.trim import Aircraft, SteadyStates

SPARE = ("throttle [%]", "I motor [A]", "T [N]", "P shaft [W]", "way [km]", "roll [deg]", "rpm")
"""Columns that a narrow window goes without, the first first."""

LEVEL = 1e-4
"""Roll [rad] that is not worth a column."""

NOTHING = 1e-4
"""Unbalanced moment over mass and radius [m/s^2] that is not worth a word."""


def say_moments(craft: Aircraft, flown: list[SteadyStates]) -> None:
    """Say what moments the rotors of ``craft`` cannot balance in the states that are ``flown``.

    They are for a wing's flaps, or of a spin that is wrong.
    """
    left = np.concatenate([np.abs(states.moment) for states in flown])
    if not np.isfinite(left).any():
        return
    largest = np.nanmax(left, axis=0)
    if largest.max() > NOTHING * craft.vehicle.mass * craft.vehicle.propeller.radius:
        told = ", ".join(f"{name} {m:.2g}" for name, m in zip("xyz", largest, strict=True))
        typer.echo(
            f"note: the rotors cannot balance all moments; up to {told} N m about these axes are "
            "left to control surfaces (check position and spin, if there are none)",
            err=True,
        )


def say_beyond_data(craft: Aircraft, flown: list[SteadyStates], where: str = "") -> None:
    """Say what of the states ``flown`` is beyond the data of the constants or unlike propellers.

    ``craft`` is what flies, ``where`` says which states these are, if not all.
    """
    from propmap.rotor import Rotor

    if not isinstance(craft.loads, Rotor):
        return
    blade = craft.vehicle.propeller
    omega, hubs = (
        np.concatenate(each)
        for each in zip(*(craft.rotor_motion(states) for states in flown), strict=True)
    )
    if not omega.size:
        return
    speed = np.linalg.norm(hubs, axis=-1)
    along = np.einsum("nkj,kj->nk", hubs, craft.rotors.axis)
    beta = np.arccos(np.clip(np.divide(along, speed, out=along * 0.0, where=speed > 0.0), -1, 1))
    doubts = doubts_on_points(blade, omega, speed, beta)
    own = identified(blade.name, blade.blades)
    if own is not None and craft.loads.model.airfoil.name == own.airfoil.name:
        doubts = [*doubts, *_beyond(own, omega, speed, blade.diameter)]
    say_doubts([f"{where}{doubt}" for doubt in doubts])


def _beyond(own: Identified, omega: Any, speed: Any, diameter: float) -> list[str]:
    from propmap.aircraft.performance import RPM

    rpm, advance = (
        float(omega.max()) * RPM,
        float((2.0 * np.pi * speed / (omega * diameter)).max()),
    )
    parts = []
    if rpm > own.rpm_high:
        parts.append(f"{rpm:.0f} rpm where the data end at {own.rpm_high:.0f}")
    if advance > own.advance_high:
        parts.append(f"J = V/(n D) up to {advance:.2f} where they end at {own.advance_high:.2f}")
    return [f"beyond the data of the constants: {'; '.join(parts)}"] if parts else []


def say_fastest(craft: Aircraft, states: SteadyStates, found: Performance) -> None:
    """As ``say_beyond_data`` of a top speed that was ``found`` beyond the ``states`` asked for."""
    if found.fastest is not None and found.fastest.speed > states.speed[-1]:
        climb = states.climb[0]
        there = craft.steady(found.fastest.speed, climb, margin=False, near=states)
        say_beyond_data(craft, [there], "at the top speed, ")


def plain(state: NamedState | None) -> dict[str, float | None] | None:
    """A ``state`` with a name as plain data, None where there is none."""
    return None if state is None else {k: number_or_none(v) for k, v in vars(state).items()}


def table_of(states: SteadyStates, sure: Spread | None, found: Performance | None) -> WideGrid:
    """States in a table.

    Parameters
    ----------
    states : SteadyStates
        At one climb rate and bank.
    sure : Spread, optional
        Their standard deviations.
    found : Performance, optional
        With their times and distances.
    """
    rpm = states.rotor_speed * 30.0 / math.pi
    heads, columns = ["V [m/s]", "pitch [deg]"], [[f"{v:.4g}" for v in states.speed]]
    columns.append([digits(v) for v in np.degrees(states.pitch)])
    if np.nanmax(np.abs(np.nan_to_num(states.roll))) > LEVEL:
        heads.append("roll [deg]")
        columns.append([digits(v) for v in np.degrees(states.roll)])
    heads += ["rpm", "T [N]", "P shaft [W]"]
    columns += [
        [_span(each) for each in rpm],
        [digits(v) for v in states.thrust.sum(axis=1)],
        [digits(v) for v in states.shaft_power],
    ]
    electric = bool(np.isfinite(states.electrical_power).any())
    deviations = [] if sure is None else [[_rough(v) for v in sure.power]]
    if deviations and not electric:
        heads.append("+- [W]")
        columns += deviations
    if electric:
        heads += ["P electric [W]", *(["+- [W]"] if deviations else []), "I motor [A]"]
        columns += [
            [digits(v) for v in states.electrical_power],
            *deviations,
            [digits(v) for v in states.motor_current.max(axis=1)],
        ]
    if np.isfinite(states.throttle).any():
        heads.append("throttle [%]")
        columns.append([digits(v) for v in 100.0 * states.throttle.max(axis=1)])
    if found is not None and np.isfinite(found.endurance).any():
        heads += ["time [min]", "way [km]"]
        columns += [
            [digits(v) for v in found.endurance / 60.0],
            [digits(v) for v in found.distance / 1000.0],
        ]
    heads += ["thrust margin", "<status"]
    columns += [[digits(v) for v in states.thrust_margin], states.status.tolist()]
    climb, bank = float(states.climb[0]), math.degrees(float(states.bank[0]))
    title = f"climb {climb:g} m/s" if climb else (f"bank {bank:g} deg" if bank else "level flight")
    caption = "rpm: slowest to fastest rotor; thrust margin: T at the first limit over T needed"
    if deviations:
        caption += "\n+-: one standard deviation of the power, from those of the rotors' loads"
    from propmap.aircraft.trim import STATUSES

    met = [status for status in STATUSES if status != "ok" and status in states.status]
    caption += "".join(f"\n{status}: {STATUSES[status]}" for status in met)
    return WideGrid("|".join(heads), list(zip(*columns, strict=True)), title, caption, SPARE)


def _rough(std: float) -> str:
    # Two digits, without an exponent.
    return f"{float(f'{std:.2g}'):g}" if math.isfinite(std) else "-"


def _give_or_take(std: float) -> str:
    return f" +- {_rough(std)}" if math.isfinite(std) else ""


def _span(rpm: Any) -> str:
    if not np.isfinite(rpm).all():
        return "-"
    low, high = f"{rpm.min():.0f}", f"{rpm.max():.0f}"
    return low if low == high else f"{low}-{high}"


def named(found: Performance) -> list[tuple[str, str, NamedState | None]]:
    """Key, words and state of each that was ``found``."""
    return [
        ("hover", "hover", found.hover),
        ("least_power", "least power, longest time", found.least_power),
        ("best_range", "best range", found.best_range),
        ("fastest", "top speed", found.fastest),
    ]


def told(found: Performance | None) -> list[str]:
    """Lines on the states that have a name."""
    if found is None:
        return []
    from propmap.aircraft.performance import FASTEST
    from propmap.aircraft.trim import LIMITS, STATUSES

    lines = []
    climbs = bool(found.states.climb[0])
    for name, label, state in named(found):
        words = "straight up or down" if climbs and name == "hover" else label
        if state is None:
            if name == "fastest" and not found.limit:
                lines.append(f"{words}: above {FASTEST:g} m/s, no limit was met")
            else:
                why = found.at_rest if name == "hover" else found.limit
                lines.append(f"{words}: none; {STATUSES.get(why, 'not found')}")
            margin = float(found.states.thrust_margin[0])
            if name == "hover" and found.states.speed[0] == 0.0 and margin < 1.0:
                lines[-1] += f"; it cannot lift off, thrust is {margin:.2f} of the weight"
            continue
        kind = "" if math.isfinite(state.electrical_power) else "shaft "
        parts = [
            f"{state.speed:.3g}{_give_or_take(state.speed_std)} m/s",
            f"{state.power:.4g}{_give_or_take(state.power_std)} W {kind}power",
        ]
        if name == "hover":
            parts = parts[1:]
        if name == "best_range":
            parts.append(f"{state.power / state.ground_speed:.3g} J/m")
        if name == "fastest":
            parts.append(f"limited by {LIMITS.get(found.limit) or STATUSES[found.limit]}")
        elif math.isfinite(state.endurance):
            time, std = state.endurance / 60.0, state.endurance_std / 60.0
            parts.append(f"{time:.3g}{_give_or_take(std)} min")
            if name == "best_range":
                way, std = state.distance / 1000.0, abs(state.ground_speed) * std * 0.06
                parts.append(f"{way:.3g}{_give_or_take(std)} km")
        lines.append(f"{words}: {', '.join(parts)}")
    return lines
