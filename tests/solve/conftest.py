"""Arrays of these tests are float64 unless a test says otherwise."""

from tests.physics.conftest import _double_precision

__all__ = ["_double_precision"]
