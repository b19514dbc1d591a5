"""Points that fill the envelope evenly, beside SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import qmc

from propmap.table.verification import sobol


@pytest.mark.parametrize(("count", "seed"), [(1, 0), (8192, 8192)])
def test_they_are_scipys(count: int, seed: int) -> None:
    np.testing.assert_array_equal(sobol(count, seed), qmc.Sobol(3, seed=seed).random(count))
