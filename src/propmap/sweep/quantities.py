"""What a sweep files of each operating point: names, units and meanings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from propmap.loads import LOADS
from propmap.model.airfoil import SOURCES
from propmap.results import STATUSES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from propmap.results import Loads

AXES = {
    "rpm": ("rpm", "1/min", "rotational speed"),
    "speed": ("speed_mps", "m/s", "speed of the hub through the air"),
    "beta": ("beta_deg", "degree", "angle from the axis to the velocity, 0 in axial climb"),
}
"""Of each dimension of a grid: its coordinate, unit and meaning."""

LOAD_TEXTS = {
    **{name: (load.unit, load.meaning) for name, load in LOADS.items()},
    "power": ("W", "shaft power"),
}

TEXTS = {
    **LOAD_TEXTS,
    "mean_inflow": ("m/s", "induced velocity averaged over the disk"),
    "reverse_flow": ("1", "share of the blades' disk that the air meets from behind"),
    "roots": ("1", "largest number of solutions of the inflow equation along the blade"),
}
"""Unit and meaning of each quantity that is no deviation."""

STATUS_ATTRIBUTES: dict[str, Any] = {
    "long_name": "whether the loads can be trusted",
    "flag_values": np.arange(len(STATUSES), dtype=np.uint8),
    "flag_meanings": " ".join(STATUSES),
}


def quantities(loads: Loads, *, bands: bool, by_source: bool) -> dict[str, NDArray[Any]]:
    """Arrays to file, by name, "thrust_std" and "thrust_std_tunnel" included; the status last.

    Parameters
    ----------
    loads : Loads
        Of any shape, which the arrays have too.
    bands, by_source : bool
        Whether standard deviations are among them, where the loads have any, and whether also by
        what they are from.
    """
    found: dict[str, NDArray[Any]] = {name: getattr(loads, name) for name in TEXTS}
    if bands and loads.std_by_source:
        told = {"std": loads.std}
        if by_source:
            told |= {f"std_{source}": one for source, one in loads.std_by_source.items()}
        for what, values in told.items():
            found |= {f"{name}_{what}": getattr(values, name) for name in LOAD_TEXTS}
    codes = [STATUSES.index(status) for status in loads.status.ravel().tolist()]
    found["status"] = np.array(codes, np.uint8).reshape(loads.status.shape)
    return found


def attributes(name: str) -> dict[str, Any]:
    """Unit and meaning of a quantity of ``quantities`` by its ``name``."""
    if name == "status":
        return dict(STATUS_ATTRIBUTES)
    load, _, source = name.partition("_std")
    unit, meaning = TEXTS[load]
    if load != name:
        meaning = f"standard deviation of: {meaning}"
    if source:
        meaning += f", by {source.removeprefix('_')} alone"
    assert source.removeprefix("_") in ("", *SOURCES)
    return {"units": unit, "long_name": meaning}


def filed_as(kind: np.dtype[Any]) -> np.dtype[Any]:
    """The type in which values of a ``kind`` are filed: numbers of solutions are small."""
    return np.dtype(np.uint8) if kind.kind in "iu" else kind
