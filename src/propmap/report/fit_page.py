"""The page on a fit: whether it can be trusted, where, and the files beside the page."""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from propmap.baselines.hover import HoverModel
from propmap.fit.comparison import SpeedErrors, Trend, level_forces
from propmap.fit.files import DataSource, FitFile, FitRecord, FittedLoad
from propmap.fit.fit import Covered, CoveredAngle
from propmap.fit.least_squares import ResidualErrors
from propmap.fit.parameters import EVERY, general
from propmap.fit.tunnel import TunnelData
from propmap.loads import LOADS
from propmap.report import fit_curves
from propmap.report.fit_curves import held, level_flight, tunnel_fit
from propmap.report.html import (
    BAND,
    COLOURS,
    HOVER,
    MARKERS,
    RPM,
    csv_of_columns,
    csv_of_rows,
    key,
    legend_below,
    new_figure,
    number,
    report_files,
    style,
)
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.vehicle.log import GRAVITY, FlightLog
from propmap.vehicle.vehicle import Vehicle

# -------------------------------------------------------------------------------------------------
# The page on a fit and the files beside it.


def fit_pages(
    file: FitFile, where: str, sha256: str, given: GivenData | None
) -> dict[str, str | bytes]:
    """All files of the page on a fit by name.

    Parameters
    ----------
    file : FitFile
        The fit.
    where, sha256 : str
        Its path and its SHA-256.
    given : GivenData or None
        Further data.
    """
    fit, lines = file.record, fit_curves.load_curves(file)
    bands = {(one.name, one.unit): one.by_speed for one in fit.loads}
    figures = {
        "fit-coverage": coverage_figure(fit),
        "fit-errors": band_figure(bands),
        "fit-loads": fit_curves.curve_figure(lines, given.tunnel if given else None),
        "fit-parameters": interval_figure(fit),
    }
    sheets = {
        "fit-coverage": coverage_sheet(fit),
        "fit-errors": band_sheet(bands),
        "fit-loads": fit_curves.curve_sheet(lines),
        "fit-parameters": parameter_sheet(fit),
        "fit-correlations": correlation_sheet(fit),
    }
    if given:
        figures["fit-check"] = band_figure(given.bands)
        sheets["fit-check"] = band_sheet(given.bands)
        shown, sheet = given.figure(file), given.sheet(file)
        if shown is not None and sheet is not None:
            figures["fit-measured"], sheets["fit-measured"] = shown, sheet
        for k, trends in enumerate(given.residuals, start=1):
            figures[f"fit-residuals-{k}"] = residual_figure(trends)
            sheets[f"fit-residuals-{k}"] = residual_sheet(trends)
    return report_files(
        "report/fit_page.html.j2",
        figures,
        sheets,
        file=file,
        fit=fit,
        where=where,
        sha256=sha256,
        given=given,
        page=sys.modules[__name__],
        bands=bands,
        curves=lines,
        held=held(fit),
    )


# -------------------------------------------------------------------------------------------------
# Whether a fit can be trusted, and where.

GOOD, CARE = 0.05, 0.15
"""Rms error as a share of what was measured, up to which a load is trusted, or with care."""

WORDS = {"good": "Yes", "caution": "With care", "bad": "No"}
"""Levels of trust, from best to worst, in words."""

FORCES = {
    "vertical_force": "vertical force",
    "force_x": "force forward",
    "force_y": "force to the side",
    "force_z": "force up",
}
"""What is fitted in flight, in words."""

NARROW = 2.0
"""Range of speeds [m/s] below which the data are from one speed."""

OVERFITTED = 1.5
"""Cross-validated error over the error left, above which parameters follow the noise."""


@dataclass(frozen=True)
class Judged:
    """One load: its typical error and the hover model's, as shares of ``reference`` [unit]."""

    load: FittedLoad
    reference: float
    error: float
    hover: float

    @property
    def label(self) -> str:
        """The load in words."""
        return label_of(self.load.name)

    @property
    def level(self) -> str:
        """By the error, and never better than "caution" where the hover model is as good."""
        found = level_of(self.error)
        return "caution" if found == "good" and not self.error < self.hover else found

    def both(self, rms: float, hover_rms: float) -> str:
        """Errors [unit] of this model and of the hover model as shares of the reference [%]."""
        own, hover = (number(100.0 * value / self.reference, 2) for value in (rms, hover_rms))
        return f"{own} / {hover}"


def overall(fit: FitRecord) -> str:
    """The level of trust in a fit, one of ``WORDS``, by the errors on its data."""
    levels = [one.level for one in judged(fit)]
    return worst_of([*levels, "caution"] if warnings(fit) else levels)


def judged(fit: FitRecord) -> list[Judged]:
    """Every fitted load; its error is the cross-validated one where there is one.

    Forces on a vehicle are compared with the largest of them, which is about the weight: across
    the flight there is next to nothing to compare with.
    """
    sizes = [one.measured_rms for one in fit.loads]
    if fit.kind != "tunnel":
        sizes = len(sizes) * [max(filter(math.isfinite, sizes), default=math.nan)]
    found = []
    for one, size in zip(fit.loads, sizes, strict=True):
        error = one.cross_validated if math.isfinite(one.cross_validated) else one.rms
        found.append(Judged(one, size, error / size, one.hover_rms / size))
    return found


def label_of(name: str) -> str:
    """A load or a force in words."""
    return LOADS[name].label if name in LOADS else FORCES.get(name, name)


def level_of(share: float) -> str:
    """The level of trust for a relative error; NaN is bad."""
    if share <= GOOD:
        return "good"
    return "caution" if share <= CARE else "bad"


def worst_of(levels: Iterable[str]) -> str:
    """The worst of several levels."""
    return max(levels, key=list(WORDS).index)


def shown_band(band: str) -> str:
    """A band of speed with a dash and without a line break."""
    return band.replace("-", "\N{EN DASH}").replace(" ", "\N{NO-BREAK SPACE}")


def where(fit: FitRecord) -> str:
    """Speeds, rotational speeds and angles of the data."""
    covered = fit.covered
    (slow, fast), (low, high) = covered.speed, covered.rpm
    speeds = f"{slow:.1f} m/s" if fast - slow < 0.05 else f"{slow:.1f} to {fast:.1f} m/s"
    ends = [end for one in covered.main_angles for end in one.beta]
    if not ends:
        angles = "at rest only"
    elif max(ends) - min(ends) < 0.5:
        angles = f"β = {min(ends):.0f}°"
    else:
        angles = f"β from {min(ends):.0f}° to {max(ends):.0f}°"
    return f"{speeds}, {low:.0f} to {high:.0f} rpm, {angles}"


def speed_rows(fit: FitRecord) -> list[tuple[str, ...]]:
    """Speed, rows, both models' errors by load [%], and a word; a row per band of speed."""
    loads, rows = judged(fit), []
    for band in dict.fromkeys(band for one in fit.loads for band in one.by_speed):
        found = [one.load.by_speed.get(band) for one in loads]
        pairs = list(zip(loads, found, strict=True))
        cells = ["" if e is None else one.both(e.rms, e.hover_rms) for one, e in pairs]
        level = worst_of(level_of(e.rms / one.reference) for one, e in pairs if e)
        count = max(e.rows for e in found if e)
        rows.append((shown_band(band), str(count), *cells, WORDS[level]))
    return rows


def warnings(fit: FitRecord) -> list[str]:
    """What takes trust away."""
    found = []
    if fit.covered.speed[1] - fit.covered.speed[0] < NARROW:
        found.append("the data are from one speed: the fit has hardly been tested against speed")
    for one in judged(fit):
        if not one.error < one.hover:
            found.append(f"{one.label}: the hover model is no worse")
        ratio = one.load.cross_validated / one.load.rms if one.load.rms > 0.0 else math.nan
        if math.isfinite(ratio) and ratio > OVERFITTED:
            found.append(
                f"{one.label}: on rows left out the error is {ratio:.1f} times as large, so that "
                "some parameters follow the noise"
            )
    if fit.unsolved:
        found.append(f"of {fit.rows} rows, {fit.unsolved} have no solution in the model")
    return found


def notes(fit: FitRecord) -> list[str]:
    """What is worth knowing besides."""
    found = list(fit.remarks)
    if fit.minima > 1:
        found.append(
            f"{len(fit.starts)} starts ended in {fit.minima} different minima; the best is used"
        )
    if not any(math.isfinite(one.cross_validated) for one in fit.loads):
        found.append("no cross-validation was done: the errors are those on the fitted data")
    return found


def unfitted(fit: FitRecord) -> list[str]:
    """Loads that a fit of tunnel data did not see, in words."""
    names = [one.name for one in fit.loads]
    return [load.label for name, load in LOADS.items() if name not in names]


# -------------------------------------------------------------------------------------------------
# What a fit was fitted to, and where it extrapolates.

GAP, STEP = 22.5, 15
"""[deg]: angles further than the first from all data have none; they are told in such steps."""


@style()
def coverage_figure(fit: FitRecord) -> Figure:
    """Boxes over advance ratio and angle, with the number of operating points in each."""
    figure = new_figure(8.6, 3.6)
    ax = figure.subplots()
    small: dict[str, Any] = {"textcoords": "offset points", "fontsize": 8.0}
    for one in fit.covered.angles:
        left, right = one.advance
        # A single angle gets a box that can be seen.
        low, high = (
            min(one.beta[0], one.typical_beta - 1.5),
            max(one.beta[1], one.typical_beta + 1.5),
        )
        ax.fill([left, right, right, left], [low, low, high, high], facecolor=COLOURS[0],
                alpha=0.35, edgecolor=COLOURS[0], linewidth=1.2)  # fmt: skip
        ax.annotate(str(one.points), (right, 0.5 * (low + high)), (4, 0), va="center", **small)
    rest = fit.covered.at_rest
    if rest is not None:
        cross: dict[str, Any] = {
            "marker": "X",
            "markersize": 7.0,
            "linestyle": "none",
            "clip_on": False,
        }
        ax.plot(0.0, 0.0, color=COLOURS[1], **cross)
        ax.annotate(f"at rest: {rest.points}", (0.0, 0.0), (8, 5), **small)
    top = max((one.advance[1] for one in fit.covered.angles), default=0.2)
    descent = max((one.beta[1] for one in fit.covered.angles), default=90.0) > 95.0
    ax.set_xlim(0.0, 1.25 * top)
    ax.set_ylim(-8.0, 185.0 if descent else 98.0)
    ax.set_yticks(np.arange(0, 181 if descent else 91, 30))
    ax.set_xlabel("advance ratio V/(ΩR) [-]")
    ax.set_ylabel("angle β of the flow to the axis [deg]")
    ax.set_title("numbers: operating points in each group", fontsize=9.0)
    return figure


def file_rows(fit: FitRecord) -> list[tuple[str, str]]:
    """Name and SHA-256; a row per file."""
    return [(one.name, one.sha256 or "part of propmap") for one in fit.data]


def range_rows(fit: FitRecord) -> list[tuple[str, ...]]:
    """Angle, points, speeds, rotational speeds and advance ratios; a row per group."""
    return [
        (
            name,
            str(one.points),
            f"{one.speed[0]:.1f} to {one.speed[1]:.1f}",
            f"{one.rpm[0]:.0f} to {one.rpm[1]:.0f}",
            f"{one.advance[0]:.3f} to {one.advance[1]:.3f}",
        )
        for name, one in _groups(fit).items()
    ]


def coverage_sheet(fit: FitRecord) -> str:
    """The ranges as CSV."""
    return csv_of_rows(
        "group points beta_from_deg beta_to_deg speed_from_mps speed_to_mps rpm_from rpm_to "
        "advance_from advance_to",
        [
            (
                name,
                one.points,
                *(one.beta if isinstance(one, CoveredAngle) else (None, None)),
                *one.speed,
                *one.rpm,
                *one.advance,
            )
            for name, one in _groups(fit).items()
        ],
    )


def angles_without_data(fit: FitRecord) -> str:
    """Angles far from all data, such as "30° to 60° and about 180°"; empty if there are none."""
    angles = [one.typical_beta for one in fit.covered.main_angles]
    far = [beta for beta in range(0, 181, STEP) if all(abs(beta - a) > GAP for a in angles)]
    spans = []
    for _, group in itertools.groupby(enumerate(far), lambda pair: pair[1] - STEP * pair[0]):
        _, run = zip(*group, strict=True)
        spans.append(f"{run[0]}° to {run[-1]}°" if len(run) > 1 else f"about {run[0]}°")
    return " and ".join(spans)


def _groups(fit: FitRecord) -> dict[str, Covered]:
    """The points at rest and those about each angle, by name."""
    rest = fit.covered.at_rest
    named: dict[str, Covered] = {} if rest is None else {"at rest": rest}
    return named | {f"{one.typical_beta:.0f}°": one for one in fit.covered.angles}


# -------------------------------------------------------------------------------------------------
# A fit against the data given with the report.


@dataclass(frozen=True, eq=False)
class GivenData:
    """Data beside the fit file, compared with the fit.

    Attributes
    ----------
    sources : sequence of DataSource
        Of the data.
    errors : mapping of str to SpeedErrors
        By load with its unit, such as "torque_Nm".
    tunnel : TunnelData, optional
        The rows, where they are from a tunnel.
    level : tuple of Vehicle and FlightLog, optional
        What flew, and its steady operating points, where these were given.
    residuals : sequence of sequence of Trend
        Of each force of whole flights, its residual against every candidate.
    """

    sources: Sequence[DataSource]
    errors: Mapping[str, SpeedErrors]
    tunnel: TunnelData | None = None
    level: tuple[Vehicle, FlightLog] | None = None
    residuals: Sequence[Sequence[Trend]] = ()

    @property
    def bands(self) -> Bands:
        """Errors by load with its unit, then by band of speed."""
        return {_parted(name): one.by_speed for name, one in self.errors.items()}

    @property
    def verdict(self) -> dict[str, Any]:
        """Level of trust, number of rows, and the label and both models' errors of each load.

        Errors are shares of what was measured; those of forces in flight, of the largest force.
        """
        found = {n: c.all for n, c in self.errors.items() if c.all.rows}
        sizes = {n: e.rms / e.relative_rms for n, e in found.items()}
        if self.tunnel is None:
            largest = max(filter(math.isfinite, sizes.values()), default=math.nan)
            sizes = dict.fromkeys(found, largest)
        errors = [
            (label_of(_parted(n)[0]), e.rms / sizes[n], e.hover_rms / sizes[n])
            for n, e in found.items()
        ]
        level = worst_of([level_of(own) for _, own, _ in errors] or ["bad"])
        rows = max((e.rows for e in found.values()), default=0)
        return {"level": level, "rows": rows, "errors": errors}

    def known_to(self, fit: FitRecord) -> tuple[list[str], list[str]]:
        """Names of the data that the fit has not seen, and of those that it has."""
        seen = {one.sha256 or one.name for one in fit.data}
        names: tuple[list[str], list[str]] = ([], [])
        for one in self.sources:
            names[(one.sha256 or one.name) in seen].append(one.name)
        return names

    def figure(self, file: FitFile) -> Figure | None:
        """Measured beside predicted; None where the data are neither from a tunnel nor steady."""
        if self.tunnel is not None:
            return tunnel_fit(self.tunnel, Rotor(file.model))
        return None if self.level is None else level_flight(*self.level, file.airfoil)

    def sheet(self, file: FitFile) -> str | None:
        """The figure's numbers as CSV."""
        if self.tunnel is not None:
            data, rotor = self.tunnel, Rotor(file.model)
            found = rotor.loads(data.omega, data.speed, data.beta)
            still = HoverModel.of(rotor).loads(data.omega)
            columns: dict[str, Any] = {"rpm": data.omega * RPM, "speed_mps": data.speed}
            columns["beta_deg"] = np.degrees(data.beta)
            for name, values in data.loads.items():
                columns[f"measured_{LOADS[name].column}"] = values
                columns[f"model_{LOADS[name].column}"] = getattr(found, name)
                columns[f"hover_{LOADS[name].column}"] = still[name]
            return csv_of_columns([columns])
        if self.level is None:
            return None
        vehicle, log = self.level
        model, hover = level_forces(vehicle, log, file.airfoil, file.values)
        return csv_of_columns(
            [
                {
                    "speed_mps": log.speed,
                    "weight_N": vehicle.mass * GRAVITY,
                    "model_vertical_force_N": model,
                    "hover_vertical_force_N": hover,
                }
            ]
        )


def _parted(name: str) -> tuple[str, str]:
    """Load and unit of a name such as "torque_Nm"."""
    load, _, unit = name.rpartition("_")
    return load, {"Nm": "N m"}.get(unit, unit)


# -------------------------------------------------------------------------------------------------
# Errors by load and band of speed, beside the hover model's.

Bands = Mapping[tuple[str, str], Mapping[str, ResidualErrors]]
"""Errors by load with its unit, then by band of speed."""


@style()
def band_figure(bands: Bands) -> Figure:
    """A panel per load; bands in the order of speed."""
    columns = min(len(bands), 3)
    rows = -(-len(bands) // columns)
    figure = new_figure(8.6, 2.7 * rows + 0.4)
    axes = figure.subplots(rows, columns, squeeze=False).ravel()
    for ax in axes[len(bands) :]:
        ax.axis("off")
    for ax, ((load, unit), found) in zip(axes, bands.items(), strict=False):
        x, errors = range(len(found)), found.values()
        ax.plot(
            x, [e.hover_rms for e in errors], marker="x", markersize=5.0, label="hover model",
            **HOVER,
        )  # fmt: skip
        ax.plot(
            x, [e.rms for e in errors], color=COLOURS[0], marker=MARKERS[0], markersize=4.5,
            linewidth=1.6, label="this model",
        )  # fmt: skip
        ax.set_xticks(list(x), [_tick(band) for band in found])
        ax.tick_params(axis="x", labelsize=7.5)
        ax.set_ylim(bottom=0.0)
        ax.margins(x=0.08)
        ax.set_ylabel(f"{label_of(load)}: rms error [{unit}]")
        ax.set_xlabel("flight speed V [m/s]")
    legend_below(figure, axes[0].get_legend_handles_labels()[0][::-1])
    return figure


def band_rows(bands: Bands) -> list[tuple[str, ...]]:
    """Load, speed, rows, rms, the hover model's, mean and worst; a row per load and band."""
    return [
        (
            f"{label_of(load)} [{unit}]" if k == 0 else "",
            shown_band(band),
            str(e.rows),
            *(number(v, 2) for v in (e.rms, e.hover_rms, e.bias, e.worst)),
        )
        for (load, unit), found in bands.items()
        for k, (band, e) in enumerate(found.items())
    ]


def band_sheet(bands: Bands) -> str:
    """The same as CSV."""
    return csv_of_rows(
        "load unit speed_band rows rms_in_unit mean_in_unit worst_in_unit hover_rms_in_unit",
        [
            (*load, band, e.rows, e.rms, e.bias, e.worst, e.hover_rms)
            for load, found in bands.items()
            for band, e in found.items()
        ],
    )


def whole_rows(loads: Sequence[Judged]) -> list[tuple[str, ...]]:
    """Load, rows, and three errors with their shares: rms, cross-validated, the hover model's."""
    rows = []
    for one in loads:
        errors = (one.load.rms, one.load.cross_validated, one.load.hover_rms)
        cells = [
            (f"{number(e)} {one.load.unit}", number(100.0 * e / one.reference, 2)) for e in errors
        ]
        if not math.isfinite(one.load.cross_validated):
            cells[1] = ("not done", number(None))
        rows.append((one.label, str(one.load.rows), *itertools.chain(*cells)))
    return rows


def _tick(band: str) -> str:
    """A band of speed, short enough to stand beside its neighbours."""
    return shown_band(band.removesuffix(" m/s")).replace("above\N{NO-BREAK SPACE}", "> ")


# -------------------------------------------------------------------------------------------------
# The fitted parameters: values, intervals, verdicts, and correlations.

STRONG = 0.9
"""Correlation from which two parameters are named as a pair."""


@style()
def interval_figure(fit: FitRecord) -> Figure:
    """A line per parameter, from its lower to its upper bound."""
    count = len(fit.parameters)
    figure = new_figure(8.6, 0.32 * count + 0.8)
    ax = figure.subplots()
    for k, p in enumerate(fit.parameters):
        low, value, high = ((v - p.lower) / (p.upper - p.lower) for v in (p.low, p.value, p.high))
        face = COLOURS[0] if p.identified else "white"
        ax.plot([0.0, 1.0], [k, k], color="0.85", linewidth=5.0, solid_capstyle="butt")
        ax.plot([low, high], [k, k], color=COLOURS[0], linewidth=2.0)
        ax.plot(value, k, marker="o", color=COLOURS[0], markerfacecolor=face, clip_on=False)
    ax.set_yticks(range(count), [p.name for p in fit.parameters])
    ax.set_ylim(count - 0.5, -0.5)
    ax.set_xticks([0.0, 1.0], ["lower bound", "upper bound"])
    ax.grid(visible=False)
    ax.tick_params(length=0.0)
    for side in ax.spines.values():
        side.set_visible(False)
    return figure


def parameter_rows(fit: FitRecord) -> list[tuple[str, ...]]:
    """Name, meaning, value, 95 % interval, unit, verdict and its reason; a row per parameter."""
    return [
        (
            p.name,
            EVERY[general(p.name)].meaning if general(p.name) in EVERY else "",
            number(p.value, 4),
            f"{number(p.low)} to {number(p.high)}",
            p.unit,
            "identified" if p.identified else "weak",
            p.verdict.removeprefix("weak").removeprefix("identified").lstrip(":, "),
        )
        for p in fit.parameters
    ]


def correlation_rows(fit: FitRecord) -> list[tuple[str, ...]]:
    """Name and correlations with every parameter; a row per parameter."""
    return [
        (p.name, *(number(round(v, 2) + 0.0 if np.isfinite(v) else None, 2) for v in row))
        for p, row in zip(fit.parameters, fit.correlation.tolist(), strict=True)
    ]


def strong_pairs(fit: FitRecord) -> list[str]:
    """Pairs of parameters with a strong correlation, such as "c_l1 and alpha_0"."""
    pairs = itertools.combinations(enumerate(p.name for p in fit.parameters), 2)
    return [f"{a} and {b}" for (i, a), (j, b) in pairs if abs(fit.correlation[i, j]) >= STRONG]


def parameter_sheet(fit: FitRecord) -> str:
    """Values, intervals and bounds as CSV."""
    return csv_of_rows(
        "parameter unit value low_95 high_95 lower_bound upper_bound identified verdict",
        [
            (p.name, p.unit, p.value, p.low, p.high, p.lower, p.upper, int(p.identified), p.verdict)
            for p in fit.parameters
        ],
    )


def correlation_sheet(fit: FitRecord) -> str:
    """The correlations as CSV."""
    names = [p.name for p in fit.parameters]
    rows = [(n, *row) for n, row in zip(names, fit.correlation.tolist(), strict=True)]
    return csv_of_rows(" ".join(("parameter", *names)), rows)


# -------------------------------------------------------------------------------------------------
# Pictures of what a model leaves over, against every variable that it may depend on.

BINS = 8
"""Of equal numbers of samples."""

SPREAD = (10.0, 90.0)
"""Percentiles of the residuals of a bin that are shaded."""

COLUMNS = 5


def binned(trend: Trend) -> dict[str, Floats]:
    """Bins of a ``trend``: ends, middle, mean residual, its block-wise standard error, percentiles.

    Of each, an array (bins,); errors within a stretch of time count as one.
    """
    ends = np.unique(np.percentile(trend.at, np.linspace(0.0, 100.0, BINS + 1)))
    place = np.clip(np.searchsorted(ends, trend.at, side="right") - 1, 0, max(ends.size - 2, 0))
    rows = []
    for k in np.unique(place):
        mine = place == k
        off = trend.residual[mine]
        _, block = np.unique(trend.block[mine], return_inverse=True)
        sums = np.bincount(block, weights=off - off.mean())
        error = float(np.sqrt(sums @ sums)) / off.size
        low, high = ends[k], ends[min(k + 1, ends.size - 1)]
        middle = float(np.mean(trend.at[mine]))
        rows.append((low, high, middle, off.mean(), error, *np.percentile(off, SPREAD), off.size))
    names = ("from", "to", "middle", "mean", "error", "low", "high", "samples")
    return dict(zip(names, np.array(rows).T, strict=True))


@style()
def residual_figure(trends: Sequence[Trend]) -> Figure:
    """Residuals of one load against every candidate, the strongest first.

    Parameters
    ----------
    trends : sequence of Trend
        Of one load.
    """
    rows = -(-len(trends) // COLUMNS)
    figure = new_figure(11.5, 2.25 * rows + 0.7)
    axes = figure.subplots(rows, COLUMNS, squeeze=False, sharey=True)
    for ax in axes.ravel()[len(trends) :]:
        ax.axis("off")
    for ax, trend in zip(axes.ravel(), trends, strict=False):
        colour, found = COLOURS[1 if trend.sure else 0], binned(trend)
        ax.axhline(0.0, color="0.5", linewidth=0.8)
        ax.fill_between(found["middle"], found["low"], found["high"], color=colour, **BAND)
        ax.errorbar(
            found["middle"], found["mean"], 2.0 * found["error"], color=colour, marker="o",
            markersize=3.5, linewidth=1.3, elinewidth=1.0, capsize=2.0,
        )  # fmt: skip
        ax.set_xlabel(_in_two_lines(trend.variable), fontsize=7.5)
        ax.tick_params(labelsize=7.5)
        share = f"{100.0 * trend.share:.0f} % of the variance"
        ax.set_title(share, fontsize=8.0, fontweight="bold" if trend.sure else "normal")
    for ax in axes[:, 0]:
        ax.set_ylabel(f"error [{trends[0].unit}]")
    look: dict[str, Any] = {"marker": "o", "markersize": 4.0, "linewidth": 1.3}
    legend_below(
        figure,
        [
            key("still explains something", color=COLOURS[1], **look),
            key("no more than chance, or little", color=COLOURS[0], **look),
            key("mean and two standard errors of it, by stretches of 1 s", color="0.3", **look),
            key("middle 80 % of the samples", color="0.7", linewidth=6.0),
        ],
        fontsize=8.5,
    )
    figure.suptitle(f"{label_of(trends[0].load)}: model minus measurement")
    return figure


def residual_sheet(trends: Sequence[Trend]) -> str:
    """The bins as CSV; ``trends`` are those of one load."""
    groups = []
    for trend in trends:
        found = binned(trend)
        name, _, unit = trend.variable.rstrip("]").partition(" [")
        groups.append(
            {
                "load": trend.load,
                "unit": trend.unit,
                "variable": name,
                "variable_unit": unit,
                "share_of_variance": trend.share,
                "slope": trend.slope,
                "slope_error": trend.error,
                **{f"bin_{end}": found[end] for end in ("from", "to", "middle")},
                "mean_in_unit": found["mean"],
                "mean_error_in_unit": found["error"],
                "low_10_in_unit": found["low"],
                "high_90_in_unit": found["high"],
                "samples": found["samples"],
            }
        )
    return csv_of_columns(groups)


def sentences(loads: Sequence[Sequence[Trend]]) -> list[str]:
    """What still explains something, the strongest first; a sequence of trends per load."""
    telling = [trend for trend in itertools.chain(*loads) if trend.sure]
    return [trend.sentence for trend in sorted(telling, key=lambda trend: -trend.share)]


def _in_two_lines(name: str) -> str:
    """A long name broken before its unit."""
    name = name.replace("^2", "²")
    return name.replace(" [", "\n[") if len(name) > 24 else name
