"""Draw the residual of eq. (11), its humps and a fold, for docs/root-search.md.

``tools.docs_figures`` writes the pictures.  The plain Python reference
(``papers.gill_dandrea_2017.reference``) computes the residual, without code of the core.  The rotor
is an APC 8x6E in hover at 6000 rpm, with the section constants ``paper-soft``.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import propmap as pm
from papers.gill_dandrea_2017 import reference
from propmap.report.html import COLORS, new_figure, style
from propmap.typing import Floats

BLUE, RED, GREEN = COLORS[:3]
INK = "0.15"
OMEGA = 6000.0 * np.pi / 30.0
ATTACHED, THREE_ROOTS, STALLED = 0.045, 0.0340, 0.0300
"""Radii [m] with one root in attached flow, three roots, and one root in stalled flow."""


def case() -> reference.Case:
    """Return the case of the rotor in hover."""
    model = pm.Model(pm.propeller("apc-8x6e"), pm.airfoil("paper-soft"))
    return reference.make_case(model, OMEGA, 0.0, 0.0, 1, 4)


def residual(of: reference.Case, radius: float, inflow: Floats) -> Floats:
    """Compute g, thrust of the blades (5) minus momentum thrust (10), per meter of radius [N/m]."""
    blades = reference.annulus_thrust(of, radius, inflow)
    return np.asarray(blades - reference.momentum_thrust(of, radius, inflow))


def hump(of: reference.Case, radius: float) -> tuple[float, float]:
    """Return inflow [m/s] and height [N/m] of the largest local maximum near stall."""
    v = np.linspace(1.0, 7.0, 3001)
    g = residual(of, radius, v)
    tops = 1 + np.flatnonzero((g[1:-1] > g[:-2]) & (g[1:-1] >= g[2:]))
    if not tops.size:  # a shoulder: the flattest point of the falling residual
        tops = np.array([np.argmax(np.gradient(g, v)[200:-200]) + 200])
    k = tops[np.argmax(g[tops])]
    return float(v[k]), float(g[k])


def one_root() -> Figure:
    """Draw the residual at two radii with one root each."""
    return _residuals((STALLED, ATTACHED), ("stalled branch", "attached branch"))


def three_roots() -> Figure:
    """Draw the residual at a radius with three roots."""
    return _residuals((THREE_ROOTS,), ("three roots",))


def _residuals(radii: tuple[float, ...], titles: tuple[str, ...]) -> Figure:
    of, v = case(), np.linspace(0.5, 8.5, 1601)
    with style():
        figure = new_figure(4.2 * len(radii), 3.0)
        for axes, radius, title in zip(
            figure.subplots(1, len(radii), squeeze=False)[0], radii, titles, strict=True
        ):
            g = residual(of, radius, v)
            axes.axhline(0.0, color=INK, linewidth=0.8)
            axes.plot(v, g, color=BLUE)
            crossings = np.flatnonzero((g[:-1] > 0.0) != (g[1:] > 0.0))
            axes.plot(v[crossings], 0.0 * crossings, "o", color="white", markeredgecolor=INK)
            axes.plot(v[crossings[-1]], 0.0, "o", color=RED)
            axes.annotate(
                "largest root",
                (v[crossings[-1]], 0.0),
                (-4, -14),
                textcoords="offset points",
                color=RED,
                ha="right",
            )
            axes.margins(y=0.15)
            top = hump(of, radius)
            axes.plot(*top, "^", color=GREEN)
            axes.annotate("hump", top, (0, 8), textcoords="offset points", color=GREEN, ha="center")
            axes.set_title(f"y = {1e3 * radius:.0f} mm: {title}", fontsize=9.0)
            axes.set_xlabel("inflow $v_i$ [m/s]")
            axes.set_ylabel("residual $g$ [N/m]")
    return figure


def fold() -> Figure:
    """Draw the height of the hump and the largest root along the blade, with the fold."""
    of, fine = case(), np.linspace(0.028, 0.046, 145)
    searched = np.linspace(fine[0], fine[-1], 6)
    heights = np.array([hump(of, y)[1] for y in fine])
    inflow = np.array([reference.annulus_inflow(of, y) for y in fine])
    jump = int(np.argmax(np.diff(inflow)))
    place = float(np.interp(0.0, heights[jump - 1 : jump + 3], fine[jump - 1 : jump + 3]))
    with style():
        figure = new_figure(8.4, 3.0)
        above, root = figure.subplots(1, 2, sharex=True)
        above.axhline(0.0, color=INK, linewidth=0.8)
        above.plot(1e3 * fine, heights, color=BLUE)
        above.plot(
            1e3 * searched,
            [hump(of, y)[1] for y in searched],
            "^",
            color=GREEN,
            label="radii of the search",
        )
        above.set_ylabel("height of the hump [N/m]")
        root.plot(1e3 * fine[: jump + 1], inflow[: jump + 1], color=BLUE)
        root.plot(1e3 * fine[jump + 1 :], inflow[jump + 1 :], color=BLUE)
        root.set_ylabel("largest root $v_i$ [m/s]")
        for axes in (above, root):
            _mark(axes, 1e3 * place)
        above.legend(loc="lower right")
    return figure


def _mark(axes: Axes, place: float) -> None:
    """Draw the fold at this radius [mm]."""
    axes.axvline(place, color=RED, linestyle="--", linewidth=1.0)
    axes.annotate(
        "fold",
        (place, 1.0),
        (3, -10),
        xycoords=("data", "axes fraction"),
        textcoords="offset points",
        color=RED,
    )
    axes.set_xlabel("radius $y$ [mm]")
