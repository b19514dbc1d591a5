"""The angle of attack over the disk, with inflow and thrust along the blade."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.report.style import COLOURS, RPM, style

if TYPE_CHECKING:
    from propmap.results import Inflow
    from propmap.rotor import Rotor

STALL: dict[str, Any] = {"color": COLOURS[1], "linewidth": 1.6, "linestyle": "solid"}
REVERSE: dict[str, Any] = {"color": "white", "linewidth": 1.6, "linestyle": "dashed"}
ARROW: dict[str, Any] = {"arrowstyle": "-|>", "color": "0.2", "mutation_scale": 12.0}
MM = 1e3


@style()
def disk_picture(rotor: Rotor, omega: float, speed: float, beta: float) -> Figure:
    """Angle of attack over the disk seen from above, flight towards the top of the page.

    A counter-clockwise propeller is shown; the other one is its mirror image.

    Parameters
    ----------
    rotor : Rotor
        What is drawn.
    omega, speed, beta : float
        Operating point [rad/s], [m/s], [rad].

    Raises
    ------
    InputError
        Where the inflow did not converge everywhere.
    """
    blade = rotor.model.propeller
    radius = np.linspace(*rotor.model.span, 160)
    azimuth = np.radians(np.linspace(0.0, 360.0, 361))
    field = rotor.inflow(omega, speed, beta, radius=radius, azimuth=azimuth)
    if not np.isfinite(field.alpha).all():
        raise InputError(
            "the inflow did not converge everywhere on the disk", "choose another operating point"
        )
    # Placed by hand: what is written around a polar plot is not laid out automatically.
    figure = Figure(figsize=(9.2, 5.4))
    disk = figure.add_axes((0.05, 0.15, 0.40, 0.66), projection="polar")
    mesh = _angle_of_attack(disk, field)
    bar = figure.colorbar(mesh, cax=figure.add_axes((0.53, 0.22, 0.014, 0.52)), extend="both")
    bar.set_label(r"angle of attack $\alpha$ [deg]")
    _directions(disk, MM * blade.radius, oblique=speed * abs(np.sin(beta)) > 1e-9)
    handles = _regions(disk, field)
    figure.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.25, 0.0), ncols=2)
    inflow = figure.add_axes((0.69, 0.52, 0.29, 0.37))
    thrust = figure.add_axes((0.69, 0.10, 0.29, 0.37), sharex=inflow)
    inflow.tick_params(labelbottom=False)
    inflow.plot(MM * radius, field.inflow, color=COLOURS[0])
    inflow.set_ylabel("inflow $v_i$ [m/s]")
    thrust.plot(MM * radius, field.thrust_per_radius, color=COLOURS[0])
    thrust.set_ylabel("thrust dT/dy [N/m]")
    thrust.set_xlabel("radius y [mm]")
    figure.suptitle(
        f"{blade.name}, airfoil {rotor.model.law_title}: {omega * RPM:.0f} rpm, "
        f"V = {speed:g} m/s, β = {np.degrees(beta):.4g}°"
    )
    return figure


def _angle_of_attack(ax: Any, field: Inflow) -> Any:
    degrees = np.degrees(field.alpha)
    # In reverse flow alpha runs to +-180 deg; the colours are for the rest of the disk.
    rest = degrees[~field.reverse] if not field.reverse.all() else degrees
    low, high = np.floor(np.percentile(rest, 1.0)), np.ceil(np.percentile(rest, 99.0))
    ax.set_theta_zero_location("S")
    ax.grid(visible=False)
    mesh = ax.pcolormesh(
        field.azimuth, MM * field.radius, degrees, cmap="viridis", vmin=low,
        vmax=max(high, low + 1.0), shading="gouraud", rasterized=True,
    )  # fmt: skip
    ax.set_ylim(0.0, MM * field.radius[-1])
    ax.set_xticks([])
    ax.set_yticks([])
    return mesh


def _regions(ax: Any, field: Inflow) -> list[Line2D]:
    """Outline stall and reverse flow; handles for the legend."""
    # Smooth fields whose zero is the boundary make smoother outlines than the regions.
    regions = (
        ("stalled", field.stalled, field.past_stall, STALL),
        ("reverse flow", field.reverse, field.u_tangential, REVERSE),
    )
    handles = []
    for name, region, boundary, look in regions:
        if not region.any():
            continue
        if not region.all():
            ax.contour(
                field.azimuth, MM * field.radius, boundary, [0.0], colors=look["color"],
                linewidths=look["linewidth"], linestyles=look["linestyle"],
            )  # fmt: skip
        colour = "0.5" if look["color"] == "white" else look["color"]
        label = f"{name}: {100.0 * _share(field, region):.2g} % of the disk"
        handles.append(Line2D([], [], **{**look, "color": colour}, label=label))
    return handles


def _share(field: Inflow, region: NDArray[np.bool_]) -> float:
    """Share of the annulus from root to tip that a region covers [-]."""
    around = region[:, :-1].mean(axis=1)
    area = np.trapezoid(around * field.radius, field.radius)
    return float(area / np.trapezoid(field.radius, field.radius))


def _directions(ax: Any, tip: float, *, oblique: bool) -> None:
    """Name the sides, and draw arrows for the rotation and the flight."""
    sides = (" advancing", " retreating") if oblique else ("", "")
    label: dict[str, Any] = {"transform": ax.transAxes, "ha": "center", "va": "center"}
    ax.text(0.5, -0.035, "ψ = 0°", **label)
    ax.text(1.035, 0.5, f"ψ = 90°{sides[0]}", rotation=-90.0, **label)
    ax.text(0.5, 1.03, "ψ = 180°", **label)
    ax.text(-0.035, 0.5, f"ψ = 270°{sides[1]}", rotation=90.0, **label)
    turn = np.radians(np.linspace(32.0, 60.0, 30))
    ax.plot(turn, np.full(30, 1.06 * tip), color="0.2", linewidth=1.2, clip_on=False)
    ax.annotate(
        "", (turn[-1] + 0.03, 1.06 * tip), (turn[-2], 1.06 * tip), arrowprops=ARROW,
        annotation_clip=False,
    )  # fmt: skip
    middle = {"ha": "center", "va": "center", "rotation": 45.0}
    ax.text(np.radians(45.0), 1.12 * tip, "rotation", **middle)
    if oblique:
        up = {"xycoords": "axes fraction", "arrowprops": ARROW}
        ax.annotate("", xy=(0.5, 1.18), xytext=(0.5, 1.06), **up)
        ax.text(0.53, 1.12, "flight", transform=ax.transAxes, va="center")
