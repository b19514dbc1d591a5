"""Panels of loads along curves: bands, points by status, measured points."""

from __future__ import annotations

from collections.abc import Mapping
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np

from propmap.baselines.hover import HoverModel
from propmap.explore import figures
from propmap.explore.controls import Values
from propmap.fit.tunnel import TunnelData
from propmap.io.operating_points import RPM
from propmap.report.html import COLOURS
from propmap.results import Loads
from propmap.typing import Floats

WIDE = NormalDist().inv_cdf(0.975)
"""Standard deviations on either side of a band that holds 95 %."""

SAME_RPM, SAME_SPEED, SAME_ANGLE = 0.01, 0.03, 0.5
"""How near a measured point must be to a curve to be drawn with it: shares, and degrees."""


class Curves(NamedTuple):
    """Operating points (k, n) of k curves of n points, and how they are called."""

    x: Floats
    omega: Floats
    speed: Floats
    beta: Floats
    names: tuple[str, ...]


def panel(
    name: str,
    values: Values,
    curves: Curves,
    loads: Loads,
    hover: HoverModel,
    std: Mapping[str, Floats],
    data: TunnelData | None,
    near: list[Any],
    *,
    words: bool,
) -> figures.Figure:
    """A load along all curves.

    Parameters
    ----------
    name : str
        Of the load, or "power".
    values : Values
        What is set.
    curves : Curves
        Where.
    loads : Loads
        There, fields of shape (k, n).
    hover : HoverModel
        To compare with.
    std : mapping of str to ndarray, shape (k, n)
        Standard deviations by load; may be empty.
    data : TunnelData or None
        Measured points.
    near : list of ndarray
        Which of these belong to each curve, from ``near_curves``.
    words : bool
        Whether all numbers are told at each point, and points are marked by their status.
    """
    found: Floats = getattr(loads, name)
    traces: list[dict[str, Any]] = []
    if name in std:
        for k, row in enumerate(found):
            half = WIDE * std[name][k]
            traces.append(figures.band(curves.x, row - half, row + half, COLOURS[k]))
    for k, row in enumerate(found):
        more: dict[str, Any] = {
            "hovertemplate": f"%{{x:.4g}}: %{{y:.4g}}<extra>{curves.names[k]}</extra>"
        }
        if words:
            more = {"text": _words(curves, loads, k), "hovertemplate": "%{text}<extra></extra>"}
        traces.append(figures.line(curves.x, row, curves.names[k], COLOURS[k], **more))
    still = hover.loads(curves.omega[0])
    torque = np.asarray(still["torque"])
    height = torque * curves.omega[0] if name == "power" else still[name]
    drawn = np.broadcast_to(height, curves.x.shape)
    traces.append(figures.line(curves.x, drawn, "hover model", figures.GREY, "dash"))
    shown = [found, drawn]
    if data is not None:
        measured, heights = _measured(name, values["x"], curves, data, near)
        traces += measured
        shown.append(heights)
    if words:
        traces += _by_status(curves, loads, found)
    own = {"speed": values["speed"], "rpm": values["rpm"], "beta": values["beta"]}[values["x"]]
    label = {"speed": "speed V [m/s]", "rpm": "rpm", "beta": "angle β [deg]"}[values["x"]]
    return figures.figure(
        traces,
        label,
        figures.TITLES[name],
        revision=f"{values['x']}",
        shapes=[figures.upright(own)],
        xaxis={"range": [float(curves.x[0]), float(curves.x[-1])]},
        yaxis=figures.span(*shown, zero=True),
    )


def _words(curves: Curves, loads: Loads, k: int) -> list[str]:
    """All numbers of the points of a curve."""
    rows = []
    for i in range(curves.x.size):
        told = [
            f"{curves.omega[k, i] / RPM:.0f} rpm, {curves.speed[k, i]:.4g} m/s, "
            f"β {np.degrees(curves.beta[k, i]):.4g}°: {loads.status[k, i]}"
        ]
        told += [
            f"{figures.LABELS[n]} {figures.digits(getattr(loads, n)[k, i])} {figures.UNITS[n]}"
            for n in figures.TITLES
        ]
        rows.append("<br>".join(told))
    return rows


def _by_status(curves: Curves, loads: Loads, found: Floats) -> list[dict[str, Any]]:
    traces = []
    x = np.broadcast_to(curves.x, found.shape)
    for status, (mark, colour) in figures.STATUS_MARKS.items():
        which = loads.status == status
        if which.any():
            y = np.where(np.isfinite(found[which]), found[which], 0.0)
            traces.append(
                figures.points(
                    x[which],
                    y,
                    status,
                    colour,
                    mark,
                    hovertemplate=f"%{{x:.4g}}: %{{y:.4g}}<extra>{status}</extra>",
                )
            )
    return traces


def near_curves(curves: Curves, x: str, data: TunnelData) -> list[Any]:
    """Which measured points of ``data`` belong to each of the ``curves`` along ``x``."""
    rpm, beta = data.omega / RPM, np.degrees(data.folded_beta)
    found = []
    for k in range(len(curves.names)):
        w, v, b = curves.omega[k] / RPM, curves.speed[k], np.degrees(curves.beta[k])
        fits = np.ones(len(data), bool)
        if x != "rpm":
            fits &= np.abs(rpm - w[0]) <= SAME_RPM * w[0]
        if x != "speed":
            fits &= np.abs(data.speed - v[0]) <= np.maximum(SAME_SPEED * v[0], 0.05)
        if x != "beta":
            # At rest the angle means nothing: those points go with the first curve.
            at_rest = (data.speed == 0.0) if k == 0 else False
            fits &= (np.abs(beta - b[0]) < SAME_ANGLE) | at_rest
        found.append(np.flatnonzero(fits))
    return found


def _measured(
    name: str, x: str, curves: Curves, data: TunnelData, near: list[Any]
) -> tuple[list[dict[str, Any]], Floats]:
    values = data.loads.get(name)
    if name == "power" and "torque" in data.loads:
        values = data.loads["torque"] * data.omega
    if values is None:
        return [], np.empty(0)
    along = {"speed": data.speed, "rpm": data.omega / RPM, "beta": np.degrees(data.folded_beta)}[x]
    inside = (along >= curves.x[0]) & (along <= curves.x[-1])
    # One trace for all: each costs some milliseconds of every step.
    mine = [which[inside[which]] for which in near]
    curve = np.repeat(np.arange(len(near)), [which.size for which in mine])
    every = np.concatenate(mine) if mine else np.empty(0, int)
    trace = figures.points(along[every], values[every], f"measured: {data.source}", COLOURS[0])
    trace["marker"] = {
        "color": [COLOURS[k] for k in curve],
        "symbol": [figures.MARKS[k] for k in curve],
        "size": 7,
    }
    trace["text"] = [curves.names[k] for k in curve]
    trace["hovertemplate"] = "%{x:.4g}: %{y:.4g}<extra>measured, %{text}</extra>"
    return [trace], values[every]


def nothing_near(data: TunnelData, values: Values) -> str:
    """Why none of the ``data`` is drawn with what ``values`` are set."""
    rpm = data.omega / RPM
    if values["x"] != "rpm":
        nearest = rpm[np.argmin(np.abs(rpm - values["rpm"]))]
        if abs(nearest - values["rpm"]) > SAME_RPM * values["rpm"]:
            return f"{data.source}: no row within 1 % of {values['rpm']:g} rpm; try {nearest:.0f}"
    return f"{data.source}: no row lies on one of these curves"
