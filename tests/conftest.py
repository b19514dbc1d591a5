"""How the tests have the theory's programs compiled, and where they are kept."""

from __future__ import annotations

import os
import signal

import pytest

from propmap.compilation import compile_quickly


def pytest_configure(config: pytest.Config) -> None:
    """As the command line does: compiled in less time, and kept for other processes.

    Processes that run beside each other, those that tests start and later runs find in pytest's
    cache folder, or in that of ``JAX_COMPILATION_CACHE_DIR``, what one of them has compiled.  JAX
    finds a program there by its whole text, the compiler's version and its options: what has
    changed is compiled again.

    Tests run by hand, without a choice of marks, have programs compiled as the library does; so has
    ``cli/test_compile_quickly.py`` those that compare with what is not compiled.
    """
    # Processes that tests start have to hear Ctrl-C, also where tests run in the background.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if config.option.markexpr in ("slow", "not slow"):
        compile_quickly()
    # JAX reads these when it is first imported, as do the processes that tests start.
    if getattr(config, "cache", None) is not None:
        folder = str(config.cache.mkdir("compiled"))
        os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", folder)
    os.environ.setdefault("JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS", "0.3")
