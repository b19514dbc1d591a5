"""``propmap fit tunnel``: section parameters from loads measured in a tunnel or on a bench."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from propmap.cli.cluster_option import Cluster, workers_of_bootstrap
from propmap.cli.fit_options import (
    Bootstrap,
    Fix,
    Folds,
    Free,
    Priors,
    Robust,
    Seed,
    Starts,
    choice_of,
    settings_of,
)
from propmap.cli.fit_output import Output, Picture, check_outputs, finish
from propmap.cli.plausibility import say_doubts
from propmap.cli.prior_options import PriorFrom, say_prior, section_prior
from propmap.cli.rotor_options import RotorChoice, constants, takes_rotor, with_physics
from propmap.errors import InputError
from propmap.model.plausibility import doubts_on_air, doubts_on_blade

if TYPE_CHECKING:
    from propmap.fit.least_squares import Rows
    from propmap.fit.parameters import Choice


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

    from propmap.fit.comparison import doubts_on_constants, failing_assumptions
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
    remarks += doubts_on_constants(fitted)
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
