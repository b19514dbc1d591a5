"""The study file in TOML."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.structs import asdict

from propmap.errors import InputError
from propmap.io.toml import Number, Text, TomlTable, checked, read_toml
from propmap.rotor import Rotor
from propmap.study.run import OPERATION, Study
from propmap.typing import Floats
from propmap.units import INCH

STUDY_SCHEMA = 1

KEYS = {
    "diameter_m": ("diameter", 1.0),
    "diameter_in": ("diameter", INCH),
    "pitch_m": ("pitch", 1.0),
    "pitch_in": ("pitch", INCH),
    **{name: (name, 1.0) for name in ("chord_scale", "twist_scale", "blades", *OPERATION)},
}  # keys of [vary]: name in ``VARIABLES``, and factor to its unit


Values = Annotated[Number | list[Number], "a number, or [...]"]


class _Points(TomlTable):
    rpm: Values | None = None
    speed_mps: Values | None = None
    beta_deg: Values | None = None


class _Vary(_Points):
    diameter_m: Values | None = None
    diameter_in: Values | None = None
    pitch_m: Values | None = None
    pitch_in: Values | None = None
    chord_scale: Values | None = None
    twist_scale: Values | None = None
    blades: Values | None = None


class _StudyPropeller(TomlTable):
    name: Annotated[Text, '"apc-8x6e"']
    airfoil: Annotated[str, '"paper-apc"'] = ""


class _Sampling(TomlTable):
    method: Literal["latin-hypercube", "full-factorial"]
    designs: Annotated[int, Meta(ge=0), "200"] | None = None
    seed: Annotated[int, Meta(ge=0), "1"] = 1

    def __post_init__(self) -> None:
        if self.method == "latin-hypercube" and self.designs is None:
            raise InputError("no designs", "add designs = 200")
        if self.method != "latin-hypercube" and self.designs is not None:
            found = "designs is given, but a full factorial always has all combinations"
            raise InputError(found, "remove designs, or give more values in [vary]")


class _StudyFile(TomlTable):
    propeller: _StudyPropeller
    sampling: _Sampling
    vary: dict[str, Any] = msgspec.field(default_factory=dict)  # a ``_Vary`` that keeps the order
    points: _Points = msgspec.field(default_factory=_Points)


@dataclass(frozen=True)
class StudyFile:
    """Content of a study file: names as on the command line, and the arguments of ``Study``."""

    propeller: str  # baseline design, as on the command line
    airfoil: str  # empty for the default section constants of the propeller
    varied: dict[str, Floats]
    axes: dict[str, Floats]
    designs: int | None
    seed: int

    def study(self, rotor: Rotor) -> Study:
        """Return the study, with ``rotor`` as the baseline design."""
        return Study(rotor, self.varied, self.axes, self.designs, self.seed)


def read_study(path: Path) -> StudyFile:
    """Read the file at ``path``; raise ``InputError`` with the wrong entry."""
    where = str(path)
    file = read_toml(path, _StudyFile, STUDY_SCHEMA, "study")
    given = asdict(checked(file.vary, _Vary, f"{where}: [vary]"))
    varied: dict[str, Floats] = {}
    for key in file.vary:
        name, unit = KEYS[key]
        if name in varied:
            found = f"{name} is given twice"
            raise InputError(found, "give it in meters or in inches", f"{where}: [vary]")
        varied[name] = unit * np.atleast_1d(np.asarray(given[key], np.float64))
    shared = {name: values for name, values in asdict(file.points).items() if values is not None}
    axes = {name: np.atleast_1d(np.asarray(v, np.float64)) for name, v in shared.items()}
    return StudyFile(
        propeller=file.propeller.name,
        airfoil=file.propeller.airfoil,
        varied=varied,
        axes=axes,
        designs=file.sampling.designs,
        seed=file.sampling.seed,
    )
