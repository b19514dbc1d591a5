"""Options that all fits share, and what they mean."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import typer

from propmap.catalogue.identified import PARAMETERS
from propmap.errors import InputError, quoted
from propmap.fit.fit import Settings
from propmap.fit.parameters import EVERY, SECTION, Choice, Prior, SectionPrior, known
from propmap.model.airfoil import Airfoil

Free = Annotated[
    str | None,
    typer.Option("--free", metavar="NAMES", help="Free parameters, separated by commas."),
]
Fix = Annotated[
    list[str] | None, typer.Option("--fix", metavar="NAME=VALUE", help="Hold a parameter here.")
]
Priors = Annotated[
    list[str] | None,
    typer.Option("--prior", metavar="NAME=MEAN:SD", help="What is known of a free parameter."),
]
Starts = Annotated[int, typer.Option("--starts", min=1, help="Searches from different starts.")]
Robust = Annotated[bool, typer.Option("--robust", help="Let outliers count less (soft L1 loss).")]
Folds = Annotated[int, typer.Option("--folds", min=0, help="Folds of the cross-validation.")]
Bootstrap = Annotated[
    int, typer.Option("--bootstrap", min=0, help="Refits to rows drawn with replacement.")
]
Seed = Annotated[int, typer.Option("--seed", help="Of the random starts, folds and draws.")]


def choice_of(
    free: str | None,
    fix: Sequence[str] | None,
    priors: Sequence[str] | None,
    default: Sequence[str],
    base: Airfoil | None,
    also_fixed: dict[str, float] | None = None,
    expected: SectionPrior | None = None,
) -> Choice:
    """The free parameters and what holds the others.

    ``base`` gives the values of what is not free and the first start, ``also_fixed`` values known
    from elsewhere, as those of a vehicle's wing.  Where other propellers tell what is ``expected``,
    the constants of which they do are free by default, but those that are fixed, and any further
    ones of which ``priors`` tell.
    """
    law = base or (expected.airfoil if expected else None)
    given = {name: getattr(law, name) for name in SECTION} if law else {}
    stated = dict(_pair(text, "--fix") for text in fix or ())
    told = dict(_pair(text, "--prior") for text in priors or ())
    wanted = tuple(default)
    if free is not None:
        wanted = tuple(name.strip() for name in free.split(","))
    elif expected is not None:
        more = [name for name in (*default, *told) if name not in SECTION or name in told]
        wanted = tuple(dict.fromkeys((*PARAMETERS, *more)))
        wanted = tuple(name for name in wanted if name not in stated)
    values = given | (also_fixed or {}) | {n: _number(v, f"--fix {n}") for n, v in stated.items()}
    fixed = {n: v for n, v in values.items() if n not in wanted or n in stated}
    beliefs = {}
    for name, text in told.items():
        mean, colon, deviation = text.partition(":")
        if not colon:
            raise InputError(f"--prior {name} has no deviation", "write --prior c_l2=2.0:0.3")
        beliefs[name] = Prior(*(_number(v, f"--prior {name}") for v in (mean, deviation)))
    start = {n: v for n, v in values.items() if n in wanted}
    return Choice(wanted, fixed, beliefs, start, expected)


def settings_of(starts: int, robust: bool, folds: int, bootstrap: int, seed: int) -> Settings:
    """Settings of the fit."""
    return Settings(starts, "soft_l1" if robust else "linear", folds, bootstrap, seed)


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
