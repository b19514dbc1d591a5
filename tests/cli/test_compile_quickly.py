"""How the command line has its programs compiled, and the library."""

from __future__ import annotations

import importlib.metadata
import os
import subprocess
import sys
from pathlib import Path

import pytest

from propmap.compilation import KNOWN_JAXLIB, compile_quickly

TESTS = Path(__file__).parents[1]
COMPARISONS = ("engine/test_without_compiling.py", "solve/test_load_slopes.py")


def _flags(monkeypatch: pytest.MonkeyPatch, before: str = "", jaxlib: str = "") -> str:
    monkeypatch.setenv("XLA_FLAGS", before)
    version = jaxlib or f"{KNOWN_JAXLIB}99"
    monkeypatch.setattr(importlib.metadata, "version", lambda _: version)
    return os.environ["XLA_FLAGS"]


def test_other_flags_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    ours = _flags(monkeypatch)
    assert "xla_backend_extra_options" in ours
    assert _flags(monkeypatch, "--xla_dump_to=x").split() == ["--xla_dump_to=x", *ours.split()]


def test_options_of_the_user_take_precedence(monkeypatch: pytest.MonkeyPatch) -> None:
    theirs = "--xla_backend_extra_options=xla_cpu_optimize_for_size"
    assert _flags(monkeypatch, theirs) == theirs


def test_an_unknown_jaxlib_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    assert _flags(monkeypatch, jaxlib="1.0.0") == ""


@pytest.mark.slow
def test_loads_and_slopes_are_the_same_without_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """XLA has another way of emitting a loop as one function, so what the library's own setting
    compiles is compared with NumPy's results, and slopes with loads differentiated as they stand,
    once more."""
    assert importlib.metadata.version("jaxlib").startswith(KNOWN_JAXLIB)
    monkeypatch.delenv("XLA_FLAGS", raising=False)
    tests = [str(TESTS / name) for name in COMPARISONS]
    command = [sys.executable, "-m", "pytest", "-v", "-m", "slow or not slow", *tests]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:]
    assert " passed" in done.stdout
    assert " skipped" not in done.stdout
