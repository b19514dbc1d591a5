"""What all tests share."""

from __future__ import annotations

import signal

import pytest
from hypothesis import settings

# Tests must not depend on the load of the machine.
settings.register_profile("untimed", settings(deadline=None))
settings.load_profile("untimed")


def pytest_configure(config: pytest.Config) -> None:  # noqa: ARG001 - as pytest calls it
    """Processes that tests start have to hear Ctrl-C, also where tests run in the background."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
