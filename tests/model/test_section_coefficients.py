"""Lift and drag of a section by itself, by hand from eqs. (3) and (4) and from a table."""

from __future__ import annotations

import math

import numpy as np
import pytest

import propmap as pm

LAW = pm.Airfoil(c_l1=5.0, c_l2=2.0, c_d=1.5, alpha_0=0.35, zero_lift_angle=-0.05, drag_angle=0.07)


def test_attached_and_separated_lift_and_the_drag() -> None:
    alpha, reynolds = np.array([0.05, 1.0]), 6e4
    lift, drag = LAW.coefficients(alpha, reynolds)
    assert lift == pytest.approx([5.0 * 0.1, 2.0 * math.sin(1.05) * math.cos(1.05)], rel=1e-5)
    friction = 2.0 * 1.02 * 1.328 / math.sqrt(reynolds)
    assert drag == pytest.approx(1.5 * np.sin(alpha + 0.05 - 0.07) ** 2 + friction + 0.01)


def test_angles_and_reynolds_numbers_broadcast() -> None:
    lift, drag = LAW.coefficients(np.array([0.0, 0.1, 0.2]), np.array([[3e4], [9e4]]))
    assert lift.shape == drag.shape == (2, 3)
    assert (lift[0] == lift[1]).all() and (drag[0] > drag[1]).all()
    assert np.shape(LAW.coefficients(0.1, 5e4)[0]) == ()


def test_a_table_gives_its_figures() -> None:
    angle = np.radians(np.linspace(-180.0, 180.0, 73))
    figures = np.sin(2.0 * angle), 0.02 + np.sin(angle) ** 2
    table = pm.SectionTable(angle, np.array([5e4]), *(row[None] for row in figures))
    lift, drag = table.coefficients(angle[1:-1], 1e5)
    np.testing.assert_allclose(lift, figures[0][1:-1], atol=1e-12)
    np.testing.assert_allclose(drag, figures[1][1:-1], atol=1e-12)
