"""What the tests of vehicles and logs share."""

from tests.io.conftest import written

__all__ = ["written"]
