"""How the tests have the theory's programs compiled."""

from __future__ import annotations

import pytest

from propmap.engine.compilation import compile_quickly


def pytest_configure(config: pytest.Config) -> None:
    """As the command line does, which takes a seventh off `make test`.

    Tests run by hand, without a choice of marks, have them compiled as the library does; so has
    ``cli/test_compile_quickly.py`` those that compare with what is not compiled.
    """
    if config.option.markexpr in ("slow", "not slow"):
        compile_quickly()
