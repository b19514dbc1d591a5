"""``propmap fit``: what all fits share, and those to tunnels and thrust stands."""

from __future__ import annotations

import difflib
import functools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
import typer
from typer import Argument, Option, echo

from propmap.catalogue.expected import airfoil_at, expected_prior, siblings, size_of
from propmap.catalogue.identified import PARAMETERS, all_identified
from propmap.catalogue.lookup import geometry_of, meant_by, own_constants
from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.cli.app import LazyGroup
from propmap.errors import InputError, quoted
from propmap.fit import comparison, tunnel
from propmap.fit.files import fit_text
from propmap.fit.fit import Fitted, Settings, coverage, fit, range_warnings
from propmap.fit.least_squares import FlightErrors, Rows, errors
from propmap.fit.parameters import EVERY, SECTION, Choice, Prior, SectionPrior, described, known
from propmap.model import plausibility
from propmap.model.air import Air
from propmap.model.airfoil import Airfoil
from propmap.model.corrections import in_words
from propmap.model.envelope import Envelope
from propmap.model.model import Model
from propmap.model.propeller import Propeller
from propmap.units import RPM


class FitCommands(LazyGroup):
    """What can be fitted, in the order in which help lists it."""

    places: ClassVar = {
        "tunnel": "fit.fit_tunnel",
        "flight": "fit_flight.fit_flight",
        "static": "fit.fit_static",
        "terms": "fit_flight.fit_terms_page",
    }


fit_app = typer.Typer(
    name="fit",
    cls=FitCommands,
    help="Identify section constants from measurements.",
    rich_markup_mode=None,
)


# -------------------------------------------------------------------------------------------------
# Options that all fits share, and what they mean.

PriorFrom = Annotated[
    str | None,
    Option(
        "--prior-from",
        metavar="family|population|none|CODE",
        help="Propellers whose constants are the prior: family, those of its family, or all where "
        "that is not known; population, all; CODE, those of this family, as apcsf; none. By "
        "default family, and none where --free or --airfoil says what to fit.",
    ),
]
WRITTEN = out.output_option("Write the fit to this file.", "FIT.toml")
Output = Annotated[Path, WRITTEN]
Accept = Annotated[
    bool, Option("--accept", help="Write the fit however much of the loads it leaves unexplained.")
]


@dataclass(frozen=True)
class FitChoice:
    """What is free in a fit, what is known of it, and how it is done; its fields are options."""

    free: Annotated[
        str | None, Option("--free", metavar="NAMES", help="Free parameters, separated by commas.")
    ] = None
    fix: Annotated[
        list[str] | None,
        Option("--fix", metavar="NAME=VALUE", help="Hold this parameter; may be repeated."),
    ] = None
    prior: Annotated[
        list[str] | None,
        Option(
            "--prior",
            metavar="NAME=MEAN:SD",
            help="What is known of a free parameter; may be repeated.",
        ),
    ] = None
    prior_from: PriorFrom = None
    starts: Annotated[int, Option(min=1, help="Number of searches from different starts.")] = 4
    robust: Annotated[bool, Option("--robust", help="Let outliers count less (soft L1 loss).")] = (
        False
    )
    folds: Annotated[int, Option(min=0, help="Number of folds of the cross-validation.")] = 5
    bootstrap: Annotated[
        int, Option(min=0, help="Number of refits to rows drawn with replacement.")
    ] = 0
    seed: Annotated[int, Option(help="Seed of the random starts, folds and draws.")] = 2017
    picture: Annotated[
        Path | None, Option(metavar="FILE", help="Draw the fit: .png, .svg or .pdf.")
    ] = None

    @property
    def settings(self) -> Settings:
        """How the fit is done."""
        loss = "soft_l1" if self.robust else "linear"
        return Settings(self.starts, loss, self.folds, self.bootstrap, self.seed)

    def expected(self, prop: str, blade: Propeller, base: Airfoil | None) -> SectionPrior | None:
        """Predict the constants of ``prop``, by default where neither they nor a ``base`` are
        given."""
        by_default = self.free is None and base is None
        return section_prior(self.prior_from, prop, blade, by_default=by_default)

    def chosen(
        self,
        default: Sequence[str],
        base: Airfoil | None,
        also_fixed: Mapping[str, float] | None = None,
        expected: SectionPrior | None = None,
    ) -> Choice:
        """Choose what is free, by default ``default`` or the constants of a prior ``expected`` from
        other propellers, less those fixed. What holds the others and starts it is of ``base``, and
        of ``also_fixed``, as of a vehicle's wing."""
        law = base or (expected.airfoil if expected else None)
        given = {name: getattr(law, name) for name in SECTION} if law else {}
        stated = dict(_pair(text, "--fix") for text in self.fix or ())
        believed = dict(_pair(text, "--prior") for text in self.prior or ())
        wanted = tuple(default)
        if self.free is not None:
            wanted = tuple(name.strip() for name in self.free.split(","))
        elif expected is not None:
            more = [
                name for name in (*default, *believed) if name not in SECTION or name in believed
            ]
            wanted = tuple(dict.fromkeys((*PARAMETERS, *more)))
            wanted = tuple(name for name in wanted if name not in stated)
        values = {**given, **(also_fixed or {})}
        values |= {name: _number(value, f"--fix {name}") for name, value in stated.items()}
        fixed = {n: v for n, v in values.items() if n not in wanted or n in stated}
        beliefs = {}
        for name, text in believed.items():
            mean, colon, deviation = text.partition(":")
            if not colon:
                raise InputError(f"--prior {name} has no deviation", "write --prior c_l2=2.0:0.3")
            beliefs[name] = Prior(*(_number(v, f"--prior {name}") for v in (mean, deviation)))
        start = {n: v for n, v in values.items() if n in wanted}
        return Choice(wanted, fixed, beliefs, start, expected)


def _pair(text: str, option: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        example = next(iter(EVERY))
        raise InputError(f"{option} {quoted(text)} has no '='", f"write {option} {example}=6.0")
    return known(name.strip()), value.strip()


def _number(text: str, where: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{quoted(text)} is not a number", "give a number", where) from None


def section_prior(
    wanted: str | None, prop: str, blade: Propeller | None = None, *, by_default: bool
) -> SectionPrior | None:
    """Predict the constants of ``prop``, known or not, from others as ``--prior-from`` wants it, or
    not, and then as ``by_default`` says; its ``blade`` gives the size. Raises ``InputError`` for an
    unknown family."""
    source = (wanted or ("family" if by_default else "none")).strip().lower()
    if source == "none":
        return None
    try:
        meant = meant_by(prop)
    except InputError:  # a file, or the name of a blade in one
        meant = None
    family = meant.family if meant is not None else None
    if source == "population":
        family = None
    elif source != "family":
        families = sorted({one.family for one in all_identified()})
        if source not in families:
            close = difflib.get_close_matches(source, families, n=3) or families
            fault = f"{quoted(source)} is no family of identified propellers"
            remedy = f"give family, population, none or a code such as {', '.join(close)}"
            raise InputError(fault, remedy, "--prior-from")
        family = source
    found = None if meant is None or blade is None else own_constants(meant, blade.blades)
    own = found.tested if found is not None else None
    size = None if blade is None else size_of(meant, blade)
    geometry = "measured" if blade is None else geometry_of(meant, blade)
    distribution = expected_prior(family, size, geometry, without=own)
    members = siblings(family, without=own)
    few = "one propeller" if members == 1 else f"{members} propellers"
    others = f"{few} of the family {family}" if members else "small propellers of all families"
    words = f"the prior of the section constants is that of {others}"
    if own:
        words += " (its own in the catalogue left out)"
    return SectionPrior(distribution, airfoil_at(distribution.mean, "expected", words), words)


def note_prior(prior: SectionPrior | None) -> list[str]:
    """Note what prior a fit has, and return it as remarks for the fit's file."""
    if prior is None:
        return []
    out.note(f"{prior.source}; without, by --prior-from none")
    return [prior.source]


def check_outputs(output: Path | None, *pictures: Path | None) -> None:
    """Raise ``InputError`` where a fit or its pictures cannot be written."""
    if output is not None:
        out.check_output(output, (".toml",))
    out.check_pictures(*pictures)


# -------------------------------------------------------------------------------------------------
# What ``propmap fit`` writes and prints: parameters with their verdicts, residuals, remarks.


def finish(
    fitted: Fitted,
    found: Model,
    remarks: Sequence[str],
    text: str,
    output: Path | None,
    flights: Mapping[str, Mapping[str, FlightErrors]] | None = None,
) -> None:
    """Write the ``text`` of a fit file and print the fit, by flight too where that is known."""
    if output is not None:
        out.write_text(text, output)
    out.show(None, *_printed(fitted, found.correction_texts, remarks, flights or {}))
    if output is not None:
        echo(f"wrote {output}", err=True)


def _printed(
    fitted: Fitted,
    corrections: Sequence[str],
    remarks: Sequence[str],
    flights: Mapping[str, Mapping[str, FlightErrors]],
) -> Iterator[object]:
    sure, rows = fitted.uncertainty, fitted.rows
    parameters = []
    for k, name in enumerate(fitted.choice.free):
        interval = f"{sure.low[k]:.4g} to {sure.high[k]:.4g}"
        if fitted.bootstrapped.size:
            low, high = np.percentile(fitted.bootstrapped[:, k], [2.5, 97.5])
            interval += f" (bootstrap {low:.4g} to {high:.4g})"
        unit = described(name).unit
        parameters.append((name, f"{fitted.x[k]:.5g}", interval, unit, sure.verdicts[k]))
    yield out.grid("<|value|<95 % interval|<unit|<verdict", parameters, "Parameters")
    values = ", ".join(f"{v:.2g}" for v in sure.singular_values)
    yield f"sensitivities (singular values per spread, relative): {values}"
    residuals = []
    for k, (name, unit) in enumerate(zip(rows.names, rows.units, strict=True)):
        e = errors(*fitted.compared(k))
        relative, crossed = f"{100.0 * e.relative_rms:.2f} %", out.digits(fitted.cross_validated[k])
        size = (str(e.rows), f"{e.rms:.4g}", relative, f"{e.bias:+.3g}", f"{e.worst:+.3g}")
        residuals.append((name, *size, crossed, unit))
    heads = "<load|rows|rms|relative|bias|worst|cross-validated|<unit"
    yield out.grid(heads, residuals, "Residuals, model minus measurement")
    if flights:
        by_flight = []
        for load, unit in zip(rows.names, rows.units, strict=True):
            for k, (flight, f) in enumerate(flights[load].items()):
                crossed = out.digits(f.cross_validated_rms)
                part = (str(f.rows), f"{f.rms:.4g}", f"{f.bias:+.3g}", crossed)
                by_flight.append(("" if k else load, flight, *part, unit))
        heads = "<load|<flight|rows|rms|bias|cross-validated|<unit"
        yield out.grid(heads, by_flight, "Residuals of each flight")
    ends = fitted.minimum.ends
    best = sum(end.minimum == 1 for end in ends)
    many = f"{len(ends)} starts, {best} of them to the best minimum" if len(ends) > 1 else "1 start"
    yield f"{many}; {fitted.seconds:.1f} s"
    yield f"with {in_words(corrections)}, which comes along wherever the fit is used"
    yield from (f"note: {remark}" for remark in remarks)


MOST_LEFT = 0.5  # rms error over what was measured, beyond which no fit is of any use


def _refuse_poor(fitted: Fitted, warnings: Sequence[str], *, accept: bool) -> None:
    """Raise ``InputError`` for a fit that leaves most of thrust or torque, unless that is accepted,
    with what is doubtful about the data."""
    for k, name in enumerate(fitted.rows.names):
        left = errors(*fitted.compared(k)).relative_rms
        if name in ("thrust", "torque") and left > MOST_LEFT and not accept:
            found = f"the fit leaves {left:.0%} of the {name} (rms) and is not written"
            odd = [text for text in warnings if ": columns: " not in text]
            doubts = "; ".join(odd) or "neither units nor signs of the data stand out"
            remedy = "correct the data or the propeller, or write it all the same by --accept"
            raise InputError(f"{found}; {doubts}", remedy)


def _finish_tunnel(
    choice: opt.RotorChoice,
    model: Model,
    measured: tunnel.TunnelData,
    fitted: Fitted,
    output: Path | None,
    picture: Path | None,
    *,
    data: Sequence[str | Path],
    weights: Mapping[str, float],
    prior: SectionPrior | None,
    remarks: Sequence[str],
    warnings: Sequence[str],
) -> None:
    """Write, draw and print a fit to loads; ``warnings`` on the data are in its file alone."""
    rotor = tunnel.rotor_with(model, fitted.values, choice.accuracy)
    blade = model.propeller
    text = fit_text(
        fitted,
        kind="tunnel",
        name=output.stem if output else "static",
        model=model,
        data=data,
        covered=coverage(measured.omega, measured.speed, measured.folded_beta, blade.radius),
        envelope=Envelope.of(*measured.flow, blade.radius),
        hover=tunnel.hover_rows(rotor, measured, fitted.rows),
        remarks=[
            *note_prior(prior),
            *remarks,
            *plausibility.blade_warnings(blade),
            *plausibility.air_warnings(model.air),
            *warnings,
        ],
        options={"loads": list(fitted.rows.names), "weights": weights},
    )
    if picture is not None:
        from propmap.report.fit_curves import tunnel_fit

        out.save_picture(tunnel_fit(measured, rotor).figure(), picture)
    finish(fitted, rotor.model, remarks, text, output)


@opt.takes_choices
def fit_tunnel(
    choice: opt.RotorChoice,
    data: Annotated[
        list[str], Argument(metavar="DATA...", help="CSV or UIUC files, or measurements by name.")
    ],
    output: Output,
    loads: Annotated[str | None, Option(help="Loads to fit, separated by commas.")] = None,
    weight: Annotated[
        list[str] | None, Option(metavar="LOAD=W", help="Count this load's residuals W times.")
    ] = None,
    accept: Accept = False,
    cluster: opt.Cluster = None,
    asked: FitChoice = FitChoice(),
) -> None:
    """Fit loads measured in a tunnel or on a bench."""
    check_outputs(output, asked.picture)
    base = opt.constants(choice.airfoil) if choice.airfoil else None
    blade = choice.blade()
    default = ("c_l1", "c_l2", "c_d", "alpha_0", "zero_lift_angle")
    expected = asked.expected(choice.prop, blade, base)
    chosen = asked.chosen(default, base, expected=expected)
    weights = {}
    for text in weight or ():
        name, _, value = text.partition("=")
        try:
            weights[name.strip()] = float(value)
        except ValueError:
            found = f"--weight {text!r} has no number"
            raise InputError(found, "write --weight thrust=2") from None
    air = choice.medium()
    measured = tunnel.read_tunnel(data, blade, air)
    warnings = tunnel.tunnel_warnings(data, blade, air)
    out.note(*warnings)
    law = base or (expected.airfoil if expected else tunnel.first_guess())
    model = Model(blade, opt.with_physics(law, choice.model, choice.correction), air)
    options: Any = {
        "loads": [name.strip() for name in loads.split(",")] if loads else [],
        "weights": weights,
        "setting": choice.accuracy,
    }

    def rows_for(c: Choice) -> Rows:
        return tunnel.tunnel_rows(model, measured, c, **options)

    remake = functools.partial(tunnel.tunnel_rows, model, measured, chosen, **options)
    with opt.workers_of_bootstrap(cluster, asked.bootstrap) as workers:
        fitted = fit(remake(), chosen, asked.settings, workers=workers, remake=remake)
    _refuse_poor(fitted, warnings, accept=accept)
    remarks = [*range_warnings(fitted.rows), *comparison.failing_assumptions(fitted, rows_for)]
    remarks += comparison.unlikely_constants(fitted)
    said: Any = {"prior": expected, "remarks": remarks, "warnings": warnings}
    said |= {"data": tunnel.sources(data), "weights": weights}
    _finish_tunnel(choice, model, measured, fitted, output, asked.picture, **said)


# -------------------------------------------------------------------------------------------------
# ``propmap fit static``: a thrust stand's rows, and what they say of forward flight.

LIKE_ELECTRICAL = 1.2  # measured power over what the prior predicts; from there the battery's?
STILL = 0.5  # [m/s], what an anemometer at rest may show


@functools.partial(opt.takes_choices, prop=opt.PropOption)
def fit_static(
    choice: opt.RotorChoice,
    files: Annotated[
        list[Path],
        Argument(
            metavar="FILE...",
            help="CSV with columns of rpm, thrust, and torque or the shaft's power where measured, "
            "each with its unit, as thrust_g or 'Torque (N m)'; or UIUC files.",
        ),
    ],
    output: Annotated[Path | None, WRITTEN] = None,
    accept: Accept = False,
    asked: FitChoice = FitChoice(starts=1, folds=0),
) -> None:
    """Fit a static test, and predict forward flight."""
    check_outputs(output, asked.picture)
    base = opt.constants(choice.airfoil) if choice.airfoil else None
    blade, air = choice.blade(), choice.medium()
    parts = [_read_static(path, blade, air) for path in files]
    warnings = [text for part in parts for text in tunnel.data_warnings(part, blade, air)]
    out.note(*warnings)
    measured = tunnel.merged(parts)
    expected = asked.expected(choice.prop, blade, base)
    chosen = asked.chosen(("c_l1", "zero_lift_angle"), base, expected=expected)
    law = base or (expected.airfoil if expected else tunnel.first_guess())
    model = Model(blade, opt.with_physics(law, choice.model, choice.correction), air)
    setting = choice.accuracy
    rows = tunnel.tunnel_rows(model, measured, chosen, setting=setting)
    fitted = fit(rows, chosen, asked.settings)
    _refuse_poor(fitted, warnings, accept=accept)
    remarks = [*range_warnings(fitted.rows), *comparison.unlikely_constants(fitted)]
    if expected is not None:
        remarks += _like_electrical(fitted, measured)
    said: Any = {"prior": expected, "remarks": remarks, "warnings": warnings}
    said |= {"data": files, "weights": {}}
    _finish_tunnel(choice, model, measured, fitted, output, asked.picture, **said)
    _show_trust(comparison.forward_trust(model, fitted, float(np.median(measured.omega)), setting))


def _read_static(path: Path, propeller: Propeller, air: Air) -> tunnel.TunnelData:
    """Read loads at rest, coefficients with this propeller and air; ``InputError`` names the file
    and what is wrong in it, also where the air moves."""
    found = tunnel.measured_loads(path, at_rest=True)(propeller, air)
    if np.any(found.speed > STILL):
        fault = f"the air moves in some rows, by up to {np.max(found.speed):g} m/s"
        raise InputError(fault, "fit such data with propmap fit tunnel", str(path))
    return replace(found, speed=np.zeros_like(found.speed), beta=np.zeros_like(found.speed))


def _like_electrical(fitted: Fitted, measured: tunnel.TunnelData) -> list[str]:
    """Remark that a power is larger than a shaft's is likely to be."""
    rows = fitted.rows
    if "torque" not in rows.names or not measured.by_power:
        return []
    mine = rows.of_load(rows.names.index("torque"))
    value, _ = rows.model(fitted.choice.values(fitted.choice.first), fitted.choice.free)
    ratio = float(np.nanmedian(rows.measured[mine] / value[mine]))
    if ratio < LIKE_ELECTRICAL:
        return []
    return [
        f"the power is {ratio:.2f} times what other propellers predict; if it is that of the "
        "battery, with the losses of motor and controller, leave it out"
    ]


def _show_trust(trust: comparison.ForwardTrust) -> None:
    def change(before: float, after: float) -> str:
        if not np.isfinite(after):
            return "-"
        return f"{f'{before:.0%}' if np.isfinite(before) else '?'} -> {after:.0%}"

    rows = []
    for k, (advance, beta) in enumerate(zip(trust.advance, trust.beta, strict=True)):
        thrust, torque = trust.load[k]
        left = [change(*pair) for pair in zip(trust.before[k], trust.after[k], strict=True)]
        where = f"{advance:.1f}", f"{np.degrees(beta):.0f} deg"
        rows.append((*where, f"{thrust:.3g} N", left[0], f"{torque:.3g} N m", left[1]))
    heads = "J|beta|thrust|sd before -> after|torque|sd before -> after"
    title = f"What is left uncertain of flight at {trust.omega / RPM:.0f} rpm, 0 deg along the axis"
    out.show(
        None,
        out.grid(heads, rows, title),
        "sd: standard deviation of what the constants leave open, and "
        f"{comparison.MODEL_ERROR:.0%} of the load at rest for the model; checked in axial flow; "
        "stands differ by some per cent besides",
    )
