"""The compiled core, in the build that suits this processor.

An installation from source has one build, for its own processor.  A portable wheel has one for each
level of x86-64.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType
from typing import Any


def _suitable() -> ModuleType:
    try:
        return importlib.import_module("propmap._core")
    except ModuleNotFoundError as missing:
        if missing.name != "propmap._core":
            raise
    try:
        # The build of the oldest level runs wherever NumPy runs, and detects the best level.
        best = importlib.import_module("propmap._core_v2").best_instructions()
    except ModuleNotFoundError as missing:
        raise ImportError(
            "the compiled core of propmap was not found; run `pip install .` in the checkout"
        ) from missing
    return importlib.import_module(f"propmap._core_{best.removeprefix('x86-64-')}")


_build = _suitable()

HEADERS = Path(str(_build.__file__)).with_name("include")
"""The folder of the C++ headers of the core, installed with the build."""


def __getattr__(name: str) -> Any:
    return getattr(_build, name)
