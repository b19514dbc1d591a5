"""A section law from a function: sampled to a stated error, and used by a rotor."""

from __future__ import annotations

import numpy as np
import pytest

import propmap
from propmap.errors import InputError


def _plate(alpha, reynolds):
    return 1.1 * np.sin(2.0 * alpha), 2.0 * np.sin(alpha) ** 2 + 2.7 / np.sqrt(reynolds)


def test_the_table_is_as_close_as_it_says():
    table = propmap.SectionTable.from_function(_plate, [2e4, 5e4, 1e5], tolerance=1e-4)
    alpha = np.random.default_rng(0).uniform(-np.pi, np.pi, 2000)
    for reynolds in (2e4, 5e4, 1e5):
        lift, drag = table.coefficients(alpha, reynolds)
        wanted = _plate(alpha, reynolds)
        assert np.abs(lift - wanted[0]).max() < 1.5e-4
        assert np.abs(drag - wanted[1]).max() < 1.5e-4
    assert 0.0 < table.sampling_error < 2e-3  # friction between two Reynolds numbers


def test_a_jump_is_refused_with_its_place():
    def jumping(alpha, reynolds):
        lift, drag = _plate(alpha, reynolds)
        return np.where(alpha > 0.3, 0.5 * lift, lift), drag

    with pytest.raises(InputError, match=r"17\.\d+ deg"):
        propmap.SectionTable.from_function(jumping, [5e4])


def test_a_function_of_another_kind_is_refused():
    with pytest.raises(InputError, match="two arrays"):
        propmap.SectionTable.from_function(lambda *_: 0.0, [5e4])
