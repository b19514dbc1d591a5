from __future__ import annotations

import runpy
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import propmap
from propmap.export import export_table
from propmap.loads import LOADS
from propmap.table import LoadTable, build_table
from propmap.table.interpolation import TableContent
from propmap.vehicle.vehicle import Vehicle

ENVELOPE = {"omega": (400.0, 800.0), "speed": (0.0, 6.0), "beta": (0.0, np.pi / 2)}
RADIUS = 0.1

Both = tuple[propmap.Rotor, LoadTable]


@pytest.fixture(scope="session")
def table() -> LoadTable:
    """A coarse table of the model, from hover to slow climb and edgewise flight."""
    model = propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))
    rotor = propmap.Rotor(model)
    return build_table(rotor, **ENVELOPE, tolerance=0.05, certificate_points=512)


@pytest.fixture(scope="session")
def oblique() -> Both:
    """A rotor with a side force and a pitching moment, and its table, good to 0.3 %."""
    corrections = (propmap.correction("pitt-peters"),)
    blade, law = propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")
    rotor = propmap.Rotor(propmap.Model(blade, law, corrections=corrections))
    return rotor, build_table(rotor, **ENVELOPE, tolerance=0.003, certificate_points=512)


@pytest.fixture(scope="session")
def invented() -> LoadTable:
    """A table of loads that a polynomial is, without a model behind it."""
    return LoadTable(invented_content())


def invented_content(
    *,
    name: str = "invented",
    speed: float = 0.0,
    beta: tuple[float, float] = (0.0, np.pi),
    gap: bool = False,
    of: Vehicle | None = None,
) -> TableContent:
    """Thrust and torque quadratic, drag and roll moment bilinear in lambda_c and mu.

    speed : the envelope's least [m/s].  gap : whether some knots have no value.
    of : vehicle whose propeller and air these are said to be.
    """
    advance = np.concatenate([np.linspace(0.0, 0.1, 12), np.linspace(0.11, 0.5, 14)])
    angle = np.linspace(*beta, 31)
    j, b = np.meshgrid(advance, angle, indexing="ij")
    climb, mu = j * np.cos(b), j * np.sin(b)
    known = {
        "thrust": 0.016 - 0.08 * climb - 0.05 * climb**2 + 0.02 * mu**2,
        "drag": mu * (0.006 + 0.01 * climb),
        "torque": 0.0025 - 0.002 * climb - 0.003 * climb**2 + 0.001 * mu**2,
    }
    low = np.stack([known.get(load, mu * (0.004 - 0.002 * climb)) for load in LOADS])
    coefficients = np.stack([low, low])
    cells = np.zeros((advance.size - 1, angle.size - 1), np.uint8)
    if gap:
        coefficients[:, :, 15:18, 20:25] = np.nan
        cells[3:6, 12:20], cells[8:10, 2:9] = 1, 2
    radius = RADIUS
    propeller = {"name": name, "blades": 3, "radius_m": radius, "geometry_sha256": "0"}
    air = {"density_kg_m3": 1.2, "viscosity_Pa_s": 1.8e-5}
    if of is not None:
        blade, radius = of.propeller, float(of.propeller.radius)
        propeller |= {"name": blade.name, "geometry_sha256": blade.fingerprint()}
        propeller |= {"blades": blade.blades, "radius_m": radius}
        air = {"density_kg_m3": of.air.density, "viscosity_Pa_s": of.air.viscosity}
    return TableContent(
        advance=advance,
        beta=angle,
        omega=np.array([200.0, 1000.0]),
        speed=np.array([speed, advance[-1] * 200.0 * radius]),
        coefficients=coefficients.astype(np.float32).astype(np.float64),
        cells=cells,
        info={"propeller": propeller, "air": air},
    )


def points(table: LoadTable, count: int) -> tuple[np.ndarray, ...]:
    """Points inside, on the envelope's borders, and beyond them."""
    rng = np.random.default_rng(0)
    low, high = np.array(list(table.envelope.values())).T
    unit = rng.uniform(-0.1, 1.1, (count, 3))
    border = rng.random((count, 3)) < 0.1
    found = low + (high - low) * unit
    ends = np.where(rng.random((count, 3)) < 0.5, low, high)
    found = np.where(border, ends, found)
    omega, speed, beta = found.T
    beta = np.where(rng.random(count) < 0.1, beta + 2.0 * np.pi, beta)
    return omega, speed, beta


Module = Callable[[LoadTable, str], SimpleNamespace]


@pytest.fixture
def module(tmp_path: Path) -> Module:
    """Export and run the Python file that was written; its names."""

    def make(table: LoadTable, target: str) -> SimpleNamespace:
        (path,) = (p for p in export_table(table, target, tmp_path / target) if p.suffix == ".py")
        return SimpleNamespace(**runpy.run_path(str(path)))

    return make


SPINS = {"ccw": 1, "cw": -1}
OMEGA = 600.0
VELOCITIES = np.array([[4.0, 2.0, 1.0], [-3.0, 3.5, 0.5], [1.0, -4.5, 2.0], [-5.0, -0.5, 0.3]])
"""Towards every quarter of the disk, within the envelope."""


def hub_wrench(rotor: propmap.Rotor, spin: str) -> np.ndarray:
    """Force and moment (n, 6) at ``VELOCITIES``, with all six loads at work."""
    found = rotor.wrench(OMEGA, VELOCITIES, spin)
    loads = rotor.loads_at_velocity(OMEGA, VELOCITIES)
    assert (loads.pitch_moment > 1e-4).all() and (abs(loads.side_force) > 1e-3).all()
    return np.concatenate([found.force, found.moment], axis=-1)


def share(got: np.ndarray, want: np.ndarray) -> np.ndarray:
    """Errors over thrust and thrust times radius."""
    scale = want[..., 2:3] * np.array([1.0, 1.0, 1.0, RADIUS, RADIUS, RADIUS])
    return np.asarray(abs(got - want) / scale)


def frame(mass: float) -> dict[str, Any]:
    """What RotorPy wants to know of a vehicle besides its rotors; these turn ccw, cw, ccw, cw."""
    corners = 0.2 * np.array([[1, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]])
    return {
        **{"mass": mass, "Ixx": 4e-3, "Iyy": 4e-3, "Izz": 7e-3},
        **dict.fromkeys(("Ixy", "Ixz", "Iyz", "c_Dx", "c_Dy", "c_Dz"), 0.0),
        "num_rotors": 4,
        "rotor_pos": {f"r{k}": corner for k, corner in enumerate(corners, 1)},
        "rotor_directions": np.array([-1, 1, -1, 1]),  # of the torque on the body
        "tau_m": 0.02,
    }
