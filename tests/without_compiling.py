"""The package with NumPy in the compiler's place, for tests of what lies above the engine.

That both give the same is held by ``tests/engine``: loads by ``test_without_compiling.py``,
derivatives by ``test_load_gradients.py``.  A program takes ten seconds to compile, and a point
some milliseconds by NumPy.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from propmap.engine.accuracy import ACCURACIES, Accuracy
from propmap.engine.differences import STEP, load_differences
from propmap.engine.evaluation import Prepared, prepare
from propmap.results import LoadGradients
from propmap.rotor import Rotor
from propmap.typing import Floats

FEW_NODES = Accuracy(
    ((0.12, 8), (np.inf, 12)),
    free=16,
    stalled=16,
    fast=16,
    largest_tail=np.inf,
    finer=((16, np.inf),),
)
"""Loads within some per cent, in a tenth of the time."""

SMALL = 1e-4
"""Step of these differences in the unit of the parameter: small beside any constant."""


def _by_differences(
    rotor: Prepared, setting: Accuracy, names: tuple[str, ...], *flow: Floats, alike: bool = False
) -> LoadGradients:
    """``load_gradients`` by differences, which may not be by the flow; all points are alike."""
    del alike
    return load_differences(rotor, setting, names, [SMALL / STEP] * len(names), *flow)


def compile_nothing(patch: pytest.MonkeyPatch) -> None:
    """Every rotor made from now on is one with ``compiled=False``, and so are its derivatives."""
    never: Any = property(lambda _: False, lambda *_: None)
    patch.setattr(Rotor, "compiled", never, raising=False)
    patch.setitem(prepare.__kwdefaults__, "compiled", False)
    patch.setattr("propmap.rotor.load_gradients", _by_differences)
    # A trim asks for derivatives, which it has no use for, to share a program with fits.
    patch.setattr("propmap.flight.trim.PAPER_FOUR", ())


def be_brief(patch: pytest.MonkeyPatch) -> None:
    """For what is about commands and not about numbers, from now on.

    ``standard`` means few nodes, fits end after few steps, and none looks for what it leaves out,
    see ``propmap.fit.added_parameter``.
    """
    patch.setitem(ACCURACIES, "standard", FEW_NODES)
    patch.setattr("propmap.fit.search.FINAL_EVALUATIONS", 8)
    patch.setattr("propmap.fit.added_parameter.POOR", np.inf)
