"""What may be free, fixed or believed, and refusals of what may not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from propmap.errors import InputError
from propmap.fit.least_squares import starts
from propmap.fit.parameters import EVERY, FIRST_GUESS, SECTION, Choice, Prior
from propmap.model.airfoil import Airfoil

CASES: dict[str, tuple[dict[str, Any], str]] = {
    "nothing free": ({"free": ()}, "no parameter is free; name one or more of c_l1"),
    "unknown, close": ({"free": ("c_l3",)}, "'c_l3' is not a parameter; choose from c_l"),
    "repeated": ({"free": ("c_l1", "c_d", "c_l1")}, "c_l1 is named twice as free"),
    "free and fixed": ({"fixed": {"c_l2": 1.0}}, "c_l2 is both free and fixed; choose one"),
    "prior not free": ({"priors": {"c_d0": Prior(0.01, 0.01)}}, "c_d0 has a prior but is not"),
    "no deviation": ({"priors": {"c_l2": Prior(2.0, 0.0)}}, "c_l2 has the standard deviation 0"),
    "fixed too low": ({"fixed": {"zero_lift_angle": -0.5}}, "from -0.25 to 0.15"),
    "start out of bounds": ({"start": {"alpha_0": 20.0}}, "alpha_0 is 20 rad; give a value"),
}


@pytest.mark.parametrize("case", CASES)
def test_refused(case: str) -> None:
    given, says = CASES[case]
    with pytest.raises(InputError) as caught:
        Choice(**given)
    assert says in str(caught.value)
    assert str(caught.value).isprintable()


def test_values_are_free_then_fixed_then_first_guesses() -> None:
    choice = Choice(("c_d", "c_l1"), {"c_d0": 0.02}, start={"c_l1": 5.0})
    np.testing.assert_array_equal(choice.first, [0.0, 5.0])
    values = choice.values(np.array([1.5, 5.5]))
    # A model keeps its mount where the area is neither free nor fixed.
    assert set(values) == set(FIRST_GUESS) and "mount_area" not in values
    for mounted in (Choice(("mount_area",)), Choice(("c_d",), {"mount_area": 0.002})):
        assert mounted.values(np.array([0.002]))["mount_area"] == 0.002
    assert (values["c_d"], values["c_l1"], values["c_d0"]) == (1.5, 5.5, 0.02)
    assert values["alpha_0"] == EVERY["alpha_0"].start
    assert all(type(value) is float for value in values.values())


def test_first_guesses_are_within_bounds_that_a_section_law_accepts() -> None:
    for name, p in EVERY.items():
        assert p.lower <= p.start <= p.upper and p.spread > 0.0, name
    law = Airfoil(5.0, 1.0, 1.0, 0.4)
    for name, p in SECTION.items():
        for value in (p.lower, p.upper):
            assert getattr(law.with_parameters(**{name: value}), name) == value


def test_starts_begin_at_the_first_guess_and_stay_within_bounds() -> None:
    choice = Choice()
    found = starts(choice, 50, seed=1)
    assert len(found) == 50
    np.testing.assert_array_equal(found[0], choice.first)
    table = np.array(found)
    assert (table >= choice.column("lower")).all() and (table <= choice.column("upper")).all()
    assert np.ptp(table, axis=0).min() > 0.1
    np.testing.assert_array_equal(table, starts(choice, 50, seed=1))
    assert (table[1] != starts(choice, 2, seed=2)[1]).any()


def test_what_flights_have_for_themselves_is_named_after_them() -> None:
    choice = Choice(("c_l1", "thrust_scale[171908]"), {"clock_offset[171908]": 0.02})
    assert choice.first[1] == EVERY["thrust_scale"].start
    assert choice.column("upper")[1] == EVERY["thrust_scale"].upper
    for wrong in ("c_l1[171908]", "thrust_scale[]", "thrust_scale[171908"):
        with pytest.raises(InputError, match="is not a parameter"):
            Choice((wrong,))
    with pytest.raises(InputError, match=r"give a value from -0\.1 to 0\.1"):
        Choice(("c_l1",), {"clock_offset[171908]": 0.2})
