"""A sweep as an xarray dataset: units, meanings, and where the figures come from."""

from __future__ import annotations

from typing import TYPE_CHECKING

import xarray

from propmap.sweep.points import AXES, attributes, quantities
from propmap.sweep.run import provenance

if TYPE_CHECKING:
    from propmap.results import Loads
    from propmap.rotor import Rotor
    from propmap.typing import Floats


def dataset(
    rotor: Rotor,
    axes: tuple[Floats, Floats, Floats],
    loads: Loads,
    command: str,
    *,
    bands: bool,
    by_source: bool,
) -> xarray.Dataset:
    """Loads (n,) over the axes rpm, speed [m/s] and beta [deg], beta fastest, with provenance.

    ``bands`` and ``by_source`` tell of which standard deviations there are, as in ``quantities``.
    """
    shape = tuple(axis.size for axis in axes)
    dims = tuple(AXES)
    coordinates = {
        name: (dim, values, {"units": unit, "long_name": meaning})
        for (dim, (name, unit, meaning)), values in zip(AXES.items(), axes, strict=True)
    }
    variables = {
        name: (dims, values.reshape(shape), attributes(name))
        for name, values in quantities(loads, bands=bands, by_source=by_source).items()
    }
    return xarray.Dataset(variables, coordinates, provenance(rotor, command))
