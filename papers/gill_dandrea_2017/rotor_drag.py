"""Rotor drag by the theory, the 2019 campaign and Ribner's fin analogy."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from papers.gill_dandrea_2017.fin_analogy import inflow_factor, side_force
from papers.gill_dandrea_2017.level_circles import ASSUMED, Circles, circles, quadrotor
from papers.gill_dandrea_2017.level_circles import SPEEDS as CIRCLE_SPEEDS
from papers.gill_dandrea_2017.paper import FLOWN, blade
from papers.gill_dandrea_2017.tunnel import (
    OBLIQUE,
    OBLIQUE_LABEL,
    OTHER_FORM,
    OTHER_LABEL,
    RECOMMENDED_LABEL,
    Compared,
)
from propmap.catalogue.lookup import measurement
from propmap.fit.least_squares import rms
from propmap.model.air import Air
from propmap.model.airfoil import Airfoil, parameter_set
from propmap.model.model import Model
from propmap.report.html import (
    BAND,
    COLORS,
    HOVER,
    MEASURED,
    MODEL,
    csv_of_columns,
    csv_of_rows,
    key,
    legend_in_last,
    new_figure,
    number,
    style,
)
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import GRAVITY, RPM

PROPELLERS = ("apc-8x6e", "apc-9x6e", "apc-11x7e", "apc-8x4.5mr", "apc-8x6sf")
INCIDENCE = np.radians(15.0)  # the smallest of the 2019 data; the fin is for small incidence
TIP_SPEED = 70.0  # [m/s] of all propellers; of the APC 8x6E at 6579 rpm, which has data
SPEEDS = np.arange(2.0, 15.0, 2.0)  # [m/s]

LIGHTLY_LOADED = 0.3
"""Inflow over airspeed up to which the disk counts as lightly loaded.  The fin analogy was verified
in cruise, with a lightly loaded disk."""


class SmallIncidence(NamedTuple):
    """One propeller at 15 degrees and n speeds; forces are [N]."""

    propeller: str
    omega: float  # [rad/s]
    speed: Floats  # (n,) [m/s]
    inflow: Floats  # (n,): over the airspeed [-]
    theory: Floats  # (n,): rotor drag of this theory
    fin_low: Floats  # (n,): side force of the fin, side area from the pitch of the chord line
    fin_high: Floats  # (n,): the same from the pitch of the zero-lift line
    published: Floats | None  # (n,): rotor drag of the 2019 polynomials, if available
    other: Floats | None  # (n,): the same of the campaign's blade-element model

    @property
    def theory_over_fin(self) -> Floats:
        """Drag of the theory over the fin's with the mean of the two side areas [-]."""
        return self.theory / (0.5 * (self.fin_low + self.fin_high))


class Ratio(NamedTuple):
    """Ratios of published to theoretical drag of the APC 8x6E at one angle."""

    beta: float  # [deg]
    points: int
    ratio: float  # of the polynomials to this theory, by root mean squares
    lowest: float  # over the points
    highest: float  # over the points
    other: float  # of the campaign's blade-element model to this theory
    recommended: float  # of the polynomials to this theory with the recommended inflow


class Consequence(NamedTuple):
    """Effect of the excess drag in flight: circles with once and ``factor`` times the drag."""

    name: str
    factor: float
    theory: Circles
    published: Circles


def small_incidence(law: Airfoil) -> list[SmallIncidence]:
    """Compare the theory, the fin and, for the 8x6E, both forms of the 2019 data.

    ``law`` is identified from thrust and torque of the APC 8x6E, and is assumed for the sections of
    the other propellers too.
    """
    return [_small_incidence(name, law) for name in PROPELLERS]


def ratios(one: Compared) -> list[Ratio]:
    """Divide published by theoretical drag at each angle, over all speeds above zero."""
    data = one.data
    drag = {label: loads["drag"] for label, loads in one.predicted.items()}
    angle, found = np.round(np.degrees(data.beta)), []
    for degrees in np.unique(angle[angle > 0.0]).tolist():
        mine = (angle == degrees) & (data.speed > 0.0)
        published, mean = data.loads["drag"][mine], drag[OBLIQUE_LABEL][mine]
        each = published / mean
        found.append(
            Ratio(
                beta=degrees,
                points=published.size,
                ratio=rms(published) / rms(mean),
                lowest=float(each.min()),
                highest=float(each.max()),
                recommended=rms(published) / rms(drag[RECOMMENDED_LABEL][mine]),
                other=rms(drag[OTHER_LABEL][mine]) / rms(mean),
            )
        )
    return found


def consequence(name: str, factor: float) -> Consequence:
    """Trim the tethered quadrotor with a set of Table I, and with ``factor`` times its drag."""
    law, vehicle = parameter_set(name), quadrotor()
    # The factor is the published over the theoretical drag, not a fit to either form of the data.
    more = law.with_corrections((f"installed:factor={factor!r},area_m2=0.0",))
    pair = (circles(vehicle, one, CIRCLE_SPEEDS) for one in (law, more))
    return Consequence(name, factor, *pair)


def _small_incidence(name: str, law: Airfoil) -> SmallIncidence:
    shape, air = blade(name), Air()
    omega = TIP_SPEED / shape.radius
    data, form = measurement(OBLIQUE), measurement(OTHER_FORM)
    published = other = None
    if name == data.propeller:
        # Use the nearest rotational speed of the data.
        omega = float(data.omega[np.argmin(np.abs(data.omega - omega))])
        at = (data.omega == omega) & (np.abs(data.beta - INCIDENCE) < np.radians(0.5))
        published, other = (
            np.interp(SPEEDS, data.speed[at], drag[at], np.nan, np.nan)
            for drag in (data.loads["drag"], form.loads["drag"])
        )
    rotor = Rotor(Model(shape, law, air))
    beta = np.concatenate([np.zeros_like(SPEEDS), np.full_like(SPEEDS, INCIDENCE)])
    loads = rotor.loads(omega, np.concatenate([SPEEDS, SPEEDS]), beta)
    thrust, drag = loads.thrust[: SPEEDS.size], loads.drag[SPEEDS.size :]
    low, high = (
        side_force(shape, thrust, SPEEDS, INCIDENCE, air.density, zero_lift_angle=angle)
        for angle in (0.0, law.zero_lift_angle)
    )
    inflow = inflow_factor(thrust, SPEEDS, shape.radius, air.density)
    return SmallIncidence(name, omega, SPEEDS, inflow, drag, low, high, published, other)


# --- Nondimensional rotor drag by source ---------------------------------------------------------

Mask = NDArray[np.bool_]

CRUISE = 10.0  # [m/s] from which the fin is compared; at lower speed, the disk is heavily loaded

LITERATURE = (
    (
        "unsteady free-wake lifting line, same section law, at equal thrust",
        "0.88 to 1.19 times the drag of this theory",
        "bare blades",
    ),
    (
        "polynomial for a lift rotor computed by NASA (GUAM, Simmons 2021)",
        "H/T = 0.49 μ; this theory 0.57 μ",
        "bare blades",
    ),
    (
        "quadcopter with 15 in rotors in a tunnel",
        "somewhat less drag than this theory for four rotors",
        "whole vehicle",
    ),
    ("Crazyflie 2.0 in flight (Förster 2015)", "H/T = 0.74 μ", "whole vehicle"),
    ("Parrot Bebop in flight", "H/T = 1.2 to 1.4 μ", "whole vehicle"),
)
"""Source, finding and object of published rotor drags; not computed here."""


class Source(NamedTuple):
    """Rotor drag H of the APC 8x6E by one source; NaN where the source has no value.

    H' = H/(rho/2 A (Omega R)^2) and mu = V sin(beta)/(Omega R).
    """

    label: str
    incidence: float  # H'/mu at 15 degrees and ``CRUISE`` or more [-]
    edgewise: float  # H'/mu in edgewise flow [-]
    edgewise_by_thrust: float  # H/(T mu) in edgewise flow [-]


def sources(one: Compared) -> list[Source]:
    """Return theory with both inflows, fin with both side areas, and both forms of the data."""
    data, laws = one.data, one.laws
    theory, recommended, other = (
        one.predicted[label] for label in (OBLIQUE_LABEL, RECOMMENDED_LABEL, OTHER_LABEL)
    )
    found = [
        _source(one, "this theory, the paper's inflow", theory["drag"], theory["thrust"]),
        _source(one, "this theory, recommended inflow", recommended["drag"], recommended["thrust"]),
    ]
    slanted, _ = _points(one)
    zero_lift = laws[OBLIQUE_LABEL].zero_lift_angle
    for line, angle in (("chord line", 0.0), ("zero-lift line", zero_lift)):
        drag = np.full_like(data.speed, np.nan)
        drag[slanted] = side_force(
            blade(data.propeller),
            _axial_thrust(one, theory["thrust"])[slanted],
            data.speed[slanted],
            INCIDENCE,
            data.air_density,
            zero_lift_angle=angle,
        )
        found.append(_source(one, f"Ribner's fin, side area from the {line}", drag, None))
    return [
        *found,
        _source(one, "2019, polynomials", data.loads["drag"], data.loads["thrust"]),
        _source(one, "2019, blade-element model", other["drag"], other["thrust"]),
    ]


def _points(one: Compared) -> tuple[Mask, Mask]:
    """Return the masks (n,) of the rows at 15 degrees in cruise, and of the edgewise rows."""
    data = one.data
    near = [np.abs(data.beta - angle) < np.radians(0.5) for angle in (INCIDENCE, 0.5 * np.pi)]
    return near[0] & (data.speed >= CRUISE), near[1] & (data.speed > 0.0)


def _axial_thrust(one: Compared, thrust: Floats) -> Floats:
    """Return the thrust (n,) [N] at the same rotational speed and airspeed without incidence."""
    data, axial = one.data, np.flatnonzero(one.data.beta == 0.0)
    same = np.isclose(data.omega[:, None], data.omega[axial]) & np.isclose(
        data.speed[:, None], data.speed[axial]
    )
    return np.where(same.any(axis=1), thrust[axial[same.argmax(axis=1)]], np.nan)


def _source(one: Compared, label: str, drag: Floats, thrust: Floats | None) -> Source:
    data, radius = one.data, blade(one.data.propeller).radius
    tip_speed = data.omega * radius
    advance = data.speed * np.sin(data.beta) / tip_speed
    share = drag / (0.5 * data.air_density * np.pi * radius**2 * tip_speed**2)
    slanted, edgewise = _points(one)

    def slope(at: Mask) -> float:
        return float(share[at] @ advance[at] / (advance[at] @ advance[at]))

    by_thrust = np.nan
    if thrust is not None:
        by_thrust = float(drag[edgewise].sum() / (thrust * advance)[edgewise].sum())
    return Source(label, slope(slanted), slope(edgewise), by_thrust)


# --- Excess of the 2019 rotor drag over the theory: a factor, or a plate in the slipstream -------

SLIPSTREAM = (1.0, 2.0)
"""Inflow at the plate over that of the disk [-], for a plate at the disk and far behind it."""

STEPS = 100  # of the inflow search; each step at least halves the error


class Excess(NamedTuple):
    """Drag as the sum of ``factor`` times the theory's drag and the drag of a plate."""

    factor: float  # [-]
    area: float  # [m^2]
    error: float  # rms residual over the rms of the drag fitted [-]


class PlateFits(NamedTuple):
    """Three least-squares fits of one drag, with factor and area limited to 0 or more."""

    model: str  # label of the theory
    data: str  # label of the drag fitted
    slipstream: float  # see ``SLIPSTREAM``
    factor: Excess  # a factor alone
    plate: Excess  # a plate alone, with the factor 1
    both: Excess  # a factor and a plate


def plate_fits(one: Compared) -> list[PlateFits]:
    """Fit both forms of the campaign's drag, with the paper's and with the recommended inflow."""
    data = one.data
    drags = {OBLIQUE: data.loads["drag"], OTHER_FORM: one.predicted[OTHER_LABEL]["drag"]}
    moving = data.speed * np.sin(data.beta) > 0.0
    found = []
    for model in (OBLIQUE_LABEL, RECOMMENDED_LABEL):
        loads = one.predicted[model]
        for slipstream in SLIPSTREAM:
            pressure = dynamic_pressure(one, loads["thrust"], slipstream)[moving]
            found += [
                PlateFits(
                    model, name, slipstream, *fits(loads["drag"][moving], pressure, d[moving])
                )
                for name, d in drags.items()
            ]
    return found


def dynamic_pressure(one: Compared, thrust: Floats, slipstream: float) -> Floats:
    """Return the force of a plate along the disk per drag area [N/m^2], at ``thrust`` (n,) [N].

    The result is 1/2 rho V_in sqrt(V_in^2 + (V_ax + k v_i)^2), with the inflow v_i by momentum
    theory; k is ``slipstream`` [-].
    """
    data, area = one.data, np.pi * blade(one.data.propeller).radius ** 2
    inplane, axial = data.speed * np.sin(data.beta), data.speed * np.cos(data.beta)
    inflow = momentum_inflow(thrust / (2.0 * data.air_density * area), inplane, axial)
    along = np.hypot(inplane, axial + slipstream * inflow)
    return np.asarray(0.5 * data.air_density * inplane * along)


def momentum_inflow(product: Floats, inplane: Floats, axial: Floats) -> Floats:
    """Solve Glauert's v_i sqrt(V_in^2 + (V_ax + v_i)^2) = T/(2 rho A) for v_i (n,) [m/s].

    ``product`` is the right-hand side (n,) [m^2/s^2]; V_ax must be 0 or more.
    """
    inflow = np.sqrt(np.maximum(product, 0.0))
    for _ in range(STEPS):
        through = np.hypot(inplane, axial + inflow)
        step = np.divide(product, through, out=np.zeros_like(product), where=through > 0.0)
        inflow = 0.5 * (inflow + step)
    return inflow


def fits(theory: Floats, pressure: Floats, drag: Floats) -> tuple[Excess, Excess, Excess]:
    """Fit a factor alone, a plate alone, and both, to a ``drag`` (n,) [N].

    ``theory`` (n,) is the theory's drag [N], ``pressure`` (n,) the force on a plate of 1 m^2.
    """
    from scipy.optimize import nnls

    def excess(factor: float, area: float) -> Excess:
        left = drag - factor * theory - area * pressure
        return Excess(factor, area, rms(left) / rms(drag))

    alone = float(theory @ drag / (theory @ theory))
    area = max(0.0, float(pressure @ (drag - theory) / (pressure @ pressure)))
    # Scale both columns to the same size, because the areas are small numbers.
    sizes = np.array([rms(theory), rms(pressure)])
    both, _ = nnls(np.stack([theory, pressure], axis=1) / sizes, drag)
    return excess(alone, 0.0), excess(1.0, area), excess(*(both / sizes).tolist())


class RotorDrag(NamedTuple):
    """All results on rotor drag; the functions that compute them describe them."""

    small_incidence: list[SmallIncidence]
    ratios: list[Ratio]
    sources: list[Source]
    plates: list[PlateFits]
    consequences: list[Consequence]


def compute(one: Compared) -> RotorDrag:
    """Compute all results from the oblique data and the loads of the theory."""
    found = ratios(one)
    return RotorDrag(
        small_incidence(one.laws[OBLIQUE_LABEL]),
        found,
        sources(one),
        plate_fits(one),
        [consequence(name, found[0].ratio) for name in FLOWN],
    )


# --- Figure, tables and CSV files ----------------------------------------------------------------

LIGHT: dict[str, Any] = {"color": COLORS[4], "alpha": 0.6, "linewidth": 0.0}
HEAVY: dict[str, Any] = {**LIGHT, "alpha": 0.25}
"""Shades of the fin analogy for a heavily loaded disk (pale) and a lightly loaded one."""

SHOWN, IN_FLIGHT = (6.0, 10.0, 14.0), (5.0, 10.0, 14.5)  # tabulated airspeeds [m/s]
MODELS = {OBLIQUE_LABEL: "the paper's inflow", RECOMMENDED_LABEL: "recommended inflow"}
DATA = {OBLIQUE: "polynomials", OTHER_FORM: "model of 2019"}


@style()
def small_figure(small: list[SmallIncidence]) -> Figure:
    """Draw rotor drag over airspeed, one panel per propeller."""
    theory: dict[str, Any] = {"color": COLORS[0], **MODEL}
    published: dict[str, Any] = {"color": COLORS[1], "marker": "o", **MEASURED}
    figure = new_figure(9.6, 6.0)
    axes = figure.subplots(2, 3, sharex=True).ravel()
    for ax, one in zip(axes, small, strict=False):
        # The two shades meet at the first airspeed with a lightly loaded disk.
        edge = one.speed[np.argmax(one.inflow < LIGHTLY_LOADED)]
        for where, shade in ((one.speed >= edge, LIGHT), (one.speed <= edge, HEAVY)):
            ax.fill_between(one.speed, one.fin_low, one.fin_high, where=where, **shade)
        ax.plot(one.speed, one.theory, **theory)
        ax.axhline(0.0, **HOVER)
        if one.published is not None and one.other is not None:
            ax.fill_between(one.speed, one.published, one.other, color=COLORS[1], **BAND)
            ax.plot(one.speed, one.published, **published)
        ax.set_title(f"{one.propeller}, {one.omega / RPM:.0f} rpm", fontsize=9.0)
        ax.set_ylabel("rotor drag D [N]")
        ax.set_xlim(0.0, 14.5)
        ax.set_xticks(range(0, 15, 2))
    handles = [
        key("this theory", **theory),
        Patch(label="fin analogy, lightly loaded disk", **LIGHT),
        Patch(label="fin analogy, heavily loaded disk", **HEAVY),
        key("2019 polynomials; band: to the 2019 model", **published),
        key("hover model", **HOVER),
    ]
    legend_in_last(axes, handles, "speed V [m/s]")
    return figure


def theory_over_fin(small: list[SmallIncidence], *, light: bool) -> list[float]:
    """Return the ratios [-] at all airspeeds with a lightly or with a heavily loaded disk."""
    return [
        float(value)
        for one in small
        for value in one.theory_over_fin[(one.inflow < LIGHTLY_LOADED) == light]
    ]


def small_rows(small: list[SmallIncidence]) -> list[tuple[str, ...]]:
    """Return airspeed, inflow, forces [mN] and ratios, in three rows for each propeller."""
    rows = []
    for one in small:
        published = np.full_like(one.speed, np.nan) if one.published is None else one.published
        for k in (int(np.argmin(np.abs(one.speed - speed))) for speed in SHOWN):
            forces = (one.theory, one.fin_low, one.fin_high, published)
            rows.append(
                (
                    one.propeller,
                    f"{one.speed[k]:.0f}",
                    number(one.inflow[k], 2),
                    *(number(1e3 * force[k]) for force in forces),
                    number(one.theory_over_fin[k]),
                    number(published[k] / one.theory[k]),
                )
            )
    return rows


def ratio_rows(ratios: list[Ratio]) -> list[tuple[Any, ...]]:
    """Return number of points and ratios of published to theoretical drag for each angle."""
    return [(f"{one.beta:.0f}", *one[1:]) for one in ratios]


def source_rows(sources: list[Source]) -> list[tuple[str, ...]]:
    """Return H'/mu at incidence and edgewise, H/(T mu), and H'/mu over the theory by source."""
    theory = sources[0]
    return [
        (
            one.label,
            *(number(value, 2) for value in one[1:]),
            number(one.incidence / theory.incidence, 3),
            number(one.edgewise / theory.edgewise, 3),
        )
        for one in sources
    ]


def plate_rows(plates: list[PlateFits]) -> list[tuple[str, ...]]:
    """Return theory, drag and slipstream of each fit, with factor, plate, both and the errors."""
    return [
        (
            MODELS[fit.model],
            DATA[fit.data],
            f"{fit.slipstream:g}",
            number(fit.factor.factor),
            f"{100 * fit.factor.error:.1f}",
            f"{1e4 * fit.plate.area:.0f}",
            f"{100 * fit.plate.error:.1f}",
            f"{number(fit.both.factor)}, {1e4 * fit.both.area:.0f}",
            f"{100 * fit.both.error:.1f}",
        )
        for fit in plates
    ]


def plate_words(plates: list[PlateFits]) -> str:
    """Return a sentence that compares a factor alone with a plate alone over all fits."""

    def span(errors: list[float]) -> str:
        return f"{100 * min(errors):.1f} to {100 * max(errors):.1f} %"

    factor, plate = ([getattr(fit, kind).error for fit in plates] for kind in ("factor", "plate"))
    better = sum(p < f for p, f in zip(plate, factor, strict=True))
    return (
        f"The data of this propeller alone cannot separate a factor from a plate. The error is "
        f"{span(factor)} with a factor and {span(plate)} with a plate; the plate is better in "
        f"{better} of {len(plates)} cases."
    )


def flight_rows(consequences: list[Consequence]) -> list[tuple[str, ...]]:
    """Return propeller, airspeed, and pairs of pitch, rotor speed and shaft power."""
    rows = []
    for one in consequences:
        pair = (one.theory, one.published)
        for k in (int(np.argmin(np.abs(one.theory.speed - speed))) for speed in IN_FLIGHT):
            rows.append(
                (
                    FLOWN[one.name],
                    f"{one.theory.speed[k]:.1f}",
                    *(f"{np.degrees(c.pitch[k]):.1f}" for c in pair),
                    *(f"{c.rotor_speed[k] / RPM:.0f}" for c in pair),
                    *(number(c.torque[k] * c.rotor_speed[k]) for c in pair),
                )
            )
    return rows


def sheets(found: RotorDrag) -> dict[str, str]:
    """Return the CSV files by name."""
    return {
        "rotor-drag": csv_of_columns(
            {
                "propeller": one.propeller,
                "rpm": one.omega / RPM,
                "incidence_deg": np.degrees(INCIDENCE),
                "speed_mps": one.speed,
                "inflow_over_speed": one.inflow,
                "theory_N": one.theory,
                "fin_chord_line_N": one.fin_low,
                "fin_zero_lift_line_N": one.fin_high,
                "polynomials_2019_N": one.published,
                "model_2019_N": one.other,
            }
            for one in found.small_incidence
        ),
        "rotor-drag-by-angle": csv_of_rows(
            "beta_deg points polynomials_over_theory lowest highest model_over_theory "
            "polynomials_over_recommended",
            found.ratios,
        ),
        "rotor-drag-sources": csv_of_rows(
            "source incidence_H_over_mu edgewise_H_over_mu edgewise_H_over_T_mu",
            found.sources,
        ),
        "rotor-drag-plate": csv_of_rows(
            "model data slipstream_factor factor_alone factor_rms_over_rms_measured plate_alone_m2 "
            "plate_rms_over_rms_measured both_factor both_plate_m2 both_rms_over_rms_measured",
            [
                (
                    *(fit.model, fit.data, fit.slipstream),
                    *(fit.factor.factor, fit.factor.error, fit.plate.area, fit.plate.error),
                    *fit.both,
                )
                for fit in found.plates
            ],
        ),
        "rotor-drag-in-flight": csv_of_columns(
            {
                "set": one.name,
                "drag_factor": factor,
                "speed_mps": c.speed,
                "pitch_deg": np.degrees(c.pitch),
                "rotor_speed_rpm": c.rotor_speed / RPM,
                "thrust_N": c.thrust,
                "drag_N": c.drag,
                "torque_Nm": c.torque,
                "hover_force_error_share_of_weight": c.hover_error / (ASSUMED.mass * GRAVITY),
            }
            for one in found.consequences
            for factor, c in ((1.0, one.theory), (one.factor, one.published))
        ),
    }
