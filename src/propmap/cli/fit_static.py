"""``propmap fit static``: a thrust stand's rows, and what they tell of forward flight."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

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
from propmap.cli.fit_output import Picture, check_outputs, finish
from propmap.cli.output import grid, show
from propmap.cli.plausibility import say_doubts
from propmap.cli.prior_options import PriorFrom, say_prior, section_prior
from propmap.cli.rotor_options import (
    PropOption,
    RotorChoice,
    constants,
    takes_rotor,
    with_physics,
)
from propmap.errors import InputError
from propmap.io.csv import RPM
from propmap.model.plausibility import (
    doubts_on_air,
    doubts_on_blade,
    doubts_on_loads,
    doubts_on_points,
)

if TYPE_CHECKING:
    from propmap.fit.comparison import ForwardTrust
    from propmap.fit.fit import Fitted

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
    from propmap.cli.static_file import read_static
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

    from propmap.fit.comparison import doubts_on_constants, forward_trust
    from propmap.fit.files import fit_text
    from propmap.fit.fit import coverage, fit, range_warnings
    from propmap.fit.tunnel import first_guess, hover_rows, rotor_with, tunnel_rows
    from propmap.model.model import Model

    law = base or (expected.airfoil if expected else first_guess())
    model = Model(blade, with_physics(law, choice.model, choice.correction), air)
    setting = choice.accuracy.value
    fitted = fit(tunnel_rows(model, measured, chosen, setting=setting), chosen, settings)
    remarks = [*range_warnings(fitted.rows), *doubts_on_constants(fitted)]
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
    from propmap.cli.static_file import has_power

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
