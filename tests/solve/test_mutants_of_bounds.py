"""A bound that is made too small is noticed by the check that compares it with what it bounds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from propmap.physics import tip_loss
from propmap.physics.sections.blended import BlendedLaw
from propmap.physics.tip_loss import PrandtlLoss
from propmap.physics.wake import Wake
from propmap.solve import bounds, root
from tests.solve.test_bounds import (
    newton_steps_meet_the_theorem,
    no_root_lies_above_the_start,
    prandtls_factor_keeps_within_its_bounds,
    the_blade_bends_by_no_more,
    the_law_keeps_within_its_bounds,
    the_wake_bends_by_no_more,
    the_wake_bends_by_no_more_in_nearly_axial_flow,
    the_wake_is_close_to_that_of_axial_flow,
    the_walk_passes_no_root,
)


def scaled(function: Callable[..., Any], factor: float) -> Callable[..., Any]:
    return lambda *arguments: factor * function(*arguments)


def with_field(function: Callable[..., Any], name: str, factor: float) -> Callable[..., Any]:
    """``function`` whose result has one field multiplied."""

    def changed(*arguments: Any) -> Any:
        right = function(*arguments)
        return right._replace(**{name: factor * getattr(right, name)})

    return changed


LAW, FACTOR = BlendedLaw.bounds, PrandtlLoss.bounds
MUTANTS: dict[str, tuple[Any, str, Any, Callable[[], None]]] = {
    "Newton steps that prove nothing": (root, "SURE", 2.0, newton_steps_meet_the_theorem),
    "a quarter of the blade's bend": (
        bounds,
        "_blade_bend",
        scaled(bounds._blade_bend, 0.25),
        the_blade_bends_by_no_more,
    ),
    "safe steps twice as long": (
        root,
        "safe_step",
        scaled(bounds.safe_step, 2.0),
        the_walk_passes_no_root,
    ),
    "a start a tenth lower": (
        bounds,
        "_start",
        scaled(bounds._start, 0.9),
        no_root_lies_above_the_start,
    ),
    "half the wake's bend": (
        Wake,
        "largest_bend",
        scaled(Wake.largest_bend, 0.5),
        the_wake_bends_by_no_more,
    ),
    "half the wake's bend in nearly axial flow": (
        Wake,
        "largest_bend",
        scaled(Wake.largest_bend, 0.5),
        the_wake_bends_by_no_more_in_nearly_axial_flow,
    ),
    "half the way to the wake of axial flow": (
        Wake,
        "most_below_axial",
        scaled(Wake.most_below_axial, 0.5),
        the_wake_is_close_to_that_of_axial_flow,
    ),
    "half the law's bend": (
        BlendedLaw,
        "bounds",
        with_field(LAW, "lift_bend", 0.5),
        the_law_keeps_within_its_bounds,
    ),
    "half the bend at the foot of stall": (
        BlendedLaw,
        "bounds",
        with_field(LAW, "foot_bend", 0.5),
        the_law_keeps_within_its_bounds,
    ),
    "attached up to twice alpha_0": (
        BlendedLaw,
        "bounds",
        with_field(LAW, "attached_to", 2.0),
        the_law_keeps_within_its_bounds,
    ),
    "nine tenths of the largest lift": (
        BlendedLaw,
        "bounds",
        with_field(LAW, "lift", 0.9),
        the_law_keeps_within_its_bounds,
    ),
    "a larger least factor": (
        PrandtlLoss,
        "bounds",
        with_field(FACTOR, "least", 1.05),
        prandtls_factor_keeps_within_its_bounds,
    ),
    "two thirds of the factor's slope": (
        PrandtlLoss,
        "bounds",
        with_field(FACTOR, "slope", 0.67),
        prandtls_factor_keeps_within_its_bounds,
    ),
    "a third of the factor's bend": (
        PrandtlLoss,
        "bounds",
        with_field(FACTOR, "bend", 0.33),
        prandtls_factor_keeps_within_its_bounds,
    ),
    "the first of Prandtl's curves off its top": (
        tip_loss,
        "_largest_first",
        lambda low, _high: tip_loss._first(low),
        prandtls_factor_keeps_within_its_bounds,
    ),
}


@pytest.mark.parametrize("name", MUTANTS)
def test_a_bound_that_is_too_small_is_noticed(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    place, attribute, mutant, check = MUTANTS[name]
    monkeypatch.setattr(place, attribute, mutant)
    with pytest.raises(AssertionError):
        check()
