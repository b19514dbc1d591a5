"""Measured loads that come with propmap, one TOML file each in ``measurements/``."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from importlib.resources import files

from propmap.arrays.types import Floats
from propmap.errors import InputError, quoted
from propmap.io.propeller_toml import float_array, parse_toml

SCHEMA = 1
SUFFIX = ".toml"


@dataclass(frozen=True, eq=False)
class Measurement:
    """Loads of one propeller at n operating points, as published.

    propeller : its name in the catalogue.
    kind : "measured" points, points "digitised" from a figure, or a published "fit".
    air_density : [kg/m^3].
    omega [rad/s], speed [m/s], beta [rad] : shape (n,), the operating points.
    thrust [N], torque [N m], drag [N], roll_moment [N m] : shape (n,), None where not given.
    note : what was done to the figures.  citation : whom to cite.
    """

    name: str
    propeller: str
    kind: str
    air_density: float
    note: str
    citation: str
    omega: Floats
    speed: Floats
    beta: Floats
    thrust: Floats | None
    torque: Floats | None
    drag: Floats | None
    roll_moment: Floats | None


def measurement_names() -> list[str]:
    """The names of all measurements, in alphabetical order."""
    folder = files("propmap.catalogue") / "measurements"
    return sorted(f.name.removesuffix(SUFFIX) for f in folder.iterdir() if f.name.endswith(SUFFIX))


def measurement(name: str) -> Measurement:
    """The measurement called ``name``, in upper or lower case; ``InputError`` if none is."""
    key, known = name.strip().lower(), measurement_names()
    if key not in known:
        close = difflib.get_close_matches(key, known, n=3, cutoff=0.3) or known
        raise InputError(
            f"{quoted(name)} is not a measurement of the catalogue",
            f"choose one of {', '.join(close)}",
        )
    where = f"measurement {key}"
    file = files("propmap.catalogue") / "measurements" / f"{key}{SUFFIX}"
    fields = parse_toml(file.read_text(encoding="utf-8"), where, SCHEMA)

    def required(column: str) -> Floats:
        array = float_array(fields[column], column, where)
        array.flags.writeable = False
        return array

    def optional(column: str) -> Floats | None:
        return required(column) if column in fields else None

    return Measurement(
        name=key,
        propeller=fields["propeller"],
        kind=fields["kind"],
        air_density=float(fields["air_density"]),
        note=fields["note"],
        citation=fields["citation"],
        omega=required("omega_rad_s"),
        speed=required("speed_m_s"),
        beta=required("beta_rad"),
        thrust=optional("thrust_N"),
        torque=optional("torque_Nm"),
        drag=optional("drag_N"),
        roll_moment=optional("roll_moment_Nm"),
    )
