"""``propmap fit``: options and output of all fits, and fits to wind-tunnel and static tests."""

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
from propmap.catalogue.lookup import doubt_of, geometry_of, meant_by, own_constants
from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.cli.app import LazyGroup
from propmap.errors import InputError, quoted
from propmap.fit import comparison, tunnel
from propmap.fit.files import fit_text
from propmap.fit.fit import Fitted, Settings, coverage, fit, range_warnings
from propmap.fit.least_squares import FlightErrors, errors
from propmap.fit.parameters import EVERY, SECTION, Choice, Prior, SectionPrior, described, known
from propmap.loads import DRAG_FACTOR, MOUNT_AREA
from propmap.model import plausibility
from propmap.model.air import Air
from propmap.model.airfoil import Airfoil
from propmap.model.corrections import INSTALLED, Installed, in_words
from propmap.model.envelope import Envelope
from propmap.model.model import Model
from propmap.model.propeller import Propeller
from propmap.units import RPM


class FitCommands(LazyGroup):
    """Kinds of fits, in the order of the help."""

    places: ClassVar = {
        "tunnel": "fit.fit_tunnel",
        "flight": "fit_flight.fit_flight",
        "static": "fit.fit_static",
        "terms": "fit_flight.fit_terms_page",
    }


fit_app = typer.Typer(
    name="fit",
    cls=FitCommands,
    help="Identify the section constants of a propeller from measurements.",
    rich_markup_mode=None,
)


# --- Options of all fits -------------------------------------------------------------------------

PriorFrom = Annotated[
    str | None,
    Option(
        "--prior-from",
        metavar="family|population|none|CODE",
        help="Propellers whose constants form the prior: family (or all, if the family is "
        "unknown), population (all), CODE of another family such as apcsf, or none. Default: "
        "family, or none if other options state free parameters or constants.",
    ),
]
WRITTEN = out.output_option("Output file of the fit.", "FIT.toml")
Output = Annotated[Path, WRITTEN]


@dataclass(frozen=True)
class FitChoice:
    """Free parameters, priors and settings of a fit; each field becomes an option."""

    free: Annotated[
        str | None, Option("--free", metavar="NAMES", help="Free parameters, separated by commas.")
    ] = None
    fix: Annotated[
        list[str] | None,
        Option("--fix", metavar="NAME=VALUE", help="Value of a fixed parameter; may be repeated."),
    ] = None
    prior: Annotated[
        list[str] | None,
        Option(
            "--prior",
            metavar="NAME=MEAN:SD",
            help="Prior mean and standard deviation of a free parameter; may be repeated.",
        ),
    ] = None
    prior_from: PriorFrom = None
    starts: Annotated[int, Option(min=1, help="Number of searches from different starts.")] = 4
    robust: Annotated[
        bool, Option("--robust", help="Reduce the weight of outliers (soft L1 loss).")
    ] = False
    folds: Annotated[int, Option(min=0, help="Number of folds of the cross-validation.")] = 5
    bootstrap: Annotated[
        int, Option(min=0, help="Number of bootstrap refits (rows drawn with replacement).")
    ] = 0
    seed: Annotated[int, Option(help="Seed of the random starts, folds and draws.")] = 2017
    picture: Annotated[
        Path | None, Option(metavar="FILE", help="Picture of the fit: .png, .svg or .pdf.")
    ] = None
    accept: Annotated[
        bool,
        Option(
            "--accept",
            help="Write the fit even if an rms error exceeds a third of the rms thrust, vertical "
            "force or torque. Also write it if two section constants are at their bounds.",
        ),
    ] = False

    @property
    def settings(self) -> Settings:
        """Settings of the fit."""
        loss = "soft_l1" if self.robust else "linear"
        return Settings(self.starts, loss, self.folds, self.bootstrap, self.seed)

    def expected(self, prop: str, blade: Propeller, base: Airfoil | None) -> SectionPrior | None:
        """Return the prior of ``prop``; by default none with ``--free`` or with a ``base``."""
        by_default = self.free is None and base is None
        return section_prior(self.prior_from, prop, blade, by_default=by_default)

    def chosen(
        self,
        default: Sequence[str],
        base: Airfoil | None,
        also_fixed: Mapping[str, float] | None = None,
        expected: SectionPrior | None = None,
    ) -> Choice:
        """Return the free and fixed parameters with their priors and start values.

        Without ``--free``, the free parameters are ``default``, or the constants of the prior
        ``expected``. Start and fixed values are from ``base`` and ``also_fixed``.
        """
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
                fault = f"--prior {name} has no standard deviation"
                raise InputError(fault, f"write --prior {name}=MEAN:DEVIATION")
            beliefs[name] = Prior(*(_number(v, f"--prior {name}") for v in (mean, deviation)))
        start = {n: v for n, v in values.items() if n in wanted}
        return Choice(wanted, fixed, beliefs, start, expected)

    def refuse_implausible(self, fitted: Fitted, warnings: Sequence[str]) -> list[str]:
        """Raise ``InputError`` for an implausible fit, with doubts about the data.  With
        ``--accept``, return the reason as a remark instead."""
        reason = fitted.implausible
        if reason and not self.accept:
            odd = [text for text in warnings if ": columns: " not in text]
            doubts = "; ".join(odd) or "units and signs of the data look plausible"
            remedy = "correct the data or the propeller, or add --accept to write the fit"
            raise InputError(f"{reason}, so no file was written; {doubts}", remedy)
        return [f"the fit is accepted although {reason}"] if reason else []


def _pair(text: str, option: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        example = next(iter(EVERY))
        raise InputError(f"{option} {quoted(text)} has no '='", f"write {option} {example}=6.0")
    return known(name.strip()), value.strip()


def start_law(airfoil: str | None) -> Airfoil | None:
    """Return the constants of ``--airfoil``, or None; omit a typical installation, because no fit
    identified it."""
    law = opt.constants(airfoil) if airfoil else None
    if law is None or law.corrections is None:
        return law
    kept = tuple(text for text in law.corrections if text != INSTALLED)
    return law.with_parameters(corrections=kept)


def _number(text: str, where: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{quoted(text)} is not a number", "give a number", where) from None


def section_prior(
    wanted: str | None, prop: str, blade: Propeller | None = None, *, by_default: bool
) -> SectionPrior | None:
    """Return the prior of the constants of ``prop`` from the propellers that ``--prior-from``
    names. Without this option, the source is the family if ``by_default``, else none. ``blade``
    determines the size. Raises ``InputError`` for an unknown family."""
    source = (wanted or ("family" if by_default else "none")).strip().lower()
    if source == "none":
        return None
    try:
        meant = meant_by(prop)
    except InputError:  # ``prop`` is a file, or the name of a blade in a file
        meant = None
    family = meant.family if meant is not None else None
    if source == "population":
        family = None
    elif source != "family":
        families = sorted({one.family for one in all_identified()})
        if source not in families:
            close = difflib.get_close_matches(source, families, n=3) or families
            fault = f"{quoted(source)} is not a family of identified propellers"
            remedy = f"give family, population, none or a code such as {', '.join(close)}"
            raise InputError(fault, remedy, "--prior-from")
        family = source
    found = None if meant is None or blade is None else own_constants(meant, blade.blades)
    own = found.tested if found is not None else None
    size = None if blade is None else size_of(meant, blade)
    geometry = "measured" if blade is None else geometry_of(meant, blade)
    count = 2 if blade is None else blade.blades
    doubt = doubt_of(meant, count)
    distribution = expected_prior(family, size, geometry, count, doubt, without=own)
    members = siblings(family, without=own)
    few = "one propeller" if members == 1 else f"{members} propellers"
    others = f"{few} of the family {family}" if members else "small propellers of all families"
    words = f"the prior of the section constants is from {others}"
    if own:
        words += " (without the catalogue constants of this propeller)"
    return SectionPrior(distribution, airfoil_at(distribution.mean, "expected", words), words)


def note_prior(prior: SectionPrior | None) -> list[str]:
    """Note the prior of a fit, and return it as remarks for the fit file."""
    if prior is None:
        return []
    out.note(f"{prior.source}; --prior-from none omits it")
    return [prior.source]


def check_outputs(output: Path | None, *pictures: Path | None) -> None:
    """Raise ``InputError`` if a fit or its pictures cannot be written."""
    if output is not None:
        out.check_output(output, (".toml",))
    out.check_pictures(*pictures)


# --- Output of ``propmap fit``: parameters with their verdicts, residuals, remarks ---------------

NO_DRAG = (
    "rotor drag in oblique flow was not fitted: this fit predicts the drag of a typical installed "
    "rotor (correction installed); for bare blades, use --bare of predict, sweep or table"
)


def finish(
    fitted: Fitted,
    found: Model,
    remarks: Sequence[str],
    text: str,
    output: Path | None,
    flights: Mapping[str, Mapping[str, FlightErrors]] | None = None,
) -> None:
    """Write the ``text`` of a fit file and print the fit, with the errors of single ``flights``."""
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
    yield f"sensitivities (relative singular values of the scaled derivatives): {values}"
    residuals = []
    for k, (name, unit) in enumerate(zip(rows.names, rows.units, strict=True)):
        e = errors(*fitted.compared(k))
        relative, crossed = out.percent(e.relative_rms, 2), out.digits(fitted.cross_validated[k])
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
    many = f"{len(ends)} starts, {best} reached the best minimum" if len(ends) > 1 else "1 start"
    yield f"{many}; {fitted.seconds:.1f} s"
    yield f"model: {in_words(corrections)}; commands that use the fit apply the same model"
    yield from (f"note: {remark}" for remark in remarks)


def _finish_tunnel(
    choice: opt.RotorChoice,
    asked: FitChoice,
    model: Model,
    measured: tunnel.TunnelData,
    fitted: Fitted,
    output: Path | None,
    data: Sequence[str | Path],
    prior: SectionPrior | None,
    remarks: Sequence[str],
    warnings: Sequence[str],
    weights: Mapping[str, float] | None = None,
) -> None:
    """Write, draw and print a fit to loads; only its file contains the ``warnings`` on the data."""
    drag = "drag" in fitted.rows.names and measured.has_rotor_drag
    if not drag and choice.model != "paper" and model.correction_of(Installed) is None:
        model, remarks = model.with_mount(Installed()), [*remarks, NO_DRAG]
    rotor = tunnel.rotor_with(model, fitted.values, choice.accuracy)
    blade = model.propeller
    remarks = [*remarks, *range_warnings(fitted.rows), *comparison.unlikely_constants(fitted)]
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
        options={"loads": list(fitted.rows.names), "weights": weights or {}},
    )
    if asked.picture is not None:
        from propmap.report.fit_curves import tunnel_fit

        out.save_picture(tunnel_fit(measured, rotor).figure(), asked.picture)
    finish(fitted, rotor.model, remarks, text, output)


@functools.partial(opt.takes_choices, airfoil=opt.FitAirfoilOption, bare=None)
def fit_tunnel(
    choice: opt.RotorChoice,
    data: Annotated[
        list[str],
        Argument(
            metavar="DATA...",
            help="CSV or UIUC files, or measurements in the catalogue such as uiuc-8x6e.",
        ),
    ],
    output: Output,
    loads: Annotated[
        str | None, Option(help="Loads to fit, separated by commas (default: all measured).")
    ] = None,
    weight: Annotated[
        list[str] | None,
        Option(metavar="LOAD=W", help="Factor on the residuals of a load; may be repeated."),
    ] = None,
    cluster: opt.Cluster = None,
    asked: FitChoice = FitChoice(),
) -> None:
    """Fit section constants to wind-tunnel or bench measurements."""
    check_outputs(output, asked.picture)
    base, blade = start_law(choice.airfoil), choice.blade()
    expected = asked.expected(choice.prop, blade, base)
    pairs = (text.partition("=") for text in weight or ())
    weights = {name.strip(): _number(value, f"--weight {name}") for name, _, value in pairs}
    air = choice.medium()
    measured = tunnel.read_tunnel(data, blade, air)
    out.note(*measured.remarks)
    law = base or (expected.airfoil if expected else tunnel.first_guess())
    model = Model(blade, opt.with_physics(law, choice.model, choice.correction), air)
    names = [name.strip() for name in loads.split(",")] if loads else []
    mount: dict[str, Prior] = {}
    drag = measured.has_rotor_drag and (not names or "drag" in names)
    if drag and choice.model != "paper" and model.correction_of(Installed) is None:
        typical, radius = Installed(), blade.radius
        means = {DRAG_FACTOR: typical.blade_factor, MOUNT_AREA: typical.area(radius)}
        fixed = {text.partition("=")[0].strip() for text in asked.fix or ()}
        spread = {n: std for n, std in typical.deviations(radius).items() if n not in fixed}
        mount = {n: Prior(means[n], std) for n, std in spread.items()}
    default = ("c_l1", "c_l2", "c_d", "alpha_0", "zero_lift_angle", *mount)
    chosen = asked.chosen(default, base, expected=expected)
    if asked.free is None:
        chosen = replace(chosen, priors={**mount, **chosen.priors})
    options: Any = {"loads": names, "weights": weights, "setting": choice.accuracy}

    remake = functools.partial(tunnel.tunnel_rows, model, measured, chosen, **options)
    with opt.workers_of_bootstrap(cluster, asked.bootstrap) as workers:
        fitted = fit(remake(), chosen, asked.settings, workers=workers, remake=remake)
    remarks = asked.refuse_implausible(fitted, measured.remarks)
    remarks += comparison.failing_assumptions(
        fitted, lambda c: tunnel.tunnel_rows(model, measured, c, **options)
    )
    said = expected, remarks, measured.remarks
    files = tunnel.sources(data)
    _finish_tunnel(choice, asked, model, measured, fitted, output, files, *said, weights=weights)


# -------------------------------------------------------------------------------------------------
# ``propmap fit static``: a fit to a static test, and the uncertainty it leaves in forward flight.

LIKE_ELECTRICAL = 1.2  # ratio of measured to expected power above which it may be electrical
STILL = 0.5  # largest reading of an anemometer in still air [m/s]


@functools.partial(opt.takes_choices, prop=opt.PropOption, airfoil=opt.FitAirfoilOption, bare=None)
def fit_static(
    choice: opt.RotorChoice,
    files: Annotated[
        list[Path],
        Argument(
            metavar="FILE...",
            help="UIUC files, or CSV files with rpm, thrust and, if measured, torque or shaft "
            "power; column names include the unit, such as thrust_g or 'Torque (N m)'.",
        ),
    ],
    output: Annotated[Path | None, WRITTEN] = None,
    asked: FitChoice = FitChoice(starts=1, folds=0),
) -> None:
    """Fit section constants to a static test of a propeller.

    The command also predicts thrust and torque in forward flight, with standard deviations.
    """
    check_outputs(output, asked.picture)
    base = start_law(choice.airfoil)
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
    remarks = asked.refuse_implausible(fitted, warnings)
    if expected is not None:
        remarks += _like_electrical(fitted, measured)
    said = expected, remarks, warnings
    _finish_tunnel(choice, asked, model, measured, fitted, output, files, *said)
    _show_trust(comparison.forward_trust(model, fitted, float(np.median(measured.omega)), setting))


def _read_static(path: Path, propeller: Propeller, air: Air) -> tunnel.TunnelData:
    """Read static loads, with this propeller and air for coefficients; raise ``InputError`` with
    the name of the file for bad data and for moving air."""
    found = tunnel.measured_loads(path, at_rest=True)(propeller, air)
    if np.any(found.speed > STILL):
        fault = f"some rows have an airspeed, up to {np.max(found.speed):g} m/s"
        raise InputError(fault, "fit such data with propmap fit tunnel", str(path))
    return replace(found, speed=np.zeros_like(found.speed), beta=np.zeros_like(found.speed))


def _like_electrical(fitted: Fitted, measured: tunnel.TunnelData) -> list[str]:
    """Return a remark if the measured power is probably electrical power."""
    rows = fitted.rows
    if "torque" not in rows.names or not measured.by_power:
        return []
    mine = rows.of_load(rows.names.index("torque"))
    value, _ = rows.model(fitted.choice.values(fitted.choice.first), fitted.choice.free)
    ratio = float(np.nanmedian(rows.measured[mine] / value[mine]))
    if ratio < LIKE_ELECTRICAL:
        return []
    return [
        f"the measured power is {ratio:.2f} times the power expected from other propellers; if it "
        "is battery power, which includes losses of motor and controller, leave it out"
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
    title = f"Uncertainty in flight at {trust.omega / RPM:.0f} rpm (beta 0 deg: along the axis)"
    out.show(
        None,
        out.grid(heads, rows, title),
        "sd: relative standard deviation from the section constants and from errors of the model "
        f"({comparison.MODEL_ERROR:.0%} of the static load, and the error of the theory in oblique "
        "flow); sd excludes differences between thrust stands (a few percent)",
    )
