"""The report on a fit: its reliability, range, errors and parameters, as a page and files."""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from propmap.fit.comparison import INSIDE, OUTSIDE, SpeedErrors, Trend, level_forces, useless
from propmap.fit.files import DataSource, FitFile, FitRecord, FittedLoad
from propmap.fit.fit import CoveredAngle
from propmap.fit.flight import MOMENTS
from propmap.fit.least_squares import ResidualErrors
from propmap.fit.parameters import EVERY, general
from propmap.fit.tunnel import TunnelData
from propmap.loads import LOADS
from propmap.model.envelope import Beyond
from propmap.report import fit_curves, html
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import GRAVITY
from propmap.vehicle.log import FlightLog
from propmap.vehicle.vehicle import Vehicle

# Relative rms error up to which a load is reliable, and up to which it is usable with care.
GOOD, CARE = 0.05, 0.15
WORDS = {"good": "Reliable", "caution": "Use with care", "bad": "Not reliable"}  # best first
FORCES = {
    "vertical_force": "vertical force",
    "force_x": "forward force",
    "force_y": "lateral force",
    "force_z": "upward force",
    "moment_x": "moment about x",
    "moment_y": "moment about y",
    "moment_z": "moment about z",
}  # labels of the forces and moments that are fitted in flight
NARROW = 2.0  # range of airspeeds [m/s] below which the data count as one airspeed
OVERFITTED = 1.5  # ratio of cross-validated to fitted error above which a fit follows the noise
STRONG = 0.9  # correlation above which the page lists a pair of parameters
GAP, STEP = 22.5, 15  # [deg] distance from all data, and step, of angles listed as without data
BINS, SPREAD = 8, (10.0, 90.0)  # number of bins of residuals; percentiles that limit the shading
ASKED = 0.05  # fraction of the given samples beyond the fit's data above which the page warns
PANELS = 5  # panels of residuals in a row


@dataclass(frozen=True, eq=False)
class GivenData:
    """Data of the option ``--data``, compared with the fit."""

    sources: Sequence[DataSource]
    errors: Mapping[str, SpeedErrors]  # by load with unit, as "torque_Nm"
    tunnel: TunnelData | None = None
    level: tuple[Vehicle, FlightLog] | None = None  # vehicle and its steady operating points
    residuals: Sequence[Sequence[Trend]] = ()  # of each force, against all candidate variables
    beyond: Beyond | None = None  # excess of the samples over the range of the fit's data


def fit_pages(
    file: FitFile, where: str, sha256: str, given: GivenData | None
) -> dict[str, str | bytes]:
    """Return all files of the report on a fit by name; ``where`` is the path of the fit."""
    fit = file.record
    lines, facts = fit_curves.load_lines(file, given.tunnel if given else None)
    records = [
        coverage(fit),
        band_errors("fit-errors", {(one.name, one.unit): one.by_speed for one in fit.loads}),
        lines,
        parameters(fit),
        correlations(fit),
    ]
    check: dict[str, Any] = {}
    level, beyond = overall(fit), []
    if given:
        check = _check(fit, given)
        beyond = check["beyond"]
        level = worst_of([level, check["level"]]) if beyond else level
        bands = {_load_and_unit(name): one.by_speed for name, one in given.errors.items()}
        records.append(band_errors("fit-check", bands))
        if given.tunnel is not None:
            records.append(fit_curves.tunnel_fit(given.tunnel, Rotor(file.model)))
        elif given.level is not None:
            vehicle, log = given.level
            model, hover = level_forces(vehicle, log, file.airfoil, file.values)
            columns = {
                "speed_mps": log.speed,
                "weight_N": vehicle.mass * GRAVITY,
                "model_vertical_force_N": model,
                "hover_vertical_force_N": hover,
            }

            def draw() -> Figure:
                return fit_curves.level_flight(vehicle, log, file.airfoil)

            records.append(html.FigureRecord("fit-measured", [columns], draw))
        records += [
            residuals(f"fit-residuals-{k}", trends)
            for k, trends in enumerate(given.residuals, start=1)
        ]
    return html.record_files(
        "report/fit_page.html.j2",
        records,
        file=file,
        fit=fit,
        where=where,
        sha256=sha256,
        given=given,
        check=check,
        level=level,
        beyond=beyond,
        files=[(one.name, one.sha256 or "part of propmap") for one in fit.data],
        page=sys.modules[__name__],
        curves=facts,
        held=fit_curves.held(fit),
    )


def _check(fit: FitRecord, given: GivenData) -> dict[str, Any]:
    """Return the values of the template for the given data: level, rows, relative errors, names of
    held-out and of fitted data, and sentences on samples beyond the fit's data.

    Errors are relative to the measured load, in flight to the largest force.
    """
    found = {name: one.all for name, one in given.errors.items() if one.all.rows}
    sizes = {name: e.rms / e.relative_rms for name, e in found.items()}
    loads = {name: _load_and_unit(name)[0] for name in found}
    if given.tunnel is None:
        sizes = _beside_largest(sizes, loads)
    errors = [
        (label_of(loads[name]), e.rms / sizes[name], e.hover_rms / sizes[name])
        for name, e in found.items()
    ]
    forces = [name for name, load in loads.items() if load not in MOMENTS]
    seen = {one.sha256 or one.name for one in fit.data}
    names: tuple[list[str], list[str]] = ([], [])
    for one in given.sources:
        names[(one.sha256 or one.name) in seen].append(one.name)
    levels = [level_of(found[name].rms / sizes[name]) for name in forces] or ["bad"]
    beyond = []
    if given.beyond is not None and np.mean(given.beyond.samples) > ASKED:
        outside = {n: one for n, one in given.errors.items() if one.by_envelope[OUTSIDE].rows}
        beyond = [*given.beyond.sentences("rows"), *_errors_beyond(outside)]
        levels.append("caution")
        far = {name: outside[name].by_envelope[OUTSIDE].rms for name in forces if name in outside}
        levels += [level_of(one / sizes[name]) for name, one in far.items()]
    return {
        "level": worst_of(levels),
        "beyond": beyond,
        "rows": max((e.rows for e in found.values()), default=0),
        "errors": errors,
        "useless": [
            text for name, e in found.items() for text in useless(loads[name], e.relative_rms)
        ],
        "new": names[0],
        "known": names[1],
    }


def _errors_beyond(errors: Mapping[str, SpeedErrors]) -> list[str]:
    """Return a sentence with the errors beyond and within the range of the fit's data."""
    parts = []
    for name, one in errors.items():
        load, unit = _load_and_unit(name)
        inside = one.by_envelope.get(INSIDE)
        beside = f" ({html.number(inside.rms)} within the data)" if inside else ""
        parts.append(f"{label_of(load)} {html.number(one.by_envelope[OUTSIDE].rms)} {unit}{beside}")
    return [f"the rms errors of these samples are {', '.join(parts)}"] if parts else []


def _load_and_unit(name: str) -> tuple[str, str]:
    """Split a name such as "torque_Nm" into load and unit."""
    load, _, unit = name.rpartition("_")
    return load, {"Nm": "N m"}.get(unit, unit)


# --- Reliability of a fit, overall and by airspeed -----------------------------------------------


@dataclass(frozen=True)
class JudgedLoad:
    """Typical errors of a load by this model and the hover model, relative to ``reference``."""

    load: FittedLoad
    reference: float
    error: float
    hover: float

    @property
    def label(self) -> str:
        """Return the label of the load."""
        return label_of(self.load.name)

    @property
    def level(self) -> str:
        """Return the level by the error; at best "caution" if the hover model is as accurate."""
        found = level_of(self.error)
        return "caution" if found == "good" and not self.error < self.hover else found


def overall(fit: FitRecord) -> str:
    """Return the reliability of a fit, a key of ``WORDS``, from the errors on its data."""
    levels = [one.level for one in judged(fit) if one.load.name not in MOMENTS]
    return worst_of([*levels, "caution"] if warnings(fit) else levels)


def judged(fit: FitRecord) -> list[JudgedLoad]:
    """Return the relative errors of all fitted loads, cross-validated if available.

    Forces on a vehicle are relative to the largest force, about the weight, because the lateral
    force is almost zero.
    """
    sizes = {one.name: one.measured_rms for one in fit.loads}
    if fit.kind != "tunnel":
        sizes = _beside_largest(sizes, {name: name for name in sizes})
    found = []
    for one in fit.loads:
        error, size = one.rms, sizes[one.name]
        if math.isfinite(one.cross_validated):
            error = one.cross_validated
        found.append(JudgedLoad(one, size, error / size, one.hover_rms / size))
    return found


def _beside_largest(sizes: Mapping[str, float], loads: Mapping[str, str]) -> dict[str, float]:
    """Return the references by load: the largest force for forces, its own size for a moment."""
    own = {key: size for key, size in sizes.items() if loads[key] in MOMENTS}
    forces = [size for key, size in sizes.items() if key not in own and math.isfinite(size)]
    return dict.fromkeys(sizes, max(forces, default=math.nan)) | own


def label_of(name: str) -> str:
    """Return the label of a load, or of a force or moment on a vehicle."""
    return LOADS[name].label if name in LOADS else FORCES.get(name, name)


def level_of(share: float) -> str:
    """Return the reliability for a relative error; NaN is "bad"."""
    if share <= GOOD:
        return "good"
    return "caution" if share <= CARE else "bad"


def worst_of(levels: Iterable[str]) -> str:
    """Return the worst of several levels."""
    return max(levels, key=list(WORDS).index)


def _shown_band(band: str) -> str:
    """Return an airspeed range with a dash and non-breaking spaces."""
    return band.replace("-", "\N{EN DASH}").replace(" ", "\N{NO-BREAK SPACE}")


def where(fit: FitRecord) -> str:
    """Return the ranges of airspeed, rotational speed and angle of the data."""
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
    """Return table rows by airspeed: number of rows, relative errors [%] by load, verdict."""
    loads, rows = judged(fit), []
    for band in dict.fromkeys(band for one in fit.loads for band in one.by_speed):
        pairs = [(one, one.load.by_speed.get(band)) for one in loads]
        cells = [
            " / ".join(html.number(100.0 * v / one.reference, 2) for v in (e.rms, e.hover_rms))
            if e
            else ""
            for one, e in pairs
        ]
        level = worst_of(
            level_of(e.rms / one.reference)
            for one, e in pairs
            if e and one.load.name not in MOMENTS
        )
        count = max(e.rows for _, e in pairs if e)
        rows.append((_shown_band(band), str(count), *cells, WORDS[level]))
    return rows


def whole_rows(fit: FitRecord) -> list[tuple[str, ...]]:
    """Return table rows by load: number of rows, and three errors, absolute and relative [%]."""
    rows = []
    for one in judged(fit):
        errors = (one.load.rms, one.load.cross_validated, one.load.hover_rms)
        cells = [
            (f"{html.number(e)} {one.load.unit}", html.number(100.0 * e / one.reference, 2))
            for e in errors
        ]
        if not math.isfinite(one.load.cross_validated):
            cells[1] = ("none", html.number(None))
        rows.append((one.label, str(one.load.rows), *itertools.chain(*cells)))
    return rows


def warnings(fit: FitRecord) -> list[str]:
    """Return sentences that limit the reliability of a fit."""
    found = []
    if fit.covered.speed[1] - fit.covered.speed[0] < NARROW:
        found.append("the data are from one airspeed: they hardly test the variation with airspeed")
    for one in judged(fit):
        found += useless(one.load.name, one.error)
        if not one.error < one.hover:
            found.append(f"{one.label}: the hover model is at least as accurate")
        ratio = one.load.cross_validated / one.load.rms if one.load.rms > 0.0 else math.nan
        if math.isfinite(ratio) and ratio > OVERFITTED:
            found.append(
                f"{one.label}: the error on left-out rows is {ratio:.1f} times as large, so some "
                "parameters follow the noise"
            )
    if fit.unsolved:
        found.append(f"the model has no solution for {fit.unsolved} of {fit.rows} rows")
    return found


def notes(fit: FitRecord) -> list[str]:
    """Return further remarks on a fit."""
    found = list(fit.remarks)
    if fit.minima > 1:
        found.append(
            f"{len(fit.starts)} starts converged to {fit.minima} minima; the fit uses the best one"
        )
    if not any(math.isfinite(one.cross_validated) for one in fit.loads):
        found.append("no cross-validation was done: all errors are on the fitted data")
    return found


def unfitted(fit: FitRecord) -> list[str]:
    """Return the labels of the loads that a fit of tunnel data did not use."""
    names = [one.name for one in fit.loads]
    return [load.label for name, load in LOADS.items() if name not in names]


# --- Range of the fitted data, and errors by airspeed --------------------------------------------


def coverage(fit: FitRecord) -> html.FigureRecord:
    """Return the operating points of the data: boxes over advance ratio and angle, with counts."""
    covered = fit.covered
    rest = [] if covered.at_rest is None else [("at rest", covered.at_rest)]
    named = [*rest, *((f"{one.typical_beta:.0f}°", one) for one in covered.angles)]

    def draw() -> Figure:
        figure = html.new_figure(8.6, 3.6)
        ax = figure.subplots()
        small: dict[str, Any] = {"textcoords": "offset points", "fontsize": 8.0}
        for one in covered.angles:
            left, right = one.advance
            # A group with a single angle would be an invisible box.
            low = min(one.beta[0], one.typical_beta - 1.5)
            high = max(one.beta[1], one.typical_beta + 1.5)
            ax.fill([left, right, right, left], [low, low, high, high], facecolor=html.COLORS[0],
                    alpha=0.35, edgecolor=html.COLORS[0], linewidth=1.2)  # fmt: skip
            ax.annotate(str(one.points), (right, 0.5 * (low + high)), (4, 0), va="center", **small)
        if covered.at_rest is not None:
            ax.plot(0.0, 0.0, marker="X", markersize=7.0, linestyle="none", clip_on=False,
                    color=html.COLORS[1])  # fmt: skip
            ax.annotate(f"at rest: {covered.at_rest.points}", (0.0, 0.0), (8, 5), **small)
        top = max((one.advance[1] for one in covered.angles), default=0.2)
        descent = max((one.beta[1] for one in covered.angles), default=90.0) > 95.0
        ax.set_xlim(0.0, 1.25 * top)
        ax.set_ylim(-8.0, 185.0 if descent else 98.0)
        ax.set_yticks(np.arange(0, 181 if descent else 91, 30))
        ax.set_xlabel("advance ratio V/(ΩR) [-]")
        ax.set_ylabel("angle β to the axis [deg]")
        ax.set_title("numbers: operating points per group", fontsize=9.0)
        return figure

    columns = html.columns_of(
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
            for name, one in named
        ],
    )
    ranges = [
        (
            name,
            str(one.points),
            *(
                f"{low:.{digits}f} to {high:.{digits}f}"
                for (low, high), digits in ((one.speed, 1), (one.rpm, 0), (one.advance, 3))
            ),
        )
        for name, one in named
    ]
    return html.FigureRecord("fit-coverage", columns, draw, ranges)


def angles_without_data(fit: FitRecord) -> str:
    """Return the angles far from all data, such as "30° to 60° and about 180°", or ""."""
    angles = [one.typical_beta for one in fit.covered.main_angles]
    far = [beta for beta in range(0, 181, STEP) if all(abs(beta - a) > GAP for a in angles)]
    spans = []
    for _, group in itertools.groupby(enumerate(far), lambda pair: pair[1] - STEP * pair[0]):
        _, run = zip(*group, strict=True)
        spans.append(f"{run[0]}° to {run[-1]}°" if len(run) > 1 else f"about {run[0]}°")
    return " and ".join(spans)


def band_errors(
    name: str, bands: Mapping[tuple[str, str], Mapping[str, ResidualErrors]]
) -> html.FigureRecord:
    """Return the errors by (load, unit) and airspeed range, with one panel per load."""
    groups: list[dict[str, Any]] = [
        {
            "load": load,
            "unit": unit,
            "speed_band": list(found),
            "rows": [e.rows for e in found.values()],
            "rms_in_unit": [e.rms for e in found.values()],
            "mean_in_unit": [e.bias for e in found.values()],
            "worst_in_unit": [e.worst for e in found.values()],
            "hover_rms_in_unit": [e.hover_rms for e in found.values()],
        }
        for (load, unit), found in bands.items()
    ]

    def draw() -> Figure:
        across = min(len(groups), 3)
        down = -(-len(groups) // across)
        figure = html.new_figure(8.6, 2.7 * down + 0.4)
        axes = figure.subplots(down, across, squeeze=False).ravel()
        for ax in axes[len(groups) :]:
            ax.axis("off")
        for ax, one in zip(axes, groups, strict=False):
            x = range(len(one["speed_band"]))
            ax.plot(x, one["hover_rms_in_unit"], marker="x", markersize=5.0, label="hover model",
                    **html.HOVER)  # fmt: skip
            ax.plot(x, one["rms_in_unit"], **html.marked(0), markersize=4.5, linewidth=1.6,
                    label="this model")  # fmt: skip
            short = [
                _shown_band(band.removesuffix(" m/s")).replace("above\N{NO-BREAK SPACE}", "> ")
                for band in one["speed_band"]
            ]
            ax.set_xticks(list(x), short)
            ax.tick_params(axis="x", labelsize=7.5)
            ax.set_ylim(bottom=0.0)
            ax.margins(x=0.08)
            ax.set_ylabel(f"{label_of(one['load'])}: rms error [{one['unit']}]")
            ax.set_xlabel("airspeed V [m/s]")
        html.legend_below(figure, axes[0].get_legend_handles_labels()[0][::-1])
        return figure

    cells = [
        (
            f"{label_of(load)} [{unit}]" if k == 0 else "",
            _shown_band(band),
            str(e.rows),
            *(html.number(v, 2) for v in (e.rms, e.hover_rms, e.bias, e.worst)),
        )
        for (load, unit), found in bands.items()
        for k, (band, e) in enumerate(found.items())
    ]
    return html.FigureRecord(name, groups, draw, cells)


# --- Fitted parameters: values, intervals, verdicts and correlations -----------------------------


def parameters(fit: FitRecord) -> html.FigureRecord:
    """Return value, interval, bounds and verdict of each parameter."""

    def draw() -> Figure:
        count = len(fit.parameters)
        figure = html.new_figure(8.6, 0.32 * count + 0.8)
        ax = figure.subplots()
        for k, p in enumerate(fit.parameters):
            width = p.upper - p.lower
            low, value, high = ((v - p.lower) / width for v in (p.low, p.value, p.high))
            face = html.COLORS[0] if p.identified else "white"
            ax.plot([0.0, 1.0], [k, k], color="0.85", linewidth=5.0, solid_capstyle="butt")
            ax.plot([low, high], [k, k], color=html.COLORS[0], linewidth=2.0)
            ax.plot(value, k, marker="o", color=html.COLORS[0], markerfacecolor=face, clip_on=False)
        ax.set_yticks(range(count), [p.name for p in fit.parameters])
        ax.set_ylim(count - 0.5, -0.5)
        ax.set_xticks([0.0, 1.0], ["lower bound", "upper bound"])
        ax.grid(visible=False)
        ax.tick_params(length=0.0)
        for side in ax.spines.values():
            side.set_visible(False)
        return figure

    columns = html.columns_of(
        "parameter unit value low_95 high_95 lower_bound upper_bound identified verdict",
        [
            (p.name, p.unit, p.value, p.low, p.high, p.lower, p.upper, int(p.identified), p.verdict)
            for p in fit.parameters
        ],
    )
    cells = [
        (
            p.name,
            EVERY[general(p.name)].meaning if general(p.name) in EVERY else "",
            html.number(p.value, 4),
            f"{html.number(p.low)} to {html.number(p.high)}",
            p.unit,
            "identified" if p.identified else "weak",
            p.verdict.removeprefix("weak").removeprefix("identified").lstrip(":;, "),
        )
        for p in fit.parameters
    ]
    return html.FigureRecord("fit-parameters", columns, draw, cells)


def correlations(fit: FitRecord) -> html.FigureRecord:
    """Return the correlations of the parameter errors as a table without figure."""
    names = [p.name for p in fit.parameters]
    rows = list(zip(names, fit.correlation.tolist(), strict=True))
    cells = [
        (name, *(html.number(round(v, 2) + 0.0 if math.isfinite(v) else None, 2) for v in row))
        for name, row in rows
    ]
    columns = html.columns_of(" ".join(("parameter", *names)), [(name, *row) for name, row in rows])
    return html.FigureRecord("fit-correlations", columns, cells=cells)


def strong_pairs(fit: FitRecord) -> list[str]:
    """Return the pairs of parameters with a strong correlation, such as "c_l1 and alpha_0"."""
    pairs = itertools.combinations(enumerate(p.name for p in fit.parameters), 2)
    return [f"{a} and {b}" for (i, a), (j, b) in pairs if abs(fit.correlation[i, j]) >= STRONG]


# --- Residuals of a model against all variables on which they may depend -------------------------


def binned(trend: Trend) -> dict[str, Floats]:
    """Return the columns (bins,) of a ``trend``.

    For the error of a mean, the residuals of one time block count as one sample.
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
    heads = "bin_from bin_to bin_middle mean_in_unit mean_error_in_unit low_10_in_unit"
    heads += " high_90_in_unit samples"
    return dict(zip(heads.split(), np.array(rows).T, strict=True))


def residuals(name: str, trends: Sequence[Trend]) -> html.FigureRecord:
    """Return the binned residuals of a load against all candidates, strongest first."""
    load, unit = trends[0].load, trends[0].unit
    groups: list[dict[str, Any]] = []
    for trend in trends:
        variable, _, variable_unit = trend.variable.rstrip("]").partition(" [")
        groups.append(
            {
                "load": load,
                "unit": unit,
                "variable": variable,
                "variable_unit": variable_unit,
                "share_of_variance": trend.share,
                "slope": trend.slope,
                "slope_error": trend.error,
                **binned(trend),
            }
        )

    def draw() -> Figure:
        rows = -(-len(trends) // PANELS)
        figure = html.new_figure(11.5, 2.25 * rows + 0.7)
        axes = figure.subplots(rows, PANELS, squeeze=False, sharey=True)
        for ax in axes.ravel()[len(trends) :]:
            ax.axis("off")
        for ax, trend, one in zip(axes.ravel(), trends, groups, strict=False):
            color, x = html.COLORS[int(trend.sure)], one["bin_middle"]
            ax.axhline(0.0, color="0.5", linewidth=0.8)
            ax.fill_between(
                x, one["low_10_in_unit"], one["high_90_in_unit"], color=color, **html.BAND
            )
            ax.errorbar(
                x, one["mean_in_unit"], 2.0 * one["mean_error_in_unit"], color=color, marker="o",
                markersize=3.5, linewidth=1.3, elinewidth=1.0, capsize=2.0,
            )  # fmt: skip
            label = trend.variable.replace("^2", "²")
            ax.set_xlabel(label.replace(" [", "\n[") if len(label) > 24 else label, fontsize=7.5)
            ax.tick_params(labelsize=7.5)
            share = f"{100.0 * trend.share:.0f} % of the variance"
            ax.set_title(share, fontsize=8.0, fontweight="bold" if trend.sure else "normal")
        for ax in axes[:, 0]:
            ax.set_ylabel(f"error [{unit}]")
        look: dict[str, Any] = {"marker": "o", "markersize": 4.0, "linewidth": 1.3}
        html.legend_below(
            figure,
            [
                html.key("significant dependence", color=html.COLORS[1], **look),
                html.key("weak or not significant", color=html.COLORS[0], **look),
                html.key("mean and two standard errors, by segments of 1 s", color="0.3", **look),
                html.key("central 80 % of the samples", color="0.7", linewidth=6.0),
            ],
            fontsize=8.5,
        )
        figure.suptitle(f"{label_of(load)}: model minus measurement")
        return figure

    return html.FigureRecord(name, groups, draw)


def sentences(loads: Sequence[Sequence[Trend]]) -> list[str]:
    """Return sentences on all significant dependences of the residuals, strongest first."""
    telling = [trend for trend in itertools.chain(*loads) if trend.sure]
    return [trend.sentence for trend in sorted(telling, key=lambda trend: -trend.share)]
