"""Target ``multinomial``: the explicit polynomial of Gill & D'Andrea, Drones 2019, 3(4), 77.

With lambda_c = V cos(beta)/(Omega R) and mu = V sin(beta)/(Omega R), thrust and torque are
Omega^2 times a quadratic in lambda_c and, even, in mu; drag and roll moment are Omega^2 mu times
a line in lambda_c.  Multiplied out, no division by Omega and no root is left: thrust and torque
are quadratic forms of Omega and the velocity, and the drag is a smooth vector.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from propmap.export.folder import Files
from propmap.export.note import note
from propmap.export.provenance import identifier
from propmap.export.samples import Samples, errors, sample
from propmap.export.template import rendered
from propmap.loads import LOADS
from propmap.table.query import LoadTable
from propmap.typing import Floats

Forms = Mapping[str, tuple[float, ...]]
"""By load, factors over the density of Omega^2, Omega z, z^2 and r^2; or, of loads by the in-plane
velocity, of Omega r and z r; z along the axis, r in the disk plane.  [m^4], [m^3], [m^2], for
moments times [m]."""


def multinomial_loads(forms: Forms, samples: Samples, density: float) -> dict[str, Floats]:
    """Loads (n,) [N], [N m] at the samples' points, in air of a density [kg/m^3]."""
    return {name: density * _terms(name, samples) @ forms[name] for name in LOADS}


def fit_multinomial(samples: Samples, density: float) -> Forms:
    """The least squares of the errors as shares of static loads, where simple models are meant."""
    chosen, found = samples.simple, {}
    for name in LOADS:
        scale = 1.0 / samples.static[name][chosen]
        matrix = density * _terms(name, samples)[chosen] * scale[:, None]
        # Columns of one size: those of thrust are of Omega^2 and of V^2.
        size = np.sqrt((matrix**2).mean(axis=0))
        target = samples.loads[name][chosen] * scale
        solved = np.linalg.lstsq(matrix / size, target, rcond=None)[0]
        found[name] = tuple((solved / size).tolist())
    return found


def files(table: LoadTable) -> Files:
    """The expressions in Python and C, and the note."""
    samples, density = sample(table), table.content.density
    forms = fit_multinomial(samples, density)
    found = errors(samples, multinomial_loads(forms, samples, density))
    name, values = f"{identifier(table)}_multinomial", {"forms": forms, "density": density}
    return {
        f"{name}.py": rendered("multinomial.py", table, **values),
        f"{name}.h": rendered("multinomial.h", table, **values),
        "README-multinomial.txt": note(table, "multinomial", found),
    }


def _terms(name: str, at: Samples) -> Floats:
    """What the factors of a load's form stand before, (n, 4) or (n, 2)."""
    if LOADS[name].inplane:
        return np.stack([at.omega * at.inplane, at.axial * at.inplane], axis=-1)
    return np.stack([at.omega**2, at.omega * at.axial, at.axial**2, at.inplane**2], axis=-1)
