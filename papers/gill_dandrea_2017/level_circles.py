"""Figure 6, the paper's flight experiment: level circles on a tether, with the sets of Table I.

The logs of the paper are not public, so the flights are computed.  The truth is this model with
the set of Table I, plus an unknown vertical force of known size for all omitted effects.  The
results show the errors of the hover model if this model is right, and how well an identification
recovers the constants.  They do not test this model.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from papers.gill_dandrea_2017.paper import (
    FASTEST,
    FLIGHTS,
    FLOWN,
    HOVER_FAILS,
    RADIUS,
    TETHER,
    blade,
)
from propmap.fit.fit import Fitted, Settings, fit
from propmap.fit.flight import ForceModel, body_force, hover_loads, level_rows
from propmap.fit.parameters import Choice
from propmap.fit.tunnel import first_guess
from propmap.flight.simulate import trim, true_values
from propmap.hover import HoverModel
from propmap.model.airfoil import PAPER_FOUR, Airfoil, parameter_set
from propmap.model.model import Model
from propmap.report.html import (
    COLORS,
    DASHED,
    MEASURED,
    MODEL,
    csv_of_columns,
    csv_of_rows,
    key,
    legend_below,
    legend_in_last,
    marked,
    new_figure,
    number,
    share_of_weight,
    style,
)
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import GRAVITY, RPM
from propmap.vehicle.log import FlightLog, hub_flow, pitch_and_roll
from propmap.vehicle.vehicle import Body, Mount, Vehicle

BLADE = "apc-8x4.5mr"
"""Blade of both propellers, scaled to 10 cm, because their own blades are not published."""

ARM = 0.12  # [m] from the rotors to the body axes, assumed
FORCE_ERROR = 0.01  # standard deviation of a flight's unknown vertical force, over the weight
SEEDS = {"paper-soft": 2017, "paper-stiff": 2018}  # different unknown forces for the two sets
FAILS = (0.05, 0.1)  # errors over the weight that count as failures of the hover model
SPEEDS = np.linspace(0.0, FASTEST, 30)  # [m/s]


class Circles(NamedTuple):
    """Level circles at n speeds; every array is (n,), and loads are sums over all rotors."""

    speed: Floats  # [m/s]
    rotor_speed: Floats  # [rad/s]
    pitch: Floats  # nose down [rad]
    thrust: Floats  # [N]
    drag: Floats  # [N]
    torque: Floats  # [N m]
    hover_thrust: Floats  # of the hover model at the same rotor speeds [N]
    hover_torque: Floats  # [N m]
    hover_error: Floats  # vertical force of hover model and frame minus the weight [N]


class Twin(NamedTuple):
    """An identification from n simulated flights."""

    fitted: Fitted
    speed: Floats  # (n,) [m/s]
    error: Floats  # (n,): vertical force of the identified model minus the weight [N]
    hover_error: Floats  # (n,): the same for the hover model


class Case(NamedTuple):
    """Assumed values that the paper does not state: mass [kg], drag area of the frame [m^2]."""

    mass: float
    drag_area: float


ASSUMED = Case(0.5, 0.01)
"""A light quadrotor with 10 cm rotors."""

CASES = (ASSUMED, *(Case(0.5, area) for area in (0.0, 0.02, 0.04)), Case(1.0, 0.01))
"""Cases for which the error of the hover model is computed."""


class HoverFailure(NamedTuple):
    """Airspeeds [m/s] from which the hover model's error exceeds ``FAILS`` of the weight, and at
    which the force changes from too small to too large; None if it never does."""

    exceeds: tuple[float | None, ...]
    sign_changes: float | None


class SetFlown(NamedTuple):
    """Results of one set of Table I: circles by case of ``CASES``, and the twin experiment."""

    circles: dict[Case, Circles]
    twin: Twin

    @property
    def failures(self) -> dict[Case, HoverFailure]:
        """Failures of the hover model by case."""
        return {case: hover_failure(found, case.mass) for case, found in self.circles.items()}


def quadrotor(case: Case = ASSUMED) -> Vehicle:
    """Return the vehicle; its frame has the same drag area along all axes."""
    places = ((ARM, ARM, "cw"), (ARM, -ARM, "ccw"), (-ARM, ARM, "ccw"), (-ARM, -ARM, "cw"))
    mounts = tuple(Mount((x, y, 0.0), spin=spin) for x, y, spin in places)
    body = Body(drag_area=(case.drag_area,) * 3)
    return Vehicle("tethered quadrotor", case.mass, blade(BLADE, RADIUS), mounts, body=body)


def fly(name: str) -> SetFlown:
    """Compute the flights of one set of Table I."""
    law = parameter_set(name)
    found = {case: circles(quadrotor(case), law, SPEEDS) for case in CASES}
    return SetFlown(found, twin(law, SEEDS[name]))


def circles(vehicle: Vehicle, law: Airfoil, speeds: Floats) -> Circles:
    """Trim the vehicle on level circles, and compute the hover model at the same rotor speeds.

    The constants of the hover model are from rotors at rest at their rotational speed in hover.
    """
    points = trim(vehicle, law, speeds, radius=TETHER)
    rotor = Rotor(Model(vehicle.propeller, law, vehicle.air))
    flow = hub_flow(vehicle, points)
    velocity = np.stack([flow.inplane, 0.0 * flow.inplane, flow.axial], axis=-1)
    loads = rotor.loads_at_velocity(flow.omega, velocity)
    hover = _hover(vehicle, law)
    return Circles(
        speed=speeds,
        rotor_speed=points.rotor_speed[:, 0],
        pitch=pitch_and_roll(points.up)[0],
        thrust=loads.thrust.sum(axis=1),
        drag=loads.drag.sum(axis=1),
        torque=loads.torque.sum(axis=1),
        hover_thrust=hover.thrust(flow.omega).sum(axis=1),
        hover_torque=hover.torque(flow.omega).sum(axis=1),
        hover_error=_hover_error(vehicle, points, law),
    )


def twin(law: Airfoil, seed: int) -> Twin:
    """Identify the paper's four constants from circles with unknown forces, eq. (18)."""
    vehicle = quadrotor()
    speeds = np.linspace(0.5, FASTEST, FLIGHTS)
    unknown = FORCE_ERROR * np.random.default_rng(seed).standard_normal(FLIGHTS)
    points = trim(vehicle, law, speeds, radius=TETHER, disturbance=unknown)
    choice = Choice(PAPER_FOUR)
    rows = level_rows(ForceModel(vehicle, points, first_guess()), choice)
    fitted = fit(rows, choice, Settings(starts=2, folds=0))
    return Twin(fitted, speeds, fitted.residual, _hover_error(vehicle, points, law))


def static_inflow(case: Case) -> float:
    """Return v_h [m/s] of a rotor that carries a quarter of the weight, eq. (12)."""
    area = np.pi * RADIUS**2
    return float(np.sqrt(case.mass * GRAVITY / (4 * 2.0 * quadrotor(case).air.density * area)))


def hover_failure(found: Circles, mass: float) -> HoverFailure:
    """Find the failures of the hover model, interpolated linearly between the airspeeds."""
    share = found.hover_error / (mass * GRAVITY)
    exceeds = tuple(first_crossing(found.speed, np.abs(share) - level) for level in FAILS)
    # Search from a clearly too small force on, because rounding in hover can change the sign.
    low = int(np.argmax(share < -FAILS[0])) if (share < -FAILS[0]).any() else share.size
    return HoverFailure(exceeds, first_crossing(found.speed[low:], share[low:]))


def first_crossing(x: Floats, y: Floats) -> float | None:
    """Return the first x at which y (n,) rises through zero, or None."""
    for k in range(1, x.size):
        if y[k - 1] < 0.0 <= y[k]:
            return float(x[k] - (x[k] - x[k - 1]) * y[k] / (y[k] - y[k - 1]))
    return None


def _hover(vehicle: Vehicle, law: Airfoil) -> HoverModel:
    rotor = Rotor(Model(vehicle.propeller, law, vehicle.air))
    still = HoverModel.from_rotor(rotor)
    each = vehicle.mass * GRAVITY / len(vehicle.mounts)
    return HoverModel.from_rotor(rotor, float(np.sqrt(each / still.k_thrust)))


def _hover_error(vehicle: Vehicle, points: FlightLog, law: Airfoil) -> Floats:
    body, _ = body_force(vehicle, points, true_values(vehicle, law), ())
    force = hover_loads(_hover(vehicle, law), hub_flow(vehicle, points))[:, :3] + body
    return np.asarray(np.sum(force * points.up, axis=1) - vehicle.mass * GRAVITY)


# --- Figure 6, its tables and CSV files ----------------------------------------------------------

WEIGHT = ASSUMED.mass * GRAVITY
FACES = (COLORS[0], "white")
"""Faces of the markers, filled and hollow, which differ in print without color."""

LABELS = (
    "collective thrust ΣT [N]",
    "collective rotor drag ΣD [N]",
    "collective torque [mN m]",
    "vertical force error [N]",
    "pitch angle, nose down [deg]",
)


@style()
def loads_figure(flown: dict[str, SetFlown]) -> Figure:
    """Draw the five panels of the paper, and a legend in the sixth."""
    figure = new_figure(9.6, 6.2)
    axes = figure.subplots(2, 3, sharex=True).ravel()
    handles, big = [], {**MEASURED, "clip_on": True}
    for k, (name, one) in enumerate(flown.items()):
        c, look = one.circles[ASSUMED], {"color": COLORS[k]}
        lines = (
            (c.thrust, c.hover_thrust),
            (c.drag, 0.0 * c.drag),
            (1e3 * c.torque, 1e3 * c.hover_torque),
            (None, c.hover_error),
            (np.degrees(c.pitch), None),
        )
        for ax, (model, hover) in zip(axes, lines, strict=False):
            if model is not None:
                ax.plot(c.speed, model, **look, **MODEL)
            if hover is not None:
                ax.plot(c.speed, hover, **look, **DASHED)
        found: dict[str, Any] = {**marked(k), "linestyle": "none", "markerfacecolor": FACES[k]}
        axes[3].errorbar(
            one.twin.speed, one.twin.error, FORCE_ERROR * WEIGHT, markersize=3.5, elinewidth=0.8,
            **found,
        )  # fmt: skip
        handles += [
            key(f"{FLOWN[name]}: this model", **look, **MODEL),
            key(f"{FLOWN[name]}: hover model", **look, **DASHED),
            key(f"{FLOWN[name]}: identified,\nsimulated flights", **(big | found)),
        ]
    for ax, label in zip(axes, LABELS, strict=False):
        ax.set_ylabel(label)
        ax.margins(x=0.02)
    axes[3].axhline(0.0, color="0.6", linewidth=0.8)
    share_of_weight(axes[3], WEIGHT)
    legend_in_last(axes, handles, "flight speed V [m/s]")
    return figure


@style()
def cases_figure(flown: dict[str, SetFlown]) -> Figure:
    """Draw the error of the hover model in every case, one panel per set."""
    figure = new_figure(9.2, 4.2)
    axes = figure.subplots(1, 2, sharey=True)
    for ax, (name, one) in zip(axes, flown.items(), strict=True):
        ax.axhline(0.0, color="0.6", linewidth=0.8)
        ax.axvline(HOVER_FAILS[name], color="0.3", linewidth=1.0, linestyle=":")
        for k, case in enumerate(sorted(CASES, key=lambda case: (case.mass, case.drag_area))):
            found = one.circles[case]
            share = 100.0 * found.hover_error / (case.mass * GRAVITY)
            ax.plot(
                found.speed, share, markersize=3.5, markevery=(2 + k, 6),
                label=f"{case.mass:g} kg, {case.drag_area:g} m²", **marked(k), **DASHED,
            )  # fmt: skip
        ax.set_title(f"{FLOWN[name]} propeller", fontsize=9.0)
        ax.set_xlabel("flight speed V [m/s]")
        ax.set_xlim(0.0, FASTEST)
    axes[0].set_ylim(-35.0, 60.0)
    axes[0].set_ylabel("vertical force error\nof the hover model [% of the weight]")
    handles = axes[0].get_legend_handles_labels()[0]
    legend_below(figure, handles, handlelength=3.2, columnspacing=1.2)
    return figure


def failure_rows(flown: dict[str, SetFlown]) -> list[tuple[str, ...]]:
    """Return propeller, case, static inflow and failures of the hover model for each case."""
    return [
        (
            FLOWN[name],
            *(number(v) for v in (case.mass, case.drag_area, static_inflow(case))),
            *("never" if v is None else f"{v:.1f}" for v in (*found.exceeds, found.sign_changes)),
            number(HOVER_FAILS[name]),
        )
        for name, one in flown.items()
        for case, found in one.failures.items()
    ]


def summary(flown: dict[str, SetFlown]) -> dict[str, Any]:
    """Return the values that the text of the page states.

    ``changes`` contains the airspeeds of the changes of sign by set, ``early`` the airspeeds from
    which the error exceeds 5 % of the weight.  ``in_order`` is true if the sign changes for the
    soft propeller before the stiff one in every case.
    """
    cases = [list(one.failures.values()) for one in flown.values()]
    pairs = [[f.sign_changes or math.inf for f in pair] for pair in zip(*cases, strict=True)]
    return {
        "changes": {
            name: [f.sign_changes for f in found if f.sign_changes is not None]
            for name, found in zip(flown, cases, strict=True)
        },
        "early": [f.exceeds[0] for found in cases for f in found if f.exceeds[0]],
        "in_order": all(soft <= stiff for soft, stiff in pairs),
    }


def sheets(flown: dict[str, SetFlown]) -> dict[str, str]:
    """Return the CSV files by name."""
    return {
        "figure-6-level-circles": csv_of_columns(
            {
                "set": name,
                "speed_mps": c.speed,
                "rotor_speed_rpm": c.rotor_speed / RPM,
                "pitch_deg": np.degrees(c.pitch),
                "thrust_N": c.thrust,
                "drag_N": c.drag,
                "torque_Nm": c.torque,
                "hover_thrust_N": c.hover_thrust,
                "hover_torque_Nm": c.hover_torque,
                "hover_force_error_N": c.hover_error,
            }
            for name, c in ((name, one.circles[ASSUMED]) for name, one in flown.items())
        ),
        "figure-6-identification": csv_of_columns(
            {
                "set": name,
                "speed_mps": one.twin.speed,
                "force_error_N": one.twin.error,
                "hover_force_error_N": one.twin.hover_error,
            }
            for name, one in flown.items()
        ),
        "figure-6-hover-failure": csv_of_columns(
            {
                "set": name,
                "mass_kg": case.mass,
                "drag_area_m2": case.drag_area,
                "speed_mps": c.speed,
                "hover_force_error_N": c.hover_error,
            }
            for name, one in flown.items()
            for case, c in one.circles.items()
        ),
        "figure-6-failure-speeds": csv_of_rows(
            "set mass_kg drag_area_m2 static_inflow_mps off_by_5_percent_mps "
            "off_by_10_percent_mps sign_changes_mps paper_fails_mps",
            [
                (
                    name,
                    case.mass,
                    case.drag_area,
                    static_inflow(case),
                    *found.exceeds,
                    found.sign_changes,
                    HOVER_FAILS[name],
                )
                for name, one in flown.items()
                for case, found in one.failures.items()
            ],
        ),
    }
