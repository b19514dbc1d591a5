"""What ``propmap demo`` computes, writes and says: tables, and what is off and why."""

from __future__ import annotations

import os
import timeit
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import propmap
from propmap.catalogue.lookup import Measurement, measurement, propeller
from propmap.cli.output import grid, json_text, write_text
from propmap.io.csv import csv_text
from propmap.loads import LOADS
from propmap.model.airfoil import parameter_set
from propmap.model.corrections import MODELS, corrections_of, in_words
from propmap.model.model import Model
from propmap.report.comparison import HOVER, Comparison, LoadErrors, compare
from propmap.rotor import Rotor
from propmap.typing import Floats
from propmap.units import RPM

if TYPE_CHECKING:
    from propmap.report.comparison import ErrorFigures


# -------------------------------------------------------------------------------------------------
# What ``propmap demo`` computes and writes.

PROPELLER = "apc-8x6e"
SECTIONS = {"recommended": "apc-8x6e-2019", "paper": "paper-apc"}
"""Constants by the name of the model: identified on the oblique data, and as the paper has them."""

TUNNEL, OBLIQUE, OTHER_FORM = "uiuc-8x6e", "gill-dandrea-2019-8x6e", "gill-dandrea-2019-8x6e-fit"
"""Axial and static rows; the polynomials of the oblique campaign; its blade-element model."""

FITTED = ("thrust", "torque")
"""Loads of the polynomials to which the identified constants were fitted."""

CURVES = np.radians([0.0, 30.0, 60.0, 90.0])
DISK = (4000.0 * RPM, 14.0, np.radians(80.0))
"""An operating point with stall and reverse flow to be seen: [rad/s], [m/s], [rad]."""

REPEATS = 3

COPIES = 10
"""A batch fills blocks of equal size, so few points cost more each than many."""


@dataclass(frozen=True)
class Group:
    """Errors over some points of a data set; beta_deg where they share one."""

    title: str
    data_set: str
    beta_deg: float | None
    errors: list[LoadErrors]

    def of(self, load: str) -> LoadErrors:
        """The errors in one load."""
        (found,) = (one for one in self.errors if one.load == load)
        return found


@dataclass(frozen=True)
class Timing:
    """Best of three calls with so many points at once, after a first one."""

    points: int
    seconds_per_point: float


@dataclass(frozen=True)
class Foretold:
    """A load of the rotor by name against the oblique data.

    Attributes
    ----------
    load : str
        Its name.
    relative_rms : float
        Root mean square of the errors over that of what was measured [-].
    inside : float
        Share of the points inside the band of 95 %, where the load is not zero by symmetry [-].
    apart : float
        Mean of measured less computed, in standard deviations [-].
    """

    load: str
    relative_rms: float
    inside: float
    apart: float


@dataclass(frozen=True, eq=False)
class Results:
    """What was found.

    Attributes
    ----------
    rotor : Rotor
        That of the recommended model.
    by_name : Rotor
        What is known of the propeller by its name: constants from another tunnel's axial loads.
    foretold : Foretold
        How that compares with the oblique data.
    tunnel, oblique : Comparison
        At every point of both data sets.
    groups, by_angle : list of Group
        Errors by data set, and of the oblique one by angle.
    timings : list of Timing
        Of these points at once and of ten times as many.
    cores : int
        Of this machine.
    """

    rotor: Rotor
    by_name: Rotor
    foretold: list[Foretold]
    tunnel: Comparison
    oblique: Comparison
    groups: list[Group]
    by_angle: list[Group]
    timings: list[Timing]
    cores: int


def compute() -> Results:
    """Compare, and time the whole batch."""
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
    by_name = Rotor(propmap.known_model(PROPELLER, air=propmap.Air(slanted.air_density)))
    return Results(
        rotors["recommended"],
        by_name,
        foretold(by_name, slanted),
        tunnel,
        oblique,
        groups,
        by_angle,
        timings,
        os.cpu_count() or 1,
    )


def foretold(rotor: Rotor, data: Measurement) -> list[Foretold]:
    """Every measured load against that of the ``rotor``, with its band."""
    loads = rotor.loads(data.omega, data.speed, data.beta)
    low, high = loads.interval(0.95)
    found = []
    for name, measured in data.loads.items():
        error = getattr(loads, name) - measured
        inside = (getattr(low, name) <= measured) & (measured <= getattr(high, name))
        there = getattr(loads.std, name) > 0.0
        relative = np.sqrt(np.mean(error**2) / np.mean(measured**2))
        apart = (-error[there] / getattr(loads.std, name)[there]).mean()
        shares = (float(value) for value in (relative, inside[there].mean(), apart))
        found.append(Foretold(name, *shares))
    return found


def write_tables(results: Results, folder: Path, notes: list[str]) -> None:
    """``demo.csv``, every point, and ``demo.json``, the errors and the ``notes`` on them."""
    rows = [row for one in (results.tunnel, results.oblique) for row in _rows(one)]
    write_text(csv_text(list(rows[0]), rows), folder / "demo.csv")
    groups = [asdict(group) for group in (*results.groups, *results.by_angle)]
    found = {
        "propmap_version": propmap.__version__,
        "propeller": results.rotor.model.propeller.name,
        "models": {
            name: {"airfoil": section, "corrections": list(MODELS[name])}
            for name, section in SECTIONS.items()
        },
        "fitted_loads": list(FITTED),
        "air_density_kg_m3": results.rotor.model.air.density,
        "accuracy": results.rotor.accuracy,
        "relative_rms": "rms of the error over the rms of the measured load",
        "band": f"rms of {OTHER_FORM} less {OBLIQUE} over the rms of the latter",
        "groups": groups,
        "by_name": [asdict(one) for one in results.foretold],
        "notes": notes,
        "timings": [asdict(timing) for timing in results.timings],
        "cores": results.cores,
    }
    write_text(json_text(found), folder / "demo.json")


def write_pictures(results: Results, folder: Path) -> tuple[Path, Path]:
    """Load curves at the rotational speed with most oblique points, and a disk; the paths.

    The curves are of the constants that were identified on these data, the bands those of what is
    known of the propeller by its name.
    """
    from propmap.report.html import save
    from propmap.report.pictures import MeasuredLoads, disk_picture, load_curves

    oblique = results.oblique
    data = oblique.measurement
    speeds, counts = np.unique(data.omega, return_counts=True)
    omega = float(speeds[np.argmax(counts)])
    mine = data.omega == omega
    points = MeasuredLoads(
        "polynomials, Gill & D'Andrea 2019",
        data.speed[mine],
        data.beta[mine],
        {load: values[mine] for load, values in oblique.measured.items()},
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
        band=results.by_name,
        band_label="95 % band by name",
    )
    save(figure, curves)
    save(disk_picture(results.rotor, *DISK), disk)
    return curves, disk


def _rotors(data: Measurement) -> dict[str, Rotor]:
    """The rotor by the name of the model, in the air of the ``data``."""
    blade, air = propeller(PROPELLER), propmap.Air(density=data.air_density)
    return {
        name: Rotor(Model(blade, parameter_set(section), air, corrections_of(name)))
        for name, section in SECTIONS.items()
    }


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
        columns[f"measured_{load.column}"] = both.measured.get(name, none)
        columns[f"other_form_{load.column}"] = both.other.get(name, none)
        for model, predicted in both.models.items():
            columns[f"{model}_{load.column}"] = predicted[name]
    columns["status"] = both.status
    listed = [values.tolist() for values in columns.values()]
    return [dict(zip(columns, row, strict=True)) for row in zip(*listed, strict=True)]


# -------------------------------------------------------------------------------------------------
# What ``propmap demo`` says: tables, and what is off and why, in this run's figures.

MODELS_SHOWN = (*SECTIONS, HOVER)


def told(results: Results) -> Iterator[object]:
    """Texts and tables on the results."""
    yield (
        f"{results.rotor.model.propeller.name} against UIUC (static, axial) and the polynomials of "
        "Gill & D'Andrea 2019 (oblique)"
    )
    for name, section in SECTIONS.items():
        yield f"{name}: {in_words(MODELS[name])}, with the constants {section}"
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
        caption="rms error and, in brackets, in % of the rms of the measured load; band: the 2019 "
        "paper's own blade-element model less its polynomials, likewise; hover: constants from the "
        "recommended rotor at V = 0",
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
    yield f"{times}, on this machine ({results.cores} cores), after the first call"


def notes(results: Results) -> list[str]:
    """What is off, and why."""
    oblique = results.groups[-1]

    def share(load: str) -> str:
        return f"{_percent(oblique.of(load).models['recommended'].relative_rms)} %"

    def band(load: str) -> str:
        return f"{_percent(oblique.of(load).band)} %"

    by_name = {one.load: one for one in results.foretold}
    drag, pitch = (_sizes(results.by_angle, load) for load in ("drag", "pitch_moment"))
    first, *_, last = pitch
    *elsewhere, _ = results.groups
    return [
        "The oblique data are no raw points. The 2019 paper gives polynomials, one fitted to each "
        "load's measurements, which are taken as measured here, and a blade-element model fitted "
        f"to all loads. The two differ by {band('thrust')} rms in thrust, {band('torque')} in "
        f"torque, {band('drag')} in rotor drag and {band('roll_moment')} in rolling moment, the "
        "band: no model can be called closer than that.",
        f"The constants {SECTIONS['recommended']} were fitted to {' and '.join(FITTED)} of the "
        f"polynomials, {share('thrust')} and {share('torque')}. Rolling moment "
        f"({share('roll_moment')}), pitching moment and rotor drag were not fitted, nor was UIUC's "
        "tunnel, where the same propeller's loads differ already at rest: "
        f"{_bias(elsewhere, 'recommended', 'thrust')} in mean thrust, "
        f"{_bias(elsewhere, 'recommended', 'torque')} in mean torque.",
        "The bands of the picture are what is known of the propeller by its name alone, with "
        "constants identified from UIUC's axial loads: they should hold 95 %. Of the oblique "
        "points, "
        + ", ".join(
            f"{one.inside:.0%} are inside in {LOADS[name].label} (rms {one.relative_rms:.0%})"
            for name, one in by_name.items()
        )
        + ". All points of a tunnel err together; bands of rotor drag are those of the blades.",
        f"Pitching moment: of their sign, {pitch[first]:.1f} times theirs at {first:g} degrees and "
        f"{pitch[last]:.1f} times at {last:g}. Theirs is linear in the advance ratio. The paper's "
        "model has none.",
        f"Rotor drag: theirs is {1.0 / max(drag.values()):.1f} to {1.0 / min(drag.values()):.1f} "
        "times this theory's, by angle. Other sources have the theory right within about 20 % for "
        "bare blades; the excess looks like a plate in the slipstream (stand, motor, hub), though "
        "this propeller alone does not tell a plate from a factor: see propmap reproduce. Nothing "
        "is tuned here.",
        "The paper's section law has no camber (zero-lift angle 0), the blade has: with "
        f"{SECTIONS['paper']} mean thrust is off by {_bias(results.groups, 'paper', 'thrust')}, "
        f"mean torque by {_bias(results.groups, 'paper', 'torque')}.",
    ]


def _bias(groups: Sequence[Group], model: str, load: str) -> str:
    """Mean error of a model over the mean measured load, in words, by data set."""
    found = []
    for group in groups:
        one = group.of(load)
        found.append(f"{one.models[model].mean / one.measured_mean:+.0%} {group.title}")
    return ", ".join(found)


def _sizes(groups: Sequence[Group], load: str) -> dict[float, float]:
    """The recommended model's load over the measured one [-], rms over rms, by angle [deg]; those
    at which none was measured are left out."""
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
