"""What the exports are tested with: packages of the extra `targets`, and compilers.

Where one is missing its tests are skipped, but in CI they fail.
"""

from __future__ import annotations

import importlib
import os
import shutil
from types import ModuleType
from typing import NoReturn

import pytest


def package(name: str) -> ModuleType:
    """A package, or the test ends here."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        _missing(f"{error}: install propmap[targets]")


def program(name: str) -> str:
    """The path of a compiler, or the test ends here."""
    found = shutil.which(name)
    if found is None:
        _missing(f"there is no {name}")
    return found


def _missing(what: str) -> NoReturn:
    if os.environ.get("CI"):
        pytest.fail(what)
    pytest.skip(what)
