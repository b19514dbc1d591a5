"""Errors are what they are called, and the hover model is that of a static test."""

from __future__ import annotations

import numpy as np
import pytest

from papers.gill_dandrea_2017.tunnel import Compared, errors
from propmap.catalogue.lookup import Measurement


def _data(thrust: np.ndarray, torque: np.ndarray | None) -> Measurement:
    omega, speed = np.array([100.0, 200.0, 300.0]), np.array([0.0, 0.0, 5.0])
    nothing = np.zeros(3)
    loads = {"thrust": thrust} if torque is None else {"thrust": thrust, "torque": torque}
    return Measurement("d", "apc-8x6e", "measured", 1.2, "", "", omega, speed, nothing, loads)


def test_errors_of_a_load() -> None:
    truth = np.array([1.0, -4.0, 2.0])
    found = {"thrust": np.array([1.0, -3.7, 3.0])}
    one = Compared(_data(truth, None), {}, {"m": found})
    (error,) = errors({"set": one})
    assert (error.data_set, error.load, error.unit, error.points) == ("set", "thrust", "N", 3)
    assert error.rms == pytest.approx(np.sqrt((0.3**2 + 1.0) / 3.0))
    assert error.worst == pytest.approx(1.0)
    assert error.rms_share == pytest.approx(error.rms / np.sqrt(7.0))
    assert error.worst_share == pytest.approx(0.25)
    assert error.within_nine == pytest.approx(2.0 / 3.0)
