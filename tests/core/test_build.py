"""The compiled core is there, and is the build that suits this processor."""

from __future__ import annotations

from propmap import core


def test_core_is_the_build_for_this_processor() -> None:
    assert core.instructions() in ("native", "generic", core.best_instructions())
