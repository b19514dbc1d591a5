"""Loads of the fitted propeller over speed, and what the parameters' uncertainty does to them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from propmap.baselines.hover import HoverModel
from propmap.fit.coverage import CoveredAngle
from propmap.fit.fit_record import FitRecord
from propmap.fit.result_file import FitFile
from propmap.fit.tunnel import TunnelData
from propmap.loads import LOADS
from propmap.report.fit_page.parameter_draws import drawn_changes
from propmap.report.mounted_motor import motor_note
from propmap.report.page import csv_of_columns
from propmap.report.style import (
    COLOURS,
    HOVER,
    MEASURED,
    MODEL,
    RPM,
    key,
    legend_below,
    new_figure,
    style,
)
from propmap.rotor import Rotor
from propmap.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SPEEDS = 26
MOST_ANGLES = 4
BEYOND = 1.25
"""How far the curves go, in units of the data's largest advance ratio."""

UNTESTED = 0.25
"""Advance ratio to which they go where all data are from rest."""

APART = 22.5
"""[deg], closer than which two angles are one."""


NEAR = np.radians(2.5)
"""Of a curve's angle, within which measured points are drawn with it."""

DATA: dict[str, Any] = {"color": "0.92", "linewidth": 0.0}
BAND: dict[str, Any] = {"color": COLOURS[5], "alpha": 0.55, "linewidth": 0.0}
POINTS: dict[str, Any] = {**MEASURED, "color": COLOURS[1], "marker": "o"}


@dataclass(frozen=True, eq=False)
class Curve:
    """Loads at one angle.

    Attributes
    ----------
    beta : float
        The angle [rad].
    covered : tuple of float or None
        Ends of the speeds that the data cover at this angle [m/s].
    loads, low, high : dict of str to ndarray, shape (n,)
        Loads by name, and the ends of their bands; these are None without a band.
    valid : ndarray, shape (n,)
        Where momentum theory holds.
    """

    beta: float
    covered: tuple[float, float] | None
    loads: dict[str, Floats]
    low: dict[str, Floats] | None
    high: dict[str, Floats] | None
    valid: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Curves:
    """Curves at one rotational speed.

    Attributes
    ----------
    omega, radius : float
        Rotational speed [rad/s] and radius of the propeller [m].
    speed : ndarray, shape (n,)
        Flight speeds of all curves [m/s].
    curves : sequence of Curve
        By rising angle.
    hover : dict of str to float
        The hover model's loads by name.
    seen : collection of str
        Loads that the data tell of.
    draws : int
        How many sets of parameters make the bands.
    motor : str
        A sentence on ``motor_note``, empty where the model has what is mounted.
    """

    omega: float
    radius: float
    speed: Floats
    curves: Sequence[Curve]
    hover: dict[str, float]
    seen: Collection[str]
    draws: int
    motor: str

    @property
    def rpm(self) -> float:
        """Rotational speed [1/min]."""
        return self.omega * RPM


def load_curves(file: FitFile) -> Curves:
    """The fitted rotor at the data's typical rotational speed, past the speeds of the data."""
    fit = file.record
    omega = fit.covered.typical_rpm / RPM
    tip = omega * file.model.propeller.radius
    top = max([one.advance[1] for one in fit.covered.main_angles], default=UNTESTED / BEYOND)
    speed = np.linspace(0.0, BEYOND * top * tip, SPEEDS)
    angles = _angles(fit)
    betas = np.radians([beta for beta, _ in angles])

    rotor = Rotor(file.model)
    found = rotor.loads(omega, speed, betas[:, None])
    values, status = np.stack([getattr(found, name) for name in LOADS]), found.status
    names, changes = drawn_changes(fit)
    low, high = values, values
    if len(changes):
        moved = values + np.tensordot(changes, _slopes(rotor, names, omega, speed, betas), 1)
        # The fit may sit in a corner of the bounds, with all draws on one side of it.
        low, high = np.percentile(moved, [2.5, 97.5], axis=0)
        low, high = np.minimum(low, values), np.maximum(high, values)
    curves = [
        Curve(
            beta=float(np.radians(beta)),
            covered=_covered(fit, data, tip),
            loads=_named(values[:, k]),
            low=_named(low[:, k]) if len(changes) else None,
            high=_named(high[:, k]) if len(changes) else None,
            valid=status[k] != "vortex_ring",
        )
        for k, (beta, data) in enumerate(angles)
    ]
    still = HoverModel.of(rotor).loads(omega)
    hover = {name: float(value) for name, value in still.items()}
    motor = motor_note(rotor, found, speed, betas[:, None])
    radius = file.model.propeller.radius
    return Curves(omega, radius, speed, curves, hover, _seen(fit), len(changes), motor)


@style()
def curve_figure(curves: Curves, measured: TunnelData | None) -> Figure:
    """A row per load, a column per angle; with the measured points if there are any."""
    count = len(curves.curves)
    figure = new_figure(max(2.35 * count + 0.6, 8.6), 2.15 * len(LOADS))
    axes = figure.subplots(len(LOADS), count, sharex=True, sharey="row", squeeze=False)
    for row, (name, load) in zip(axes, LOADS.items(), strict=True):
        row[0].set_ylabel(load.title)
        for ax, one in zip(row, curves.curves, strict=True):
            if name in curves.seen and one.covered is not None:
                ax.axvspan(*one.covered, **DATA)
            if one.low is not None and one.high is not None:
                ax.fill_between(curves.speed, one.low[name], one.high[name], **BAND)
            ax.plot(curves.speed, np.full_like(curves.speed, curves.hover[name]), **HOVER)
            look = {**MODEL, "color": COLOURS[0]}
            ax.plot(curves.speed, np.where(one.valid, one.loads[name], np.nan), **look)
            if not one.valid.all():
                ring = np.where(one.valid, np.nan, one.loads[name])
                ax.plot(curves.speed, ring, **{**look, "linestyle": ":"})
            if measured is not None and name in measured.loads:
                _points(ax, curves, one, name, measured)
    for ax, one in zip(axes[0], curves.curves, strict=True):
        data = "" if one.covered else ", no data"
        ax.set_title(f"β = {np.degrees(one.beta):.0f}°{data}", fontsize=9.0)
    for ax in axes[-1]:
        ax.set_xlabel("flight speed V [m/s]")
        ax.set_xlim(0.0, curves.speed[-1])
    handles = [
        key("this model", color=COLOURS[0], **MODEL),
        *([Patch(label="95 % by the parameters", **BAND)] if curves.draws else []),
        key("hover model", **HOVER),
        Patch(label="covered by the data", **DATA),
        *([key("measured", **{**POINTS, "markersize": 4.0})] if measured is not None else []),
    ]
    legend_below(figure, handles, columns=5)
    return figure


def curve_sheet(curves: Curves) -> str:
    """The curves as CSV."""
    groups = []
    for one in curves.curves:
        low, high = one.covered or (1.0, 0.0)
        group: dict[str, Any] = {
            "beta_deg": np.degrees(one.beta),
            "speed_mps": curves.speed,
            "rpm": curves.rpm,
            "advance_ratio": curves.speed / (curves.omega * curves.radius),
            "covered": ((low <= curves.speed) & (curves.speed <= high)).astype(int),
            "momentum_theory_holds": one.valid.astype(int),
            **{load.column: one.loads[name] for name, load in LOADS.items()},
        }
        for name, load in LOADS.items():
            for end, side in (("low", one.low), ("high", one.high)):
                column = load.column.replace(name, f"{name}_{end}_95")
                group[column] = side[name] if side else None
        group |= {f"hover_{load.column}": curves.hover[name] for name, load in LOADS.items()}
        groups.append(group)
    return csv_of_columns(groups)


def _slopes(
    rotor: Rotor, names: tuple[str, ...], omega: float, speed: Floats, betas: Floats
) -> Floats:
    """Derivatives (P, loads, angles, n) of the loads by the parameters named."""
    b = betas[:, None]
    flow = (omega, speed * np.cos(b), speed * np.abs(np.sin(b)))
    return rotor.gradients(names, *flow).slopes.swapaxes(0, 1)


def _angles(fit: FitRecord) -> list[tuple[float, CoveredAngle | None]]:
    """Up to four angles [deg] with the data's points about them, and edgewise or axial flow where
    there were points at one angle at most."""
    groups = fit.covered.main_angles
    betas = np.array([one.typical_beta for one in groups])
    wanted = np.linspace(betas[0], betas[-1], MOST_ANGLES) if betas.size else betas
    nearest = dict.fromkeys(int(np.argmin(np.abs(betas - beta))) for beta in wanted)
    found: dict[float, CoveredAngle | None] = {groups[k].typical_beta: groups[k] for k in nearest}
    for other in (0.0, 90.0):
        if all(abs(other - beta) > APART for beta in found) and len(found) < MOST_ANGLES:
            found[other] = None
    return sorted(found.items(), key=lambda pair: pair[0])


def _covered(fit: FitRecord, data: CoveredAngle | None, tip: float) -> tuple[float, float] | None:
    if data is None:
        return None
    low = 0.0 if fit.covered.at_rest is not None else data.advance[0]
    return low * tip, data.advance[1] * tip


def _named(values: Floats) -> dict[str, Floats]:
    return dict(zip(LOADS, values, strict=True))


def _points(ax: Axes, curves: Curves, one: Curve, load: str, data: TunnelData) -> None:
    """Points near the curve's angle, at the advance ratio that they were measured at."""
    ratio = curves.omega / np.maximum(data.omega, 1e-9)
    mine = (np.abs(data.folded_beta - one.beta) < NEAR) | (data.speed == 0.0)
    mine &= (data.omega > 0.0) & (data.speed * ratio <= curves.speed[-1])
    loads = data.loads[load] * ratio**2
    ax.plot((data.speed * ratio)[mine], loads[mine], **{**POINTS, "markersize": 2.6})


def _seen(fit: FitRecord) -> Collection[str]:
    """In flight, the loads that make the forces."""
    if fit.kind == "tunnel":
        return [one.name for one in fit.loads]
    return ("thrust",) if fit.kind == "level flight" else ("thrust", "drag")
