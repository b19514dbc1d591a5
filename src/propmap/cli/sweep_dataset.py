"""A sweep as an xarray dataset: units, meanings, and where the figures come from."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray

import propmap
from propmap.loads import LOADS
from propmap.results import STATUSES, Loads
from propmap.rotor import Rotor

if TYPE_CHECKING:
    from propmap.arrays.types import Floats

AXES = {
    "rpm": ("rpm", "1/min", "rotational speed"),
    "speed": ("speed_mps", "m/s", "speed of the hub through the air"),
    "beta": ("beta_deg", "degree", "angle from the axis to the velocity, 0 in axial climb"),
}

VARIABLES = {
    **{name: (load.unit, load.meaning) for name, load in LOADS.items()},
    "power": ("W", "shaft power"),
    "mean_inflow": ("m/s", "induced velocity averaged over the disk"),
    "reverse_flow": ("1", "share of the blades' disk that the air meets from behind"),
    "roots": ("1", "largest number of solutions of the inflow equation along the blade"),
}


def dataset(
    rotor: Rotor,
    axes: tuple[Floats, Floats, Floats],
    loads: Loads,
    spread: Mapping[str, Floats],
    command: str,
) -> xarray.Dataset:
    """Loads (n,) over the axes rpm, speed [m/s] and beta [deg], beta fastest, with provenance.

    ``spread`` has their standard deviations by column, see ``io.operating_points.std_columns``.
    """
    shape = tuple(axis.size for axis in axes)
    dims = tuple(AXES)
    coordinates = {
        name: (dim, values, {"units": unit, "long_name": meaning})
        for (dim, (name, unit, meaning)), values in zip(AXES.items(), axes, strict=True)
    }
    variables = {
        name: (dims, getattr(loads, name).reshape(shape), {"units": unit, "long_name": meaning})
        for name, (unit, meaning) in VARIABLES.items()
    }
    for column, values in spread.items():
        load, _, rest = column.partition("_std_")
        *source, _ = rest.split("_")
        unit, meaning = VARIABLES[load]
        told = {"units": unit, "long_name": f"standard deviation of: {meaning}"}
        if source:
            told["long_name"] += f", by {source[0]} alone"
        variables["_".join((load, "std", *source))] = (dims, values.reshape(shape), told)
    codes = np.array([STATUSES.index(status) for status in loads.status.tolist()], np.uint8)
    flags = {
        "long_name": "whether the loads can be trusted",
        "flag_values": np.arange(len(STATUSES), dtype=np.uint8),
        "flag_meanings": " ".join(STATUSES),
    }
    found = xarray.Dataset(variables, coordinates, _provenance(rotor, command))
    found["status"] = (dims, codes.reshape(shape), flags)
    return found


def _provenance(rotor: Rotor, command: str) -> dict[str, Any]:
    blade = rotor.model.propeller
    section = {f"airfoil_{key}": value for key, value in rotor.model.airfoil.metadata().items()}
    return {
        "title": f"Loads of {blade.name}",
        "propmap_version": propmap.__version__,
        "method": "Gill & D'Andrea, Propeller Thrust and Drag in Forward Flight, CCTA 2017",
        "propeller": blade.name,
        "propeller_source": blade.source,
        "propeller_citation": blade.citation,
        "blades": blade.blades,
        "radius_m": blade.radius,
        "root_m": blade.root,
        "geometry_sha256": blade.fingerprint(),
        **section,
        "corrections": ", ".join(rotor.model.correction_texts) or "none",
        "air_density_kg_m3": rotor.model.air.density,
        "air_viscosity_Pa_s": rotor.model.air.viscosity,
        "model_sha256": rotor.model.fingerprint(),
        "accuracy": rotor.accuracy,
        "command": command,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
