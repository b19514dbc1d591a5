"""Compare the recommended, the paper's and the hover model with measurements of an APC 8x6E.

Usage: python examples/demo.py [-o FOLDER]

The measurements are included in propmap.  The demo writes all points and errors as CSV and JSON,
and two pictures, to FOLDER (default: propmap-demo).  `make demo` runs it.
"""

from __future__ import annotations

import argparse
import os
import timeit
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import propmap
from propmap.catalogue.lookup import Measurement, measurement, propeller
from propmap.cli.demo import TUNNELS
from propmap.cli.output import grid, json_text, show, write_text
from propmap.fit.least_squares import errors, rms
from propmap.fit.tunnel import TunnelData
from propmap.hover import HoverModel
from propmap.io.csv import csv_text
from propmap.loads import LOADS
from propmap.model.airfoil import parameter_set
from propmap.model.corrections import TYPICAL_FACTOR, as_text, in_words, model_corrections
from propmap.model.model import Model
from propmap.report.html import save
from propmap.report.pictures import disk_picture, load_curves
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import RPM

PROPELLER = "apc-8x6e"
SECTIONS = {"recommended": "apc-8x6e-2019", "paper": "paper-apc"}
"""Section constants by model: identified on the oblique data, and those of the paper."""

TUNNEL, OBLIQUE, OTHER_FORM = "uiuc-8x6e", "gill-dandrea-2019-8x6e", "gill-dandrea-2019-8x6e-fit"
"""Axial and static data; the polynomials of the oblique campaign; its blade-element model."""

FITTED = ("thrust", "torque")
"""Loads of the polynomials to which the identified constants were fitted."""

CURVES = np.radians([0.0, 30.0, 60.0, 90.0])
DISK = (4000.0 * RPM, 14.0, np.radians(80.0))
"""Operating point of the disk picture, with stall and reverse flow: [rad/s], [m/s], [rad]."""

HOVER = "hover"
MODELS_SHOWN = (*SECTIONS, HOVER)

REPEATS = 3  # repetitions of each timing, of which the best is reported
COPIES = 10  # factor of the larger batch: small batches fill blocks only partly and cost more


# --- Errors, predicted minus measured, and the uncertainty of the data ---------------------------


@dataclass(frozen=True)
class ErrorFigures:
    """Errors of one model in one load, in the load's unit."""

    rms: float
    relative_rms: float | None  # over the rms of the measured load [-]; None if this is zero
    worst: float  # largest magnitude
    mean: float
    predicted_rms: float  # rms of the predicted load


@dataclass(frozen=True)
class LoadErrors:
    """Errors in one load over a group of points."""

    load: str
    unit: str
    points: int
    measured_rms: float
    measured_mean: float
    models: dict[str, ErrorFigures]  # by model name
    band: float | None
    """Rms difference between both forms of the data, over the rms of the measured load [-]; None
    with one form only, or with zeros only."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Measured and predicted loads at n points, all (n,)."""

    measurement: Measurement
    models: dict[str, dict[str, Floats]]  # by model name, then by load
    status: NDArray[np.str_]  # status of the first model's loads
    other: Mapping[str, Floats]  # loads of another evaluation of the measurements; empty for none

    def errors(self, chosen: NDArray[np.bool_]) -> list[LoadErrors]:
        """Return the errors of each measured load over the ``chosen`` points (n,)."""
        return [self._errors(load, chosen) for load in self.measurement.loads]

    def _errors(self, load: str, chosen: NDArray[np.bool_]) -> LoadErrors:
        truth = self.measurement.loads[load][chosen]

        def figures(values: Floats) -> ErrorFigures:
            e = errors(values[chosen], truth)
            relative = e.relative_rms if truth.any() else None
            return ErrorFigures(e.rms, relative, abs(e.worst), e.bias, rms(values[chosen]))

        return LoadErrors(
            load=load,
            unit=LOADS[load].unit,
            points=truth.size,
            measured_rms=rms(truth),
            measured_mean=float(truth.mean()),
            models={name: figures(loads[load]) for name, loads in self.models.items()},
            band=figures(self.other[load]).relative_rms if load in self.other else None,
        )


def compare(
    rotors: Mapping[str, Rotor], data: Measurement, other: Measurement | None = None
) -> Comparison:
    """Evaluate rotors and the hover model at measured points.

    The constants of the hover model come from the first rotor.  ``other`` is another evaluation of
    the same measurements, at the same operating points.
    """
    found: dict[str, Any] = {
        name: rotor.loads(data.omega, data.speed, data.beta) for name, rotor in rotors.items()
    }
    models = {name: {load: getattr(loads, load) for load in LOADS} for name, loads in found.items()}
    first = next(iter(rotors))
    models[HOVER] = HoverModel.from_rotor(rotors[first]).loads(data.omega)
    return Comparison(data, models, found[first].status, {} if other is None else other.loads)


# --- Computation and output files ----------------------------------------------------------------


@dataclass(frozen=True)
class Group:
    """Errors over a group of points of a data set; ``beta_deg`` if they share one angle."""

    title: str
    data_set: str
    beta_deg: float | None
    errors: list[LoadErrors]

    def of(self, load: str) -> LoadErrors:
        """Return the errors in one load."""
        (found,) = (one for one in self.errors if one.load == load)
        return found


@dataclass(frozen=True)
class Timing:
    """Best time of several calls with ``points`` at once, after a first call."""

    points: int
    seconds_per_point: float


@dataclass(frozen=True)
class ByName:
    """A load of the catalogue prediction compared with the oblique data."""

    load: str
    relative_rms: float  # rms error over the rms of the measured load [-]
    inside: float  # fraction of points in the 95 % band, without zeros by symmetry [-]
    z_score: float  # mean of measured minus predicted, in standard deviations [-]


class Results(NamedTuple):
    """Results of the demo."""

    rotor: Rotor  # recommended model
    known: Rotor  # catalogue prediction: constants from axial loads of another tunnel
    by_name: list[ByName]  # catalogue prediction compared with the oblique data
    tunnel: Comparison  # at every point
    oblique: Comparison
    groups: list[Group]  # errors by data set
    by_angle: list[Group]  # errors on the oblique data by angle
    timings: list[Timing]  # with all points at once, and with ten times as many


def compute() -> Results:
    """Compare the models with both data sets, and time the computation of all points."""
    data, slanted, other = (measurement(name) for name in (TUNNEL, OBLIQUE, OTHER_FORM))
    rotors = _rotors(slanted)
    tunnel, oblique = compare(_rotors(data), data), compare(rotors, slanted, other)
    still = data.speed == 0.0
    groups = [
        Group("static", TUNNEL, None, tunnel.errors(still)),
        Group("axial", TUNNEL, 0.0, tunnel.errors(~still)),
        Group("oblique", OBLIQUE, None, oblique.errors(np.full(slanted.speed.shape, True))),
    ]
    degrees = np.round(np.degrees(slanted.beta), 1)
    by_angle = [
        Group(f"oblique {beta:g}", OBLIQUE, float(beta), oblique.errors(degrees == beta))
        for beta in np.unique(degrees)
    ]
    fields = ("omega", "speed", "beta")
    flow = [np.concatenate([getattr(data, f), getattr(slanted, f)]) for f in fields]
    timings = [_timing(rotors["recommended"], flow, copies) for copies in (1, COPIES)]
    known = Rotor(propmap.catalogue_model(PROPELLER, air=propmap.Air(slanted.air_density)))
    return Results(
        rotors["recommended"],
        known,
        by_name(known, slanted),
        tunnel,
        oblique,
        groups,
        by_angle,
        timings,
    )


def by_name(rotor: Rotor, data: Measurement) -> list[ByName]:
    """Compare every measured load with the prediction of the ``rotor`` and its 95 % band."""
    loads = rotor.loads(data.omega, data.speed, data.beta)
    low, high = loads.interval(0.95)
    found = []
    for name, measured in data.loads.items():
        error, deviation = getattr(loads, name) - measured, getattr(loads.std, name)
        inside = (getattr(low, name) <= measured) & (measured <= getattr(high, name))
        there = deviation > 0.0
        relative = np.sqrt(np.mean(error**2) / np.mean(measured**2))
        z_score = (-error[there] / deviation[there]).mean()
        shares = (float(value) for value in (relative, inside[there].mean(), z_score))
        found.append(ByName(name, *shares))
    return found


def write_tables(results: Results, folder: Path, notes: list[str]) -> None:
    """Write all points to ``demo.csv``, and errors and ``notes`` to ``demo.json``."""
    rows = [row for one in (results.tunnel, results.oblique) for row in _rows(one)]
    write_text(csv_text(list(rows[0]), rows), folder / "demo.csv")
    groups = [asdict(group) for group in (*results.groups, *results.by_angle)]
    found = {
        "propmap_version": propmap.__version__,
        "propeller": results.rotor.model.propeller.name,
        "models": {
            name: {"airfoil": section, "corrections": _corrections(name)}
            for name, section in SECTIONS.items()
        },
        "fitted_loads": list(FITTED),
        "air_density_kg_m3": results.rotor.model.air.density,
        "accuracy": results.rotor.accuracy,
        "relative_rms": "rms of the error over the rms of the measured load",
        "band": f"rms of {OTHER_FORM} minus {OBLIQUE} over the rms of {OBLIQUE}",
        "groups": groups,
        "by_name": [asdict(one) for one in results.by_name],
        "notes": notes,
        "timings": [asdict(timing) for timing in results.timings],
        "cores": os.cpu_count() or 1,
    }
    write_text(json_text(found), folder / "demo.json")


def write_pictures(results: Results, folder: Path) -> tuple[Path, Path]:
    """Draw loads at the rotational speed with most oblique points, and a disk; return the paths.

    The curves use the constants identified on these data.  The bands are those of the catalogue
    prediction.
    """
    oblique = results.oblique
    data = oblique.measurement
    speeds, counts = np.unique(data.omega, return_counts=True)
    omega = float(speeds[np.argmax(counts)])
    mine = data.omega == omega
    points = TunnelData(
        "polynomials, Gill & D'Andrea 2019",
        data.omega[mine],
        data.speed[mine],
        data.beta[mine],
        {load: values[mine] for load, values in data.loads.items()},
    )
    curves, disk = folder / "demo-loads.png", folder / "demo-disk.png"
    fastest = float(data.speed[mine].max())
    speed = np.linspace(0.0, fastest, 61)
    figure = load_curves(
        results.rotor,
        omega,
        speed,
        CURVES.tolist(),
        points,
        band=results.known,
        band_label="95 % band (catalogue)",
    )
    save(figure, curves)
    save(disk_picture(results.rotor, *DISK), disk)
    return curves, disk


def _rotors(data: Measurement) -> dict[str, Rotor]:
    """Return the rotor of each model by model name, in the air of the ``data``."""
    blade, air = propeller(PROPELLER), propmap.Air(density=data.air_density)
    return {
        name: Rotor(
            Model(blade, parameter_set(section), air, model_corrections(name, installed=True))
        )
        for name, section in SECTIONS.items()
    }


def _corrections(model: str) -> list[str]:
    """List the corrections of a model to the paper's model; the recommended rotor is installed."""
    return [as_text(one) for one in model_corrections(model, installed=True)]


def _timing(rotor: Rotor, flow: list[Floats], copies: int) -> Timing:
    batch = [np.tile(values, copies) for values in flow]
    rotor.loads(*batch)
    seconds = min(timeit.repeat(lambda: rotor.loads(*batch), number=1, repeat=REPEATS))
    return Timing(batch[0].size, seconds / batch[0].size)


def _rows(both: Comparison) -> list[dict[str, Any]]:
    data = both.measurement
    none = np.full(data.omega.size, None)
    columns: dict[str, Any] = {
        "data_set": np.full(data.omega.size, data.name),
        "rpm": data.omega / RPM,
        "speed_mps": data.speed,
        "beta_deg": np.degrees(data.beta),
    }
    for name, load in LOADS.items():
        columns[f"measured_{load.column}"] = data.loads.get(name, none)
        columns[f"other_form_{load.column}"] = both.other.get(name, none)
        for model, predicted in both.models.items():
            columns[f"{model}_{load.column}"] = predicted[name]
    columns["status"] = both.status
    listed = [values.tolist() for values in columns.values()]
    return [dict(zip(columns, row, strict=True)) for row in zip(*listed, strict=True)]


# -------------------------------------------------------------------------------------------------
# Printed output: tables, and notes on the errors and their causes with the numbers of this run.


def parts(results: Results) -> Iterator[object]:
    """Yield texts and tables of the results."""
    yield (
        f"{results.rotor.model.propeller.name} against UIUC (static, axial) and the polynomials of "
        "Gill & D'Andrea 2019 (oblique)"
    )
    for name, section in SECTIONS.items():
        yield f"{name}: {in_words(_corrections(name))}, with the constants {section}"
    rows = [
        (
            group.title if i == 0 else "",
            one.load.replace("_", " "),
            str(one.points),
            f"{one.measured_rms:.3g} {one.unit}",
            _percent(one.band),
            *(_figures(one.models[name]) for name in MODELS_SHOWN),
        )
        for group in results.groups
        for i, one in enumerate(group.errors)
    ]
    yield grid(
        "|".join(["<data set", "<load", "points", "measured rms", "band [%]", *MODELS_SHOWN]),
        rows,
        caption="rms error and, in brackets, in % of the rms of the measured load; band: rms "
        "difference of the 2019 paper's blade-element model and its polynomials, in the same %; "
        "hover: constants from the recommended rotor at V = 0",
    )
    loads = [one.load.replace("_", " ") for one in results.by_angle[0].errors]
    rows_by_angle = [
        (
            f"{group.beta_deg:g}",
            *(
                " / ".join(_percent(one.models[name].relative_rms) for name in MODELS_SHOWN)
                for one in group.errors
            ),
            str(group.errors[0].points),
        )
        for group in results.by_angle
    ]
    yield grid(
        "|".join(["beta [deg]", *loads, "points"]),
        rows_by_angle,
        "oblique, by angle: rms error over the rms of the measured load [%], recommended / paper / "
        "hover model",
    )
    yield from (f"- {line}" for line in notes(results))
    times = " and ".join(
        f"{1e6 * timing.seconds_per_point:.0f} microseconds per point with {timing.points} at once"
        for timing in results.timings
    )
    yield f"{times}, on this machine ({os.cpu_count() or 1} cores), after the first call"
    yield grid(
        "<load|rms error [%]|in the 95 % band [%]",
        [
            (LOADS[one.load].label, _percent(one.relative_rms), _percent(one.inside))
            for one in results.by_name
        ],
        "oblique, catalogue prediction: the installed rotor with constants from UIUC's axial loads",
    )


def notes(results: Results) -> list[str]:
    """Return notes on the errors and their causes."""
    oblique = results.groups[-1]

    def share(load: str) -> str:
        return f"{_percent(oblique.of(load).models['recommended'].relative_rms)} %"

    def band(load: str) -> str:
        return f"{_percent(oblique.of(load).band)} %"

    drag, pitch = (_sizes(results.by_angle, load) for load in ("drag", "pitch_moment"))
    first, *_, last = pitch
    *elsewhere, _ = results.groups
    return [
        "Oblique data: the 2019 paper does not publish the measured points. It publishes one "
        "polynomial per load, which counts as measured here, and a blade-element model fitted to "
        f"all loads. The rms difference between both, the band, is {band('thrust')} in thrust, "
        f"{band('torque')} in torque, {band('drag')} in rotor drag and {band('roll_moment')} in "
        "rolling moment. Errors below the band do not distinguish models.",
        f"Fitted loads: the constants {SECTIONS['recommended']} were fitted to "
        f"{' and '.join(FITTED)} of the polynomials, with errors of {share('thrust')} and "
        f"{share('torque')}. Not fitted were rolling moment ({share('roll_moment')}), pitching "
        "moment, rotor drag, and UIUC's data. In UIUC's tunnel the loads of the same propeller "
        f"differ even at rest: {_bias(elsewhere, 'recommended', 'thrust')} in mean thrust, "
        f"{_bias(elsewhere, 'recommended', 'torque')} in mean torque.",
        "Bands of the picture: 95 % bands of the catalogue prediction, with constants identified "
        "from UIUC's axial loads. Fractions of the oblique points inside: "
        + ", ".join(
            f"{one.inside:.0%} for {LOADS[one.load].label} (rms error {one.relative_rms:.0%})"
            for one in results.by_name
        )
        + f". {TUNNELS}",
        "Pitching moment: the recommended model predicts the measured sign. The magnitude is "
        f"{pitch[first]:.1f} times the measured one at {first:g} degrees and {pitch[last]:.1f} "
        f"times at {last:g} degrees. The measured moment is linear in the advance ratio. The "
        "paper's model has no pitching moment.",
        f"Rotor drag: the measured drag is {1.0 / max(drag.values()):.1f} to "
        f"{1.0 / min(drag.values()):.1f} times the prediction, depending on the angle. The "
        "recommended rotor is installed, as measured on motors and stands: "
        f"{TYPICAL_FACTOR[0]:g} times the drag of the blades, and a plate in the slipstream. In "
        "other sources the theory agrees with bare blades within about 20 %. The paper's model "
        "has bare blades.",
        "Camber: the paper's section law has none (zero-lift angle 0), but the blade has. With "
        f"{SECTIONS['paper']} the error of mean thrust is "
        f"{_bias(results.groups, 'paper', 'thrust')}, of mean torque "
        f"{_bias(results.groups, 'paper', 'torque')}.",
    ]


def _bias(groups: Sequence[Group], model: str, load: str) -> str:
    """Return the mean error of a model over the mean measured load, by data set, as text."""
    found = []
    for group in groups:
        one = group.of(load)
        found.append(f"{one.models[model].mean / one.measured_mean:+.0%} {group.title}")
    return ", ".join(found)


def _sizes(groups: Sequence[Group], load: str) -> dict[float, float]:
    """Return the rms load of the recommended model over the measured rms, by angle [deg].

    Angles without a measured load are omitted.
    """
    found = {}
    for group in groups:
        one = group.of(load)
        if group.beta_deg is not None and one.measured_rms:
            found[group.beta_deg] = one.models["recommended"].predicted_rms / one.measured_rms
    return found


def _figures(errors: ErrorFigures) -> str:
    return f"{errors.rms:.2g} ({_percent(errors.relative_rms)})"


def _percent(share: float | None) -> str:
    return "-" if share is None else f"{100.0 * share:.1f}"


def main() -> None:
    """Compute the results, write the files and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "-o", "--output", type=Path, default="propmap-demo", metavar="FOLDER",
        help="output folder (default: propmap-demo)",
    )  # fmt: skip
    folder = parser.parse_args().output
    if folder.exists() and not folder.is_dir():
        parser.error(f"{folder}: this is a file; give the name of a folder")
    folder.mkdir(parents=True, exist_ok=True)
    results = compute()
    write_tables(results, folder, notes(results))
    curves, disk = write_pictures(results, folder)
    show(None, *parts(results))
    for path in (folder / "demo.csv", folder / "demo.json", disk, curves):
        print(path)


if __name__ == "__main__":
    main()
