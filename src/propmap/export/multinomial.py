"""Target ``multinomial``: the explicit polynomial of Gill & D'Andrea, Drones 2019, 3(4), 77.

With lambda_c = V cos(beta)/(Omega R) and mu = V sin(beta)/(Omega R), thrust and torque are
Omega^2 times a quadratic in lambda_c and, even, in mu; drag and roll moment are Omega^2 mu times
a line in lambda_c.  Multiplied out, no division by Omega and no root is left: thrust and torque
are quadratic forms of Omega and the velocity, and the drag is a smooth vector.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from propmap.arrays.types import Floats
from propmap.export.folder import Files
from propmap.export.note import note
from propmap.export.provenance import c_comment, hash_comment, identifier, provenance
from propmap.export.samples import SIMPLE, Samples, errors, sample
from propmap.table.query import LoadTable

Quadratic = tuple[float, float, float, float]
Linear = tuple[float, float]


@dataclass(frozen=True)
class Multinomial:
    """Loads over the density as forms of Omega, axial velocity z and in-plane velocity r.

    thrust : of Omega^2, Omega z, z^2, r^2 [m^4], [m^3], [m^2], [m^2]; torque : the same, times
    [m].  drag : of Omega r, z r [m^3], [m^2]; roll_moment : the same, times [m].
    """

    thrust: Quadratic
    drag: Linear
    torque: Quadratic
    roll_moment: Linear

    def loads(self, omega: Floats, axial: Floats, inplane: Floats, density: float) -> Floats:
        """Loads (n, 4) [N], [N m] at n points [rad/s], [m/s] in air of a density [kg/m^3]."""
        quadratic, linear = _terms(omega, axial, inplane)
        forms = (
            quadratic @ self.thrust,
            linear @ self.drag,
            quadratic @ self.torque,
            linear @ self.roll_moment,
        )
        return density * np.stack(forms, axis=-1)


def fit_multinomial(samples: Samples, density: float) -> Multinomial:
    """The least squares of the errors as shares of static loads, where simple models are meant."""
    chosen = samples.simple
    terms = _terms(samples.omega, samples.axial, samples.inplane)
    found = []
    for k in range(4):
        scale = 1.0 / samples.static[chosen, k]
        matrix = density * terms[k % 2][chosen] * scale[:, None]
        # Columns of one size: those of thrust are of Omega^2 and of V^2.
        size = np.sqrt((matrix**2).mean(axis=0))
        solved = np.linalg.lstsq(matrix / size, samples.loads[chosen, k] * scale, rcond=None)[0]
        found.append(tuple((solved / size).tolist()))
    return Multinomial(*found)


def files(table: LoadTable) -> Files:
    """The expressions in Python and C, and the note."""
    samples, density = sample(table), table.content.density
    fitted = fit_multinomial(samples, density)
    found = errors(samples, fitted.loads(samples.omega, samples.axial, samples.inplane, density))
    name = identifier(table)
    paragraphs = [
        "The multinomial of Gill & D'Andrea, Computationally Efficient Force and Moment Models "
        "for Propellers in UAV Forward Flight Applications, Drones 2019, 3(4), 77, fitted to the "
        f"map by least squares over {SIMPLE}. Its form cannot follow the fast descent, the vortex "
        "ring state, stall, or the Reynolds number.",
        f"{name}_multinomial.py is plain arithmetic: numbers, NumPy arrays and CasADi's SX, MX "
        f"and DM all go through. {name}_multinomial.h is the same in C99.",
    ]
    lines = provenance(table)
    return {
        f"{name}_multinomial.py": _python(fitted, density, lines),
        f"{name}_multinomial.h": _c(fitted, density, name, lines),
        "README-multinomial.txt": note(table, "multinomial", paragraphs, found),
    }


def _terms(omega: Floats, axial: Floats, inplane: Floats) -> tuple[Floats, Floats]:
    quadratic = np.stack([omega**2, omega * axial, axial**2, inplane**2], axis=-1)
    return quadratic, np.stack([omega * inplane, axial * inplane], axis=-1)


def _python(fitted: Multinomial, density: float, lines: list[str]) -> str:
    t, d, q, r = fitted.thrust, fitted.drag, fitted.torque, fitted.roll_moment
    return f'''"""Loads of a propeller as polynomials; see the note beside this file.

omega [rad/s] >= 0; x, y, z [m/s] : velocity of the hub through the air, z along the thrust;
rho [kg/m^3] : density of the air; spin : 1 counter-clockwise seen from above, -1 clockwise.
Numbers, NumPy arrays or CasADi expressions.
"""

{hash_comment(lines)}

RHO = {density!r}


def thrust(omega, x, y, z, rho=RHO):
    """[N]"""
    return rho * (
        {t[0]!r} * omega * omega
        + {t[1]!r} * omega * z
        + {t[2]!r} * z * z
        + {t[3]!r} * (x * x + y * y)
    )


def torque(omega, x, y, z, rho=RHO):
    """[N m], that turns the shaft"""
    return rho * (
        {q[0]!r} * omega * omega
        + {q[1]!r} * omega * z
        + {q[2]!r} * z * z
        + {q[3]!r} * (x * x + y * y)
    )


def drag_slope(omega, z, rho=RHO):
    """[N s/m]: drag over in-plane speed"""
    return rho * ({d[0]!r} * omega + {d[1]!r} * z)


def roll_slope(omega, z, rho=RHO):
    """[N s]: roll moment over in-plane speed"""
    return rho * ({r[0]!r} * omega + {r[1]!r} * z)


def force(omega, x, y, z, rho=RHO):
    """[N], on the vehicle at the hub: its x, y, z"""
    slope = drag_slope(omega, z, rho)
    return -slope * x, -slope * y, thrust(omega, x, y, z, rho)


def moment(omega, x, y, z, spin, rho=RHO):
    """[N m], on the vehicle at the hub: its x, y, z"""
    slope = roll_slope(omega, z, rho)
    return -spin * slope * x, -spin * slope * y, -spin * torque(omega, x, y, z, rho)
'''


def _c(fitted: Multinomial, density: float, name: str, lines: list[str]) -> str:
    guard = f"{name.upper()}_MULTINOMIAL_H"
    form = f"{name}_multinomial"

    def quadratic(load: str, unit: str, c: Quadratic) -> str:
        return f"""/* {unit} */
static inline double {form}_{load}(double rho, double omega,
                                   double x, double y, double z)
{{
    return rho * ({c[0]!r} * omega * omega
                  + {c[1]!r} * omega * z
                  + {c[2]!r} * z * z
                  + {c[3]!r} * (x * x + y * y));
}}
"""

    def linear(load: str, unit: str, c: Linear) -> str:
        return f"""/* {unit}: over in-plane speed */
static inline double {form}_{load}_slope(double rho, double omega, double z)
{{
    return rho * ({c[0]!r} * omega + {c[1]!r} * z);
}}
"""

    parts = (
        quadratic("thrust", "[N]", fitted.thrust),
        quadratic("torque", "[N m], that turns the shaft", fitted.torque),
        linear("drag", "Drag, against the in-plane velocity, [N s/m]", fitted.drag),
        linear("roll", "Roll moment, about the in-plane velocity, [N s]", fitted.roll_moment),
    )
    return f"""/* Loads of a propeller as polynomials; see the note beside this file.
 *
{c_comment(lines)}
 *
 * rho [kg/m^3], {density!r} in the map; omega [rad/s] >= 0; x, y, z [m/s]: velocity of the hub
 * through the air, z along the thrust.
 */
#ifndef {guard}
#define {guard}

{chr(10).join(parts)}
#endif
"""
