from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.loads import LOADS
from propmap.table import LoadTable, build_table
from propmap.table.interpolation import TableContent

OMEGA = (400.0, 800.0)
SPEED = (0.0, 6.0)
BETA = (0.0, np.pi)
TOLERANCE = 0.03


@pytest.fixture(scope="session")
def rotor() -> propmap.Rotor:
    return propmap.Rotor(propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")))


@pytest.fixture(scope="session")
def table(rotor: propmap.Rotor) -> LoadTable:
    """A coarse table of the model, hover and slow flight in all directions."""
    return build_table(
        rotor,
        omega=OMEGA,
        speed=SPEED,
        beta=BETA,
        tolerance=TOLERANCE,
        certificate_points=2048,
    )


@pytest.fixture(scope="session")
def invented() -> LoadTable:
    """A smooth table without a model behind it, with the loads' symmetries."""
    return LoadTable(invented_content())


def invented_content() -> TableContent:
    radius = 0.1
    advance = np.linspace(0.0, 0.5, 26) ** 1.2
    beta = np.linspace(0.0, np.pi, 31)
    j, b = np.meshgrid(advance, beta, indexing="ij")
    thrust = 0.016 - 0.08 * j * np.cos(b) + 0.02 * j**2
    drag = 0.006 * j * np.sin(b) * (1.0 + j * np.cos(b))
    torque = 0.0025 - 0.002 * j * np.cos(b) - 0.003 * j**2 * np.cos(b) ** 2
    roll = 0.004 * j * np.sin(b)
    known = {"thrust": thrust, "drag": drag, "torque": torque}
    low = np.stack([known.get(name, roll) for name in LOADS])
    reynolds = {"thrust": 1.01, "torque": 0.95}
    high = low * np.array([reynolds.get(name, 1.0) for name in LOADS])[:, None, None]
    info = {
        "propeller": {"name": "invented", "radius_m": radius, "geometry_sha256": "0"},
        "air": {"density_kg_m3": 1.2, "viscosity_Pa_s": 1.8e-5},
    }
    return TableContent(
        advance=advance,
        beta=beta,
        omega=np.array([200.0, 1000.0]),
        speed=np.array([0.0, advance[-1] * 200.0 * radius]),
        coefficients=np.stack([low, high]).astype(np.float32).astype(np.float64),
        cells=np.zeros((advance.size - 1, beta.size - 1), np.uint8),
        info=info,
    )


def flagged_content() -> TableContent:
    """The invented table with cells of every flag, and a column of points without a value."""
    content = invented_content()
    cells, coefficients = content.cells.copy(), content.coefficients.copy()
    cells[:, :9], cells[:, 9:14], cells[5:9, 4:20] = 1, 2, 3
    coefficients[:, :, :, 20] = np.nan
    return replace(content, cells=cells, coefficients=coefficients)


def random_points(table: LoadTable, count: int, seed: int = 0) -> tuple[np.ndarray, ...]:
    low, high = np.array(list(table.envelope.values())).T
    unit = np.random.default_rng(seed).random((count, 3))
    return tuple((low + (high - low) * unit).T)


class OffRotor:
    """A rotor whose loads are off the table's by shares of static loads, which ``off`` returns."""

    def __init__(self, table: LoadTable, off: Callable[..., dict[str, np.ndarray]]) -> None:
        self.table, self.off = table, off
        self.model = SimpleNamespace(propeller=SimpleNamespace(radius=table.content.radius))

    def loads(self, omega: np.ndarray, speed: np.ndarray, beta: np.ndarray) -> Any:
        """Loads as of a rotor, all of them with the status "ok"."""
        found, still = self.table.loads(omega, speed, beta), self.table.loads(omega, 0.0, 0.0)
        advance = speed / (omega * self.table.content.radius)
        off = self.off(self.table.content, omega, advance, beta)
        values = {name: getattr(found, name) for name in LOADS}
        for name, share in off.items():
            values[name] = values[name] + share * (speed > 0.0) * getattr(still, name)
        return SimpleNamespace(**values, status=np.full(omega.shape, "ok"))
