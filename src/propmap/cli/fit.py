"""``propmap fit``: its commands, on tunnels and thrust stands, and what all fits print."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple

import numpy as np
import typer

from propmap.cli.fit_options import (
    Bootstrap,
    Fix,
    Folds,
    Free,
    PriorFrom,
    Priors,
    Robust,
    Seed,
    Starts,
    choice_of,
    say_prior,
    section_prior,
    settings_of,
)
from propmap.cli.lazy_group import LazyGroup
from propmap.cli.options import (
    Cluster,
    PropOption,
    RotorChoice,
    constants,
    say_doubts,
    takes_rotor,
    with_physics,
    workers_of_bootstrap,
)
from propmap.cli.output import check_output, check_pictures, grid, show, write_text
from propmap.errors import InputError
from propmap.fit.fit import Fitted
from propmap.fit.least_squares import FlightErrors, errors
from propmap.fit.parameters import described
from propmap.fit.tunnel import TunnelData, read_tunnel
from propmap.io.csv import RPM, read_columns, read_lines
from propmap.io.uiuc import looks_like_uiuc_loads
from propmap.model.corrections import in_words
from propmap.model.model import Air, Propeller
from propmap.model.plausibility import (
    doubts_on_air,
    doubts_on_blade,
    doubts_on_loads,
    doubts_on_points,
)
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.fit.comparison import ForwardTrust
    from propmap.fit.fit import Fitted
    from propmap.fit.least_squares import FlightErrors, Rows
    from propmap.fit.parameters import Choice
    from propmap.model.model import Model


# -------------------------------------------------------------------------------------------------
# The commands of ``propmap fit`` together.


class FitCommands(LazyGroup):
    """What can be fitted, in the order in which help lists it."""

    places: ClassVar = {
        "tunnel": "fit.fit_tunnel",
        "flight": "fit_flight.fit_flight",
        "static": "fit.fit_static",
        "terms": "fit_flight.fit_terms_page",
        "catalogue": "fit_catalogue.fit_catalogue",
    }


fit_app = typer.Typer(
    name="fit",
    cls=FitCommands,
    help="Identify section parameters.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


# -------------------------------------------------------------------------------------------------
# Where fits go, the same for all commands of ``propmap fit``: a file, a picture, the screen.

Output = Annotated[
    Path, typer.Option("--output", "-o", metavar="FIT.toml", help="Where the fit is written.")
]
Picture = Annotated[
    Path | None, typer.Option("--picture", metavar="FILE", help="Picture of the fit.")
]


def check_outputs(output: Path | None, *pictures: Path | None) -> None:
    """Raise ``InputError`` where a fit or its pictures cannot be written."""
    if output is not None:
        check_output(output, (".toml",))
    check_pictures(*pictures)


def finish(
    fitted: Fitted,
    found: Model,
    remarks: Sequence[str],
    text: str,
    output: Path | None,
    flights: Mapping[str, Mapping[str, FlightErrors]] | None = None,
) -> None:
    """Write the ``text`` of a fit file and show the fit, by flight where ``flights`` has that."""

    if output is not None:
        write_text(text, output)
    show(None, *told(fitted, found.correction_texts, remarks, flights or {}))
    if output is not None:
        typer.echo(f"wrote {output}", err=True)


# -------------------------------------------------------------------------------------------------
# What ``propmap fit`` prints: parameters with their verdicts, residuals, remarks.


def told(
    fitted: Fitted,
    corrections: Sequence[str],
    remarks: Sequence[str],
    flights: Mapping[str, Mapping[str, FlightErrors]],
) -> Iterator[object]:
    """Texts and tables on a fit that was made with these corrections, by load and flight too."""
    sure, rows = fitted.uncertainty, fitted.rows
    heads = "<|value|<95 % interval|<unit|<verdict"
    yield grid(heads, [_parameter(fitted, k) for k in range(len(fitted.choice.free))], "Parameters")
    values = ", ".join(f"{v:.2g}" for v in sure.singular_values)
    yield f"sensitivities (singular values per spread, relative): {values}"
    heads = "<load|rows|rms|relative|bias|worst|cross-validated|<unit"
    residuals = [_residuals(fitted, k) for k in range(len(rows.names))]
    yield grid(heads, residuals, "Residuals, model minus measurement")
    if flights:
        heads = "<load|<flight|rows|rms|bias|cross-validated|<unit"
        yield grid(heads, _by_flight(fitted, flights), "Residuals of each flight")
    ends = fitted.minimum.ends
    best = sum(end.minimum == 1 for end in ends)
    many = f"{len(ends)} starts, {best} of them to the best minimum" if len(ends) > 1 else "1 start"
    yield f"{many}; {fitted.seconds:.1f} s"
    yield f"with {in_words(corrections)}, which comes along wherever the fit is used"
    yield from (f"note: {remark}" for remark in remarks)


def _parameter(fitted: Fitted, k: int) -> tuple[str, ...]:
    name, sure = fitted.choice.free[k], fitted.uncertainty
    interval = f"{sure.low[k]:.4g} to {sure.high[k]:.4g}"
    if fitted.bootstrapped.size:
        low, high = np.percentile(fitted.bootstrapped[:, k], [2.5, 97.5])
        interval += f" (bootstrap {low:.4g} to {high:.4g})"
    return name, f"{fitted.x[k]:.5g}", interval, described(name).unit, sure.verdicts[k]


def _by_flight(
    fitted: Fitted, flights: Mapping[str, Mapping[str, FlightErrors]]
) -> list[tuple[str, ...]]:
    return [
        (
            load if first else "",
            flight,
            str(e.rows),
            f"{e.rms:.4g}",
            f"{e.bias:+.3g}",
            f"{e.cross_validated_rms:.4g}" if np.isfinite(e.cross_validated_rms) else "-",
            unit,
        )
        for load, unit in zip(fitted.rows.names, fitted.rows.units, strict=True)
        for first, (flight, e) in zip(
            (True, *(len(flights[load]) * (False,))), flights[load].items(), strict=False
        )
    ]


def _residuals(fitted: Fitted, k: int) -> tuple[str, ...]:
    e, crossed = errors(*fitted.compared(k)), fitted.cross_validated[k]
    return (
        fitted.rows.names[k],
        str(e.rows),
        f"{e.rms:.4g}",
        f"{100.0 * e.relative_rms:.2f} %",
        f"{e.bias:+.3g}",
        f"{e.worst:+.3g}",
        f"{crossed:.4g}" if np.isfinite(crossed) else "-",
        fitted.rows.units[k],
    )


# -------------------------------------------------------------------------------------------------
# Static tests as thrust stands write them: CSV with rpm and loads, or a UIUC file.

GRAM_FORCE = 9.80665e-3
"""[N]."""


class Column(NamedTuple):
    """What a column holds: a load, and its size in N or N m; a power is torque times Omega."""

    load: str
    unit: float
    is_power: bool = False


COLUMNS = {
    "thrust_N": Column("thrust", 1.0),
    "thrust_g": Column("thrust", GRAM_FORCE),
    "thrust_kg": Column("thrust", 1000.0 * GRAM_FORCE),
    "torque_Nm": Column("torque", 1.0),
    "torque_Ncm": Column("torque", 0.01),
    "torque_mNm": Column("torque", 0.001),
    "power_W": Column("torque", 1.0, is_power=True),
}
"""Columns of loads; power is that of the shaft."""

SPEED = "speed_mps"


def read_static(files: Sequence[Path], propeller: Propeller, air: Air) -> list[TunnelData]:
    """Loads at rest, one set per file; coefficients become loads with this propeller and air.

    Raises
    ------
    InputError
        Naming the file and what is wrong in it; also where the air moves.
    """
    return [_read(path, propeller, air) for path in files]


def _read(path: Path, propeller: Propeller, air: Air) -> TunnelData:
    if path.is_file() and looks_like_uiuc_loads(path):
        found = read_tunnel([str(path)], propeller, air)
        _check_rest(found.speed, path)
        return found
    columns = read_columns(path, ("rpm",), (*COLUMNS, SPEED), "CSV file of a static test")
    _check_rest(np.nan_to_num(columns.pop(SPEED, np.zeros(1))), path)
    omega = columns.pop("rpm") * RPM
    loads: dict[str, Floats] = {}
    for name, values in columns.items():
        column = COLUMNS[name]
        if column.load in loads:
            raise InputError(
                f"line 1: {column.load} is given twice, the second time as {name}",
                "keep one of the columns",
                str(path),
            )
        if column.is_power:
            values = np.divide(values, omega, out=np.full_like(omega, np.nan), where=omega > 0.0)
        loads[column.load] = values * column.unit
    if not loads:
        raise InputError(
            "line 1: there is no column with a load",
            f"add one of {', '.join(COLUMNS)}; power is that of the shaft",
            str(path),
        )
    still = np.zeros_like(omega)
    return TunnelData(path.name, omega, still, still, loads)


def _check_rest(speed: Floats, path: Path) -> None:
    if np.any(speed != 0.0):
        raise InputError(
            f"the air moves in some rows, by up to {np.max(speed):g} m/s",
            "fit such data with propmap fit tunnel",
            str(path),
        )


def has_power(path: Path) -> bool:
    """Whether a CSV file that was read gives the power in place of the torque."""
    return not looks_like_uiuc_loads(path) and "power_W" in "".join(read_lines(path, "CSV file"))


# -------------------------------------------------------------------------------------------------
# ``propmap fit tunnel``: section parameters from loads measured in a tunnel or on a bench.


@takes_rotor
def fit_tunnel(
    choice: RotorChoice,
    data: Annotated[
        list[str],
        typer.Argument(metavar="DATA...", help="CSV or UIUC files, or measurements by name."),
    ],
    output: Output,
    free: Free = None,
    loads: Annotated[
        str | None, typer.Option("--loads", help="Loads to fit, separated by commas.")
    ] = None,
    weight: Annotated[
        list[str] | None,
        typer.Option("--weight", metavar="LOAD=W", help="Count this load's residuals W times."),
    ] = None,
    fix: Fix = None,
    prior: Priors = None,
    prior_from: PriorFrom = None,
    starts: Starts = 4,
    robust: Robust = False,
    folds: Folds = 5,
    bootstrap: Bootstrap = 0,
    seed: Seed = 2017,
    picture: Picture = None,
    cluster: Cluster = None,
) -> None:
    """Fit loads measured in a tunnel or on a bench."""
    from propmap.fit.tunnel import doubts_on_tunnel, read_tunnel, sources

    check_outputs(output, picture)
    base = constants(choice.airfoil) if choice.airfoil else None
    blade = choice.blade()
    default = ("c_l1", "c_l2", "c_d", "alpha_0", "zero_lift_angle")
    by_default = free is None and base is None
    expected = section_prior(prior_from, choice.prop, blade, by_default=by_default)
    chosen = choice_of(free, fix, prior, default, base, expected=expected)
    settings = settings_of(starts, robust, folds, bootstrap, seed)
    weights = _weights(weight)
    air = choice.medium()
    measured = read_tunnel(data, blade, air)
    doubts = doubts_on_tunnel(data, blade, air)
    say_doubts(doubts)

    from propmap.fit.comparison import failing_assumptions, unlikely_constants
    from propmap.fit.files import fit_text
    from propmap.fit.fit import coverage, fit, range_warnings
    from propmap.fit.tunnel import first_guess, hover_rows, rotor_with, tunnel_rows
    from propmap.model.model import Model

    law = base or (expected.airfoil if expected else first_guess())
    model = Model(blade, with_physics(law, choice.model, choice.correction), air)
    named = [name.strip() for name in loads.split(",")] if loads else []

    options: Any = {"loads": named, "weights": weights, "setting": choice.accuracy.value}

    def rows_for(c: Choice) -> Rows:
        return tunnel_rows(model, measured, c, **options)

    remake = functools.partial(tunnel_rows, model, measured, chosen, **options)
    with workers_of_bootstrap(cluster, bootstrap) as workers:
        fitted = fit(remake(), chosen, settings, workers=workers, remake=remake)
    remarks = [*range_warnings(fitted.rows), *failing_assumptions(fitted, rows_for)]
    remarks += unlikely_constants(fitted)
    rotor = rotor_with(model, fitted.values, choice.accuracy.value)
    text = fit_text(
        fitted,
        kind="tunnel",
        name=output.stem,
        model=model,
        data=sources(data),
        covered=coverage(measured.omega, measured.speed, measured.folded_beta, blade.radius),
        hover=hover_rows(rotor, measured, fitted.rows),
        remarks=[
            *say_prior(expected),
            *remarks,
            *doubts_on_blade(blade),
            *doubts_on_air(air),
            *doubts,
        ],
        options={"loads": list(fitted.rows.names), "weights": weights},
    )
    if picture is not None:
        from propmap.report.fit_curves import tunnel_fit
        from propmap.report.html import save

        save(tunnel_fit(measured, rotor), picture)
    finish(fitted, rotor.model, remarks, text, output)


def _weights(texts: Sequence[str] | None) -> dict[str, float]:
    found = {}
    for text in texts or ():
        name, _, value = text.partition("=")
        try:
            found[name.strip()] = float(value)
        except ValueError:
            raise InputError(
                f"--weight {text!r} has no number", "write --weight thrust=2"
            ) from None
    return found


# -------------------------------------------------------------------------------------------------
# ``propmap fit static``: a thrust stand's rows, and what they tell of forward flight.

LIKE_ELECTRICAL = 1.2
"""Measured power over what the prior lets expect, from which it may be the battery's."""


@functools.partial(takes_rotor, prop=PropOption)
def fit_static(
    choice: RotorChoice,
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="FILE...",
            help="CSV with the columns rpm and thrust_N, thrust_g or thrust_kg, and torque_Nm, "
            "torque_Ncm, torque_mNm or the shaft's power_W where measured; or UIUC files.",
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", metavar="FIT.toml", help="Where the fit is written."),
    ] = None,
    free: Free = None,
    fix: Fix = None,
    prior: Priors = None,
    prior_from: PriorFrom = None,
    starts: Starts = 1,
    robust: Robust = False,
    folds: Folds = 0,
    bootstrap: Bootstrap = 0,
    seed: Seed = 2017,
    picture: Picture = None,
) -> None:
    """Fit a static test, and say what it tells of forward flight."""
    from propmap.fit.tunnel import merged

    check_outputs(output, picture)
    base = constants(choice.airfoil) if choice.airfoil else None
    blade, air = choice.blade(), choice.medium()
    parts = read_static(files, blade, air)
    doubts = []
    for part in parts:
        points = part.omega, part.speed, part.beta
        try:
            odd = doubts_on_points(blade, *points)
            odd += doubts_on_loads(blade, air, *points, part.loads)
        except InputError as error:
            raise InputError(error.found, error.remedy, part.source) from None
        doubts += [f"{part.source}: {doubt}" for doubt in odd]
    say_doubts(doubts)
    measured = merged(parts)
    by_default = free is None and base is None
    expected = section_prior(prior_from, choice.prop, blade, by_default=by_default)
    chosen = choice_of(free, fix, prior, ("c_l1", "zero_lift_angle"), base, expected=expected)
    settings = settings_of(starts, robust, folds, bootstrap, seed)

    from propmap.fit.comparison import forward_trust, unlikely_constants
    from propmap.fit.files import fit_text
    from propmap.fit.fit import coverage, fit, range_warnings
    from propmap.fit.tunnel import first_guess, hover_rows, rotor_with, tunnel_rows
    from propmap.model.model import Model

    law = base or (expected.airfoil if expected else first_guess())
    model = Model(blade, with_physics(law, choice.model, choice.correction), air)
    setting = choice.accuracy.value
    fitted = fit(tunnel_rows(model, measured, chosen, setting=setting), chosen, settings)
    remarks = [*range_warnings(fitted.rows), *unlikely_constants(fitted)]
    if expected is not None:
        remarks += _like_electrical(fitted, files)
    rotor = rotor_with(model, fitted.values, setting)
    text = fit_text(
        fitted,
        kind="tunnel",
        name=output.stem if output else "static",
        model=model,
        data=files,
        covered=coverage(measured.omega, measured.speed, measured.beta, blade.radius),
        hover=hover_rows(rotor, measured, fitted.rows),
        remarks=[
            *say_prior(expected),
            *remarks,
            *doubts_on_blade(blade),
            *doubts_on_air(air),
            *doubts,
        ],
        options={"loads": list(fitted.rows.names), "weights": {}},
    )
    if picture is not None:
        from propmap.report.fit_curves import tunnel_fit
        from propmap.report.html import save

        save(tunnel_fit(measured, rotor), picture)
    finish(fitted, rotor.model, remarks, text, output)
    _tell(forward_trust(model, fitted, float(np.median(measured.omega)), setting))


def _like_electrical(fitted: Fitted, files: list[Path]) -> list[str]:
    """A doubt about a power that is larger than a shaft's is likely to be."""

    rows = fitted.rows
    if "torque" not in rows.names or not any(has_power(path) for path in files):
        return []
    mine = rows.of_load(rows.names.index("torque"))
    value, _ = rows.model(fitted.choice.values(fitted.choice.first), fitted.choice.free)
    ratio = float(np.nanmedian(rows.measured[mine] / value[mine]))
    if ratio < LIKE_ELECTRICAL:
        return []
    return [
        f"power_W is {ratio:.2f} times what other propellers let expect; if it is that of the "
        "battery, with the losses of motor and controller, leave it out"
    ]


def _tell(trust: ForwardTrust) -> None:
    """A table of what forward flight can be trusted to."""
    from propmap.fit.comparison import MODEL_ERROR

    heads = "J|beta|thrust|sd before -> after|torque|sd before -> after"
    rows = [
        (
            f"{trust.advance[k]:.1f}",
            f"{np.degrees(trust.beta[k]):.0f} deg",
            f"{trust.load[k, 0]:.3g} N",
            _change(trust.before[k, 0], trust.after[k, 0]),
            f"{trust.load[k, 1]:.3g} N m",
            _change(trust.before[k, 1], trust.after[k, 1]),
        )
        for k in range(trust.advance.size)
    ]
    title = f"What is left uncertain of flight at {trust.omega / RPM:.0f} rpm, 0 deg along the axis"
    show(
        None,
        grid(heads, rows, title),
        f"sd: standard deviation of what the constants leave open, and {MODEL_ERROR:.0%} of the "
        "load at rest for the model; checked in axial flow; stands differ by some per cent besides",
    )


def _change(before: float, after: float) -> str:
    if not np.isfinite(after):
        return "-"
    return f"{f'{before:.0%}' if np.isfinite(before) else '?'} -> {after:.0%}"
