"""Figure 7, the paper's tunnel experiment with public data: measurements, this model, hover model.

Section constants of the APC 8x6E are identified from the data, with and without camber.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from papers.gill_dandrea_2017.paper import TUNNEL_ERROR, TUNNEL_PROPELLER, blade
from propmap.catalogue.lookup import Measurement, measurement
from propmap.fit.fit import Fitted, Settings, fit
from propmap.fit.least_squares import errors as errors_of
from propmap.fit.least_squares import rms
from propmap.fit.parameters import Choice
from propmap.fit.tunnel import TunnelData, first_guess, section_with, tunnel_rows
from propmap.hover import HoverModel
from propmap.loads import LOADS
from propmap.model.air import Air
from propmap.model.airfoil import PAPER_FOUR, Airfoil, parameter_set
from propmap.model.corrections import MODELS
from propmap.model.model import Model
from propmap.report.html import (
    BAND,
    COLORS,
    HOVER,
    MARKERS,
    MEASURED,
    MODEL,
    angle_keys,
    csv_of_columns,
    csv_of_rows,
    key,
    legend_below,
    marked,
    new_figure,
    number,
    style,
)
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import RPM

# --- Section constants of the APC 8x6E, identified from the public tunnel data -------------------

AXIAL, OBLIQUE, OTHER_FORM = "uiuc-8x6e", "gill-dandrea-2019-8x6e", "gill-dandrea-2019-8x6e-fit"
"""UIUC's rows; the polynomials of the 2019 campaign, each fitted to the measurements of one load;
the blade-element model that the same paper fitted to all loads."""

OBLIQUE_LABEL = "with camber, 2019"
FITTED_LOADS = ("thrust", "torque")
"""All fits exclude rotor drag, because published sources disagree on it."""

FIVE = (*PAPER_FOUR, "zero_lift_angle")
STARTS = 4


class Identified(NamedTuple):
    """One identification: its label, its data, the fit, and the section law."""

    label: str
    data: str
    fitted: Fitted
    law: Airfoil


class TunnelFits(NamedTuple):
    """Fits of the paper's four constants and of five, with a zero-lift angle, to the UIUC rows, and
    of the five constants to the polynomials of 2019."""

    axial_four: Identified
    axial: Identified
    oblique: Identified


def tunnel_fits() -> TunnelFits:
    """Make the fits to thrust and torque, from the paper's first guess and three random starts."""
    return TunnelFits(
        axial_four=_identify("four parameters, UIUC", AXIAL, PAPER_FOUR),
        axial=_identify("with camber, UIUC", AXIAL, FIVE),
        oblique=_identify(OBLIQUE_LABEL, OBLIQUE, FIVE),
    )


def _identify(label: str, data: str, free: tuple[str, ...]) -> Identified:
    m, choice = measurement(data), Choice(free)
    given = TunnelData(m.name, m.omega, m.speed, m.beta, m.loads)
    model = Model(blade(TUNNEL_PROPELLER), first_guess())
    rows = tunnel_rows(model, given, choice, loads=FITTED_LOADS)
    fitted = fit(rows, choice, Settings(starts=STARTS, folds=0))
    law = section_with(model.airfoil, fitted.values)
    return Identified(label, data, fitted, law.with_parameters(name=label, source=data))


# --- Loads measured and computed -----------------------------------------------------------------

MULTIROTOR = "davoudi-8x4.5mr-thrust"
DATA_SETS = {
    AXIAL: "UIUC tunnel, axial and static",
    OBLIQUE: "2019 campaign, oblique (polynomials)",
    MULTIROTOR: "8x4.5MR thrust at 0 and 5 m/s (digitized)",
}
FILES_OF_DATA = {
    AXIAL: "figure-7-axial",
    OBLIQUE: "figure-7-oblique",
    MULTIROTOR: "figure-7-8x4.5mr",
}

DIGITISED = 0.025  # uncertainty of the digitized thrust over its largest value, 2-3 %
PRINTED, STIFF = "paper-apc", "paper-stiff"
PRINTED_LABEL, HOVER_LABEL = "Table I, APC 8x6", "hover model"
RECOMMENDED_LABEL = "with camber, recommended inflow"
OTHER_LABEL = "blade-element model of the campaign"
"""Label of the 2019 blade-element model among the models of the oblique data.  Its difference from
the polynomials is the uncertainty of these data."""


class Compared(NamedTuple):
    """One data set of n points, and the loads of all models at these points."""

    data: Measurement
    laws: dict[str, Airfoil]  # by label
    predicted: dict[str, dict[str, Floats]]
    """Loads (n,) by label of the model, then by load.  The models are the laws, the hover model
    and, for the oblique data, the other form of the data."""

    @property
    def air(self) -> Air:
        """The air of the measurement."""
        return Air(density=self.data.air_density)


class LoadError(NamedTuple):
    """Error of one model in one load of one data set, in the unit of the load."""

    data_set: str
    load: str
    model: str
    points: int
    unit: str
    rms: float
    worst: float  # largest magnitude
    rms_share: float  # rms error over the rms of the measured load
    worst_share: float  # worst error over the largest measured magnitude
    within_nine: float  # share of the points whose error is at most 9 % of their measured value


def compared(fits: TunnelFits) -> dict[str, Compared]:
    """Return the comparison of all models on each data set, by its name.

    The constants of the hover model are fitted to the static rows of the same data set, as in a
    hover test.
    """
    identified = {one.label: one.law for one in (fits.axial, fits.oblique)}
    laws = {PRINTED_LABEL: parameter_set(PRINTED), **identified}
    found = {AXIAL: _compared(AXIAL, laws)}
    found[OBLIQUE] = _compared(OBLIQUE, laws | {RECOMMENDED_LABEL: recommended(fits.oblique.law)})
    found[OBLIQUE].predicted[OTHER_LABEL] = dict(measurement(OTHER_FORM).loads)
    # Nothing is fitted to this propeller.  The stiff propeller of Table I has its size and pitch.
    found[MULTIROTOR] = _compared(
        MULTIROTOR, {"Table I, HQP 8x4.5": parameter_set(STIFF), **identified}
    )
    return found


def recommended(law: Airfoil) -> Airfoil:
    """Return a law of the paper's model with the inflow that propmap recommends."""
    return law.with_corrections(MODELS["recommended"])


def errors(found: dict[str, Compared]) -> list[LoadError]:
    """Return the errors by data set, load and model; the hover model has only thrust and torque."""
    return [
        _error(name, load, model, truth, loads[load])
        for name, one in found.items()
        for load, truth in one.data.loads.items()
        for model, loads in one.predicted.items()
        if load in loads
    ]


def static_constants(data: Measurement) -> HoverModel:
    """Fit k_T and k_tau to the rows at rest by least squares; k_tau is NaN without torque."""
    still = data.speed == 0.0
    squares = data.omega[still] ** 2

    def constant(load: str) -> float:
        if load not in data.loads:
            return float("nan")
        return float(squares @ data.loads[load][still] / (squares @ squares))

    return HoverModel(constant("thrust"), constant("torque"), float(data.omega[still].max()))


def _compared(name: str, laws: dict[str, Airfoil]) -> Compared:
    data = measurement(name)
    shape, air = blade(data.propeller), Air(density=data.air_density)
    predicted = {}
    for label, law in laws.items():
        loads: Any = Rotor(Model(shape, law, air)).loads(data.omega, data.speed, data.beta)
        predicted[label] = {load: getattr(loads, load) for load in LOADS}
    predicted[HOVER_LABEL] = static_constants(data).loads(data.omega)
    return Compared(data, laws, predicted)


def _error(name: str, load: str, model: str, truth: Floats, found: Floats) -> LoadError:
    e = errors_of(found, truth)
    near = np.abs(found - truth) <= TUNNEL_ERROR * np.abs(truth)
    return LoadError(
        data_set=name,
        load=load,
        unit=LOADS[load].unit,
        model=model,
        points=truth.size,
        rms=e.rms,
        worst=abs(e.worst),
        rms_share=e.relative_rms,
        worst_share=abs(e.worst) / float(np.max(np.abs(truth))),
        within_nine=float(np.mean(near)),
    )


# --- Lines through the points --------------------------------------------------------------------

AXIAL_OMEGA = 5000.0 * RPM  # of the axial lines; other speeds change them by at most 1 % (Re)
OBLIQUE_OMEGA = 6579.0 * RPM  # the rotational speed with most points of the 2019 campaign

BETAS = np.radians([0.0, 30.0, 60.0, 90.0])
LARGEST_ADVANCE = 1.1


class Coefficients(NamedTuple):
    """J = V/(n D), C_T = T/(rho n^2 D^4) and C_P = P/(rho n^3 D^5) [-], each (n,)."""

    advance: Floats
    thrust: Floats
    power: Floats


class ThrustCurve(NamedTuple):
    """Thrust (n,) [N] over omega (n,) [rad/s] at one speed [m/s] and angle [rad]."""

    label: str
    speed: float
    beta: float
    omega: Floats
    thrust: Floats


def measured_coefficients(data: Measurement) -> Coefficients:
    """Return the coefficients of measured axial rows."""
    thrust, torque = data.loads["thrust"], data.loads["torque"]
    return _coefficients(data, data.omega, data.speed, thrust, torque)


def axial_curves(one: Compared, laws: dict[str, Airfoil]) -> dict[str, Coefficients]:
    """Compute the lines of C_T and C_P over J by label of the law."""
    shape = blade(one.data.propeller)
    fastest = LARGEST_ADVANCE * shape.diameter * AXIAL_OMEGA / (2.0 * np.pi)
    speed = np.linspace(0.0, fastest, 45)
    omega = np.full_like(speed, AXIAL_OMEGA)
    found = {}
    for label, law in laws.items():
        loads = Rotor(Model(shape, law, one.air)).loads(omega, speed, 0.0)
        found[label] = _coefficients(one.data, omega, speed, loads.thrust, loads.torque)
    return found


def oblique_curves(
    one: Compared, laws: dict[str, Airfoil]
) -> tuple[Floats, dict[str, dict[str, Floats]]]:
    """Compute speeds (n,), and loads (angles of ``BETAS``, n) by label of the law and by name."""
    speed = np.linspace(0.0, float(one.data.speed.max()), 29)
    found = {}
    for label, law in laws.items():
        rotor = Rotor(Model(blade(one.data.propeller), law, one.air))
        loads: Any = rotor.loads(OBLIQUE_OMEGA, speed, BETAS[:, None])
        found[label] = {name: getattr(loads, name) for name in LOADS}
    return speed, found


def thrust_curves(one: Compared) -> list[ThrustCurve]:
    """Compute thrust over rotational speed for each law and each flow of the 8x4.5MR data."""
    data = one.data
    omega = np.linspace(0.15, 1.0, 30) * float(data.omega.max())
    rounded = np.round(np.stack([data.speed, data.beta]), 3)
    _, first = np.unique(rounded, axis=1, return_index=True)
    found = []
    for label, law in one.laws.items():
        rotor = Rotor(Model(blade(data.propeller), law, one.air))
        for speed, beta in zip(data.speed[first], data.beta[first], strict=True):
            thrust = rotor.loads(omega, speed, beta).thrust
            found.append(ThrustCurve(label, float(speed), float(beta), omega, thrust))
    return found


def _coefficients(
    data: Measurement, omega: Floats, speed: Floats, thrust: Floats, torque: Floats
) -> Coefficients:
    rate, size, density = omega / (2.0 * np.pi), blade(data.propeller).diameter, data.air_density
    return Coefficients(
        speed / (rate * size),
        thrust / (density * rate**2 * size**4),
        torque * omega / (density * rate**3 * size**5),
    )


class Tunnel(NamedTuple):
    """All results of the experiment; the functions that compute them describe them."""

    fits: TunnelFits
    compared: dict[str, Compared]
    errors: list[LoadError]
    axial_curves: dict[str, Coefficients]
    oblique_curves: tuple[Floats, dict[str, dict[str, Floats]]]
    thrust_curves: list[ThrustCurve]


def compute() -> Tunnel:
    """Identify the constants, compare the models, and compute the lines through the points."""
    fits = tunnel_fits()
    found = compared(fits)
    printed = {PRINTED_LABEL: found[AXIAL].laws[PRINTED_LABEL]}
    axial = printed | {one.label: one.law for one in (fits.axial_four, fits.axial)}
    slanted = found[OBLIQUE].laws
    oblique = printed | {label: slanted[label] for label in (OBLIQUE_LABEL, RECOMMENDED_LABEL)}
    return Tunnel(
        fits,
        found,
        errors(found),
        axial_curves(found[AXIAL], axial),
        oblique_curves(found[OBLIQUE], oblique),
        thrust_curves(found[MULTIROTOR]),
    )


# --- Figure 7, the figure on camber, tables and CSV files ----------------------------------------

SYMBOLS = {"thrust": "C_T", "power": "C_P"}


@style()
def axial_figure(one: Compared, curves: dict[str, Coefficients]) -> Figure:
    """Draw C_T and C_P over J."""
    measured, still = measured_coefficients(one.data), one.data.speed == 0.0
    figure = new_figure(9.2, 4.2)
    axes = figure.subplots(1, 2)
    for ax, part, symbol in zip(axes, ("thrust", "power"), "TP", strict=True):
        values = getattr(measured, part)
        ax.plot(
            measured.advance, values, color="0.45", marker="o", linestyle="none", markersize=3.0,
            label="UIUC, measured", clip_on=False,
        )  # fmt: skip
        for k, (label, curve) in enumerate(curves.items()):
            y, every = getattr(curve, part), slice(3 + 4 * k, None, 14)
            ax.plot(curve.advance, y, color=COLORS[k], label=label, **MODEL)
            ax.plot(curve.advance[every], y[every], linestyle="none", **_look(k))
        ax.axhline(float(values[still].mean()), label=HOVER_LABEL, **HOVER)
        ax.axhline(0.0, color="0.6", linewidth=0.8)
        ax.set_xlabel("advance ratio J = V/(nD) [-]")
        ax.set_ylabel(f"{part} coefficient $C_{symbol}$ [-]")
        ax.set_xlim(0.0, 1.1)
    handles = axes[0].get_legend_handles_labels()[0]
    for k, label in enumerate(curves):
        handles[1 + k] = key(label, **_look(k), **MODEL)
    legend_below(figure, handles)
    return figure


@style()
def oblique_figure(one: Compared, curves: tuple[Floats, dict[str, dict[str, Floats]]]) -> Figure:
    """Draw all loads over airspeed, with a column per parameter set and a color per angle."""
    data, (speed, by_label) = one.data, curves
    hover = static_constants(data).loads(OBLIQUE_OMEGA)
    measured = {name: load for name, load in LOADS.items() if name in data.loads}
    mine = np.abs(data.omega - OBLIQUE_OMEGA) < 0.01 * OBLIQUE_OMEGA
    other = one.predicted[OTHER_LABEL]
    figure = new_figure(9.6, 2.3 * len(measured))
    axes = figure.subplots(len(measured), len(by_label), sharex=True, sharey="row")
    for column, (label, loads) in zip(axes.T, by_label.items(), strict=True):
        column[0].set_title(label, fontsize=9.0)
        for ax, name in zip(column, measured, strict=True):
            ax.axhline(float(hover[name]), **HOVER)
            for k, beta in enumerate(BETAS):
                at = mine & (np.abs(data.beta - beta) < np.radians(0.5))
                if name in other:
                    edges = (data.loads[name][at], other[name][at])
                    ax.fill_between(data.speed[at], *edges, color=COLORS[k], **BAND)
                ax.plot(speed, loads[name][k], color=COLORS[k], **MODEL)
                ax.plot(data.speed[at], data.loads[name][at], **marked(k), **MEASURED)
            ax.margins(x=0.02)
        column[-1].set_xlabel("speed V [m/s]")
    for ax, load in zip(axes[:, 0], measured.values(), strict=True):
        ax.set_ylabel(load.title)
    handles: list[Any] = [*angle_keys(BETAS, markersize=4.5, **MODEL), key(HOVER_LABEL, **HOVER)]
    handles.append(Patch(label="difference from the campaign's model", color="0.4", **BAND))
    legend_below(figure, handles)
    return figure


@style()
def multirotor_figure(one: Compared, curves: list[ThrustCurve]) -> Figure:
    """Draw thrust over rotational speed, with a panel per parameter set and a color per flow."""
    data, thrust = one.data, one.data.loads["thrust"]
    still = static_constants(data)
    labels = list(dict.fromkeys(curve.label for curve in curves))
    bar = DIGITISED * float(thrust.max())
    figure = new_figure(9.6, 4.2)
    axes = figure.subplots(1, len(labels), sharey=True)
    for ax, label in zip(axes, labels, strict=True):
        own = [curve for curve in curves if curve.label == label]
        for k, c in enumerate(own):
            at = (np.abs(data.speed - c.speed) < 0.01) & (np.abs(data.beta - c.beta) < 0.01)
            ax.plot(c.omega / RPM / 1e3, c.thrust, color=COLORS[k], **MODEL)
            ax.errorbar(
                data.omega[at] / RPM / 1e3, thrust[at], bar, linestyle="none", markersize=4.0,
                elinewidth=0.8, **marked(k),
            )  # fmt: skip
        ax.plot(own[0].omega / RPM / 1e3, still.thrust(own[0].omega), **HOVER)
        ax.set_title(label, fontsize=9.0)
        ax.set_xlabel("rotational speed [1000/min]")
    axes[0].set_ylabel("thrust T [N]")
    handles = [key(_flow(c), markersize=4.5, **marked(k), **MODEL) for k, c in enumerate(own)]
    handles.append(key(HOVER_LABEL, **HOVER))
    legend_below(figure, handles, 6, columnspacing=1.2, handletextpad=0.5, fontsize=8.0)
    return figure


@style()
def camber_figure(one: Compared, curves: dict[str, Coefficients]) -> Figure:
    """Draw the errors of C_T and C_P over J."""
    advance = measured_coefficients(one.data).advance
    figure = new_figure(9.2, 4.0)
    axes = figure.subplots(1, 2)
    for ax, (part, symbol) in zip(axes, SYMBOLS.items(), strict=True):
        ax.axhline(0.0, color="0.4", linewidth=0.8)
        for k, (label, curve) in enumerate(curves.items()):
            ax.plot(
                advance, coefficient_error(one, curve, part), linestyle="none", markersize=3.5,
                label=label, clip_on=False, **marked(k),
            )  # fmt: skip
        ax.set_xlabel("advance ratio J = V/(nD) [-]")
        ax.set_ylabel(f"computed minus measured ${symbol}$ [-]")
    legend_below(figure, axes[0].get_legend_handles_labels()[0])
    return figure


def coefficient_error(one: Compared, curve: Coefficients, part: str) -> Floats:
    """Return computed minus measured thrust or power coefficient (n,)."""
    measured = measured_coefficients(one.data)
    model = np.interp(measured.advance, curve.advance, getattr(curve, part))
    return np.asarray(model - getattr(measured, part))


def rms_errors(one: Compared, curve: Coefficients) -> list[float]:
    """Return the rms errors of the coefficients [-], in the order of ``SYMBOLS``."""
    return [rms(coefficient_error(one, curve, part)) for part in SYMBOLS]


def camber_sheet(one: Compared, curves: dict[str, Coefficients]) -> str:
    """Return the data of the figure on camber as CSV."""
    advance, thrust, power = measured_coefficients(one.data)
    columns = {"advance_ratio": advance, "measured_C_T": thrust, "measured_C_P": power}
    for label, curve in curves.items():
        for part, symbol in SYMBOLS.items():
            columns[f"{_slug(label)}_{symbol}_error"] = coefficient_error(one, curve, part)
    return csv_of_columns([columns])


def error_rows(errors: list[LoadError]) -> list[tuple[str, ...]]:
    """Return load, model, errors and share of points within 9 % for one data set."""
    above = ["", *(e.load for e in errors)]
    return [
        (
            "" if e.load == before else e.load.replace("_", " "),
            e.model,
            f"{number(e.rms, 2)} {e.unit}",
            f"{100 * e.rms_share:.0f}",
            f"{number(e.worst, 2)} {e.unit}",
            f"{100 * e.worst_share:.0f}",
            f"{100 * e.within_nine:.0f}",
        )
        for e, before in zip(errors, above, strict=False)
    ]


def sheets(found: dict[str, Compared], errors: list[LoadError]) -> dict[str, str]:
    """Return the CSV files by name."""
    return {file: _loads_sheet(found[data]) for data, file in FILES_OF_DATA.items()} | {
        "figure-7-errors": csv_of_rows(
            "data_set load model points unit rms_error_in_unit worst_error_in_unit "
            "rms_over_rms_measured worst_over_largest_measured share_within_9_percent",
            errors,
        )
    }  # fmt: skip


def _slug(label: str) -> str:
    """Convert a label to a part of a column name."""
    return label.lower().replace(",", "").replace(" ", "_")


def _loads_sheet(one: Compared) -> str:
    data = one.data
    columns: dict[str, Any] = {"rpm": data.omega / RPM, "speed_mps": data.speed}
    columns["beta_deg"] = np.degrees(data.beta)
    for load, truth in data.loads.items():
        columns[f"measured_{LOADS[load].column}"] = truth
        for model, values in one.predicted.items():
            if load in values:
                columns[f"{_slug(model)}_{LOADS[load].column}"] = values[load]
    return csv_of_columns([columns])


def _look(k: int) -> dict[str, Any]:
    """Return the style of the markers on axial line k."""
    return {"color": COLORS[k], "marker": MARKERS[k + 1], "markersize": 5.0}


def _flow(curve: ThrustCurve) -> str:
    if curve.speed == 0.0:
        return "at rest"
    return f"{curve.speed:g} m/s, β = {np.degrees(curve.beta):.0f}°"
