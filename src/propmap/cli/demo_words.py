"""What ``propmap demo`` says: tables, and what is off and why, in this run's figures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from propmap.cli.demo_results import FITTED, SECTIONS, Group, Results
from propmap.cli.output import grid
from propmap.loads import LOADS
from propmap.model.corrections import MODELS, in_words
from propmap.report.comparison import HOVER

if TYPE_CHECKING:
    from propmap.report.comparison import ErrorFigures

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
