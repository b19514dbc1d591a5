"""The registry of loads, and those who must agree with it."""

from __future__ import annotations

import dataclasses

import pytest

from propmap import Loads, Model, Rotor, airfoil, correction, propeller
from propmap.loads import LOADS, Load, error_scales


def test_the_public_loads_begin_with_those_of_the_registry() -> None:
    names = [field.name for field in dataclasses.fields(Loads)]
    assert names[: len(LOADS)] == list(LOADS)


def test_names_in_files_and_figures_carry_the_unit() -> None:
    assert [load.column for load in LOADS.values()][:3] == ["thrust_N", "drag_N", "torque_Nm"]
    assert LOADS["thrust"].title == "thrust T [N]"
    assert LOADS["roll_moment"].title == "rolling moment [N m]"
    assert LOADS["roll_moment"].head == "roll"
    assert LOADS["roll_moment"].share == "rolling moment / (static thrust R)"


def test_errors_are_shares_of_a_static_load_of_their_own_dimension() -> None:
    scales = error_scales({"thrust": 3.0, "torque": 0.07}, radius=0.1)
    assert scales["thrust"] == scales["drag"] == 3.0
    assert scales["torque"] == 0.07
    assert scales["roll_moment"] == pytest.approx(0.3)


@pytest.mark.parametrize("load", LOADS.values(), ids=list(LOADS))
def test_loads_by_the_inplane_velocity_are_those_that_axial_flow_has_not(
    load: Load,
) -> None:
    rotor = Rotor(
        Model(
            propeller("apc-8x6e"),
            airfoil("paper-apc"),
            corrections=(correction("pitt-peters"),),
        ),
    )
    axial, oblique = (rotor.loads(500.0, 5.0, beta) for beta in (0.0, 1.0))
    assert (getattr(axial, load.name) == 0.0) == load.inplane
    assert abs(getattr(oblique, load.name)) > 0.0
