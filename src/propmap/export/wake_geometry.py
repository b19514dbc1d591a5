"""What the rotors' wakes on each other depend on, besides the flight: tables for exported code.

The closed form of ``physics.vortex_cylinder`` stays as it is; distances between disks and rims,
which do not change with the flight, are tabulated, so that a node costs one division.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from propmap.arrays.types import Floats
from propmap.physics.vortex_cylinder import AZIMUTHS, CORE
from propmap.vehicle.interference import DISK_ANGLES, DISK_RADII, disk_frame
from propmap.vehicle.vehicle import Vehicle


@dataclass(frozen=True, eq=False)
class WakeGeometry:
    """Of the wakes of k rotors on each other.

    Attributes
    ----------
    frames : ndarray, shape (k, 3, 3)
        Rows: two directions in the disk, and the axis.
    kind : ndarray of int, shape (k, k)
        Of each target and source: which of the K kinds of pairs they are.
    tilts : ndarray, shape (k, k)
        Cosine between their axes [-].
    towards : ndarray, shape (k, k, 3)
        Unit vector from the source to the target in the plane of the source's disk.
    points : ndarray, shape (K, p, 3)
        Of the target's disk, in radii from the source, in the source's frame.
    rims : ndarray, shape (K, p, 2, a)
        Distance of each point to each node on the source's rim [radii], and the node's turning
        about the point over it.
    """

    frames: Floats
    kind: NDArray[np.intp]
    tilts: Floats
    towards: Floats
    points: Floats
    rims: Floats


def azimuths() -> tuple[Floats, Floats]:
    """Cosine and sine of the nodes on a rim, (a,) each."""
    psi = 2.0 * np.pi * (np.arange(AZIMUTHS) + 0.5) / AZIMUTHS
    return np.cos(psi), np.sin(psi)


def wake_geometry(vehicle: Vehicle) -> WakeGeometry:
    """The geometry of the rotors of a ``vehicle``."""
    mounts, radius = vehicle.mounts, vehicle.propeller.radius
    frames = np.stack([disk_frame(mount.axis) for mount in mounts])
    disk = DISK_RADII * np.stack([np.cos(DISK_ANGLES), np.sin(DISK_ANGLES), 0.0 * DISK_ANGLES])
    cosine, sine = azimuths()
    kind, towards = np.zeros((len(mounts),) * 2, int), np.zeros((len(mounts), len(mounts), 3))
    known: dict[bytes, int] = {}
    points: list[Floats] = []
    for t, target in enumerate(mounts):
        for s, source in enumerate(mounts):
            if t == s:
                continue
            apart = np.subtract(target.position, source.position)
            place = (apart / radius + disk.T @ frames[t]) @ frames[s].T
            # Pairs that lie alike, but for rounding, are one kind.
            key = (np.round(place, 12) + 0.0).tobytes()
            if key not in known:
                known[key] = len(points)
                points.append(place)
            kind[t, s] = known[key]
            beside = apart - (apart @ frames[s, 2]) * frames[s, 2]
            length = np.linalg.norm(beside)
            towards[t, s] = beside / (length if length > 1e-9 * radius else 1.0)
    places = np.stack(points)
    x, y, z = (places[..., k, None] for k in range(3))
    distance = np.sqrt((x - cosine) ** 2 + (y - sine) ** 2 + z**2 + CORE**2)
    rims = np.stack([distance, (1.0 - x * cosine - y * sine) / distance], axis=-2)
    tilts = frames[:, 2] @ frames[:, 2].T
    return WakeGeometry(frames, kind, tilts, towards, places, rims)
