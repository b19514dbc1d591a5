"""Where an export comes from, as lines for notes and comments."""

from __future__ import annotations

import hashlib
import re
import textwrap

import numpy as np

import propmap
from propmap.loads import LOADS
from propmap.table.query import LoadTable
from propmap.vehicle.vehicle import Vehicle

ABSENT = "not stated"


def identifier(table: LoadTable) -> str:
    """The propeller's name as one that programs and file systems accept."""
    name = re.sub(r"[^0-9a-z]+", "_", str(table.info["propeller"].get("name")).lower()).strip("_")
    return name if name[:1].isalpha() else f"prop_{name}".rstrip("_")


def vehicle_identifier(vehicle: Vehicle) -> str:
    """The name of a ``vehicle`` as one that file systems accept."""
    return re.sub(r"[^0-9a-z]+", "_", vehicle.name.lower()).strip("_") or "vehicle"


def vehicle_name(vehicle: Vehicle, table: LoadTable) -> str:
    """The same for programs, and another than that of the propeller of a ``table``."""
    name = vehicle_identifier(vehicle)
    name = name if name[0].isalpha() else f"vehicle_{name}"
    return f"{name}_vehicle" if name == identifier(table) else name


def map_sha256(table: LoadTable) -> str:
    """SHA-256 of the map's numbers: axes, envelope, coefficients and cells, little-endian."""
    content = table.content
    axes = (content.advance, content.beta, content.omega, content.speed)
    digest = hashlib.sha256(np.concatenate(axes).astype("<f8").tobytes())
    digest.update(content.coefficients.astype("<f4").tobytes())
    digest.update(content.cells.tobytes())
    return digest.hexdigest()


def provenance(table: LoadTable) -> list[str]:
    """Printable lines: where the map comes from, and what wrote the export."""
    return [*origin(table), f"written by propmap {propmap.__version__}"]


def origin(table: LoadTable) -> list[str]:
    """Printable lines: propeller, section law, corrections, air, envelope, certificate, map."""
    info, content = table.info, table.content
    blade, section = info["propeller"], info.get("airfoil") or {}
    (w0, w1), (v0, v1), (b0, b1) = table.envelope.values()
    rpm, degrees = 30.0 / np.pi, 180.0 / np.pi
    lines = [
        f"propeller: {blade.get('name', ABSENT)}, {blade.get('blades', ABSENT)} blades, "
        f"R = {content.radius:.6g} m, from {blade.get('source') or ABSENT}",
        f"section law: {section.get('name', ABSENT)}",
        f"corrections: {', '.join(info.get('corrections') or ['none'])}",
        f"air: {content.density:.6g} kg/m^3, viscosity "
        f"{info['air'].get('viscosity_Pa_s', ABSENT)} Pa s",
        f"envelope: {w0 * rpm:.6g} to {w1 * rpm:.6g} rpm, {v0:g} to {v1:g} m/s, "
        f"beta {b0 * degrees:.6g} to {b1 * degrees:.6g} deg",
        f"map: {_certified(table)}",
        *_of_parameters(table),
        f"map built: {info.get('created', ABSENT)}, propmap {info.get('propmap_version', ABSENT)}",
        f"map's SHA-256: {map_sha256(table)}",
    ]
    clean = ("".join(c if c.isprintable() else "?" for c in line) for line in lines)
    return [part for line in clean for part in textwrap.wrap(line, 88, subsequent_indent="  ")]


def _certified(table: LoadTable) -> str:
    found = table.certificate
    if not found:
        return "not certified"
    worst, loose = (max(found[key].values()) for key in ("max_error", "unresolved_max_error"))
    told = f"within {worst:.2%} of the model on {found['points']} points"
    if not found["unresolved_cells"]:
        return told
    return (
        f"{told}, and within {loose:.2%} on {found['unresolved_points']} points of the cells "
        f"marked unresolved, {found['unresolved_volume']:.2%} of the envelope"
    )


def _of_parameters(table: LoadTable) -> list[str]:
    """What the section law's covariance means for the loads, if the map says it."""
    found = table.info.get("parameter_uncertainty")
    if not found:
        return []
    each = (f"{LOADS[load].label} {share:.2%}" for load, share in found["median"].items())
    return [
        f"section law known to one standard deviation of: {', '.join(each)} of static, in the "
        "median over the envelope"
    ]
