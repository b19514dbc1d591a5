"""Measured electrical power in a tunnel, on the half of the states that no constant has seen."""

from __future__ import annotations

import pytest

from benchmarks.aircraft import DATA, measured_power


@pytest.mark.slow
@pytest.mark.skipif(not DATA.exists(), reason="the reference data are not here")
def test_the_other_half_within_five_per_cent() -> None:
    """Rms error over rms power.  Relative errors, in which slow turning counts as much, are larger:
    6 to 8.2 % rms.  Without identification the constants to be expected are off by a quarter."""
    found = measured_power()
    for half in found["halves"]:
        assert half["states"] >= 10
        assert half["shaft"]["rms_of_rms"] < 0.05
        assert half["shaft"]["rms_relative"] < 0.085
        assert half["electrical_by_a_motor"]["rms_relative"] < half["shaft"]["rms_relative"]
    assert found["unfitted_shaft"]["rms_of_rms"] > 0.1
