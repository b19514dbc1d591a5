"""Hashes that tell whether a file of loads belongs to a propeller and a section law."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from propmap.model.airfoil import Airfoil
    from propmap.model.propeller import Propeller
    from propmap.model.section_table import SectionTable


def propeller_sha256(blade: Propeller) -> str:
    """SHA-256 of station [m], chord [m], twist [rad], root [m] and blades as little-endian f8."""
    figures = (blade.station, blade.chord, blade.twist, [blade.root, float(blade.blades)])
    return hashlib.sha256(np.concatenate(figures).astype("<f8").tobytes()).hexdigest()


def airfoil_sha256(section: Airfoil | SectionTable) -> str:
    """SHA-256 of the section law's parameter file, or of a table's figures as little-endian f8."""
    if hasattr(section, "to_toml"):
        return hashlib.sha256(section.to_toml().encode()).hexdigest()
    figures = (section.angle, section.reynolds, section.lift, section.drag)
    flat = np.concatenate([*(a.ravel() for a in figures), [section.drag_factor]])
    return hashlib.sha256(flat.astype("<f8").tobytes()).hexdigest()
