"""Where the figures of a sweep come from."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

import propmap

if TYPE_CHECKING:
    from propmap.rotor import Rotor


def provenance(rotor: Rotor, command: str) -> dict[str, Any]:
    """Texts and numbers that files of loads carry.

    Parameters
    ----------
    rotor : Rotor
        Whose loads they are.
    command : str
        What was asked for.
    """
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
