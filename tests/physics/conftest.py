"""Arrays of these tests are float64 unless a test says otherwise."""

from __future__ import annotations

from collections.abc import Iterator

import jax
import pytest


@pytest.fixture(autouse=True, scope="module")
def _double_precision() -> Iterator[None]:
    """Every array made by a test here is float64 unless the test says otherwise."""
    with jax.enable_x64(True):
        yield
