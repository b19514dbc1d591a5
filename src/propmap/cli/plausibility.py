"""What is unlike small propellers or not measured, as notes beside the output of a command."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import typer

from propmap.catalogue.expected import ExpectedBlade
from propmap.catalogue.lookup import meant_by
from propmap.model.plausibility import doubts_on_points

if TYPE_CHECKING:
    from propmap.model.model import Model
    from propmap.typing import Floats


def say_doubts(doubts: Iterable[str]) -> None:
    """A line on standard error for each."""
    for doubt in doubts:
        typer.echo(f"note: {doubt}", err=True)


def say_expected(prop: str) -> None:
    """Say what a blade rests on that was not measured."""
    meant = meant_by(prop)
    if isinstance(meant, ExpectedBlade):
        typer.echo(f"note: {meant.told}", err=True)


def say_doubts_on_points(model: Model, omega: Floats, speed: Floats, beta: Floats) -> None:
    """Say what is odd about operating points [rad/s], [m/s], [rad], before loads are computed.

    Raises ``InputError`` where a blade tip is faster than sound.
    """
    say_doubts(doubts_on_points(model.propeller, omega, speed, beta))
