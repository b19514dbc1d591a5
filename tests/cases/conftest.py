"""Fixtures shared with the tests of commands."""

from tests.cli.conftest import _workplace, brief, run

__all__ = ["_workplace", "brief", "run"]
