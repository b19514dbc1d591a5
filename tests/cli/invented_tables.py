"""Tables without a model behind them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from propmap.loads import LOADS
from propmap.table import LoadTable
from propmap.table.interpolation import TableContent


def invented(**more: Any) -> LoadTable:
    """Loads that grow with the advance ratio, without a model; ``more`` entries of ``info``."""
    advance, beta = np.linspace(0.0, 0.4, 9), np.linspace(0.0, np.pi, 9)
    first = np.linspace(0.016, 0.004, len(LOADS))
    inplane = [load.inplane for load in LOADS.values()]
    across = np.where(inplane, (advance[:, None] * np.sin(beta))[..., None], 1.0)
    loads = (first + advance[:, None, None]) * np.round(across, 15)
    return LoadTable(
        TableContent(
            advance=advance,
            beta=beta,
            omega=np.array([200.0, 1000.0]),
            speed=np.array([0.0, 8.0]),
            coefficients=np.stack(2 * [loads.transpose(2, 0, 1)]),
            cells=np.zeros((8, 8), np.uint8),
            info={
                "propeller": {"name": "invented", "radius_m": 0.1},
                "air": {"density_kg_m3": 1.2, "viscosity_Pa_s": 1.8e-5},
            }
            | more,
        )
    )


def without_figures(patch: pytest.MonkeyPatch) -> None:
    """Pages on tables are written without drawing, for tests of their words."""
    patch.setattr("propmap.report.html.FigureRecord.figure", lambda _: None)
    patch.setattr("propmap.report.html.as_svg", lambda _: b"<svg/>")


def certificate(unresolved_cells: int) -> dict[str, Any]:
    """A certificate that holds at 0.5 %, with some cells that have a bound of their own."""
    return {
        "tolerance": 0.005,
        "points": 4096,
        "seed": 1,
        "max_error": dict.fromkeys(LOADS, 0.0021),
        "rms_error": dict.fromkeys(LOADS, 0.0003),
        "unresolved": 40,
        "unresolved_cells": unresolved_cells,
        "unresolved_volume": 0.0098,
        "unresolved_points": 1020,
        "unresolved_max_error": dict.fromkeys(LOADS, 0.031),
        "unresolved_rms_error": dict.fromkeys(LOADS, 0.01),
        "vortex_ring": 300,
        "no_value": 0,
        "search_points": 26_000,
        "max_omega": dict.fromkeys(LOADS, 200.0 * np.pi),
        "max_speed": dict.fromkeys(LOADS, 7.25),
        "max_beta": dict.fromkeys(LOADS, 0.25 * np.pi),
    }
