"""Target ``jsbsim``: a propeller of thrust and power coefficients against J = V/(n D).

JSBSim's propeller has thrust and torque alone.  The four loads by the in-plane velocity are
external reactions: a line in Omega and the axial velocity, times the in-plane velocity, as in
``multinomial``.
"""

from __future__ import annotations

import numpy as np

from propmap.errors import InputError
from propmap.export.folder import Files
from propmap.export.multinomial import Forms, fit_multinomial, multinomial_loads
from propmap.export.note import note
from propmap.export.provenance import identifier
from propmap.export.samples import Samples, errors, middle_omega, sample
from propmap.export.template import rendered
from propmap.loads import LOADS
from propmap.table.query import LoadTable
from propmap.typing import Floats

METERS_PER_INCH = 0.0254
METERS_PER_FOOT = 0.3048
NEWTONS_PER_POUND = 4.4482216152605
KG_M3_PER_SLUG_FT3 = 515.378818393

POINTS = 121
"""Of the table.  JSBSim interpolates linearly: 1e-4 of the static coefficient between these."""


def coefficients(table: LoadTable) -> tuple[Floats, Floats, Floats]:
    """J, C_T = T/(rho n^2 D^4) and C_P = P/(rho n^3 D^5), (k,) each, rising J.

    With descent, J < 0, down to where the map has no values.  Each is taken at the middle omega,
    or at the largest that reaches that J within the envelope.
    """
    low, high = table.envelope["beta"]
    if low > 1e-9:
        raise InputError(
            f"the map's beta begins at {np.degrees(low):g} deg, without axial flight",
            "build it with --beta 0:...",
        )
    radius, (_, fastest) = table.content.radius, table.envelope["speed"]
    advance = np.linspace(0.0, float(table.content.advance[-1]), POINTS)
    parts = []
    for beta, sign in ((high, -1.0), (low, 1.0)):
        if sign < 0.0 and abs(beta - np.pi) > 1e-9:
            continue
        ratio = advance[:0:-1] if sign < 0.0 else advance
        reach = fastest / (np.maximum(ratio, 1e-12) * radius)
        # The largest advance ratio is met at one omega only, to rounding.
        omega = np.maximum(np.minimum(middle_omega(table), reach), table.envelope["omega"][0])
        found = table.loads(omega, np.minimum(ratio * omega * radius, fastest), beta)
        turns, diameter = omega / (2.0 * np.pi), 2.0 * radius
        force = table.content.density * turns**2 * diameter**4
        power = found.power / (force * turns * diameter)
        parts.append(np.stack([sign * np.pi * ratio, found.thrust / force, power]))
    each = np.concatenate(parts, axis=1)
    known = np.isfinite(each).all(axis=0)
    # What JSBSim would draw a line across is left out, with all beyond it.
    gaps = np.flatnonzero(~known & (each[0] < 0.0))
    each = each[:, gaps[-1] + 1 :] if gaps.size else each
    each = each[:, np.isfinite(each).all(axis=0)]
    return each[0], each[1], each[2]


def model_loads(table: LoadTable, samples: Samples, forms: Forms) -> dict[str, Floats]:
    """What JSBSim makes of the samples' velocities with these ``forms``, (n,) [N], [N m]."""
    thrust, torque = _axial_loads(table, samples.omega, samples.axial)
    across = multinomial_loads(forms, samples, table.content.density)
    found = {name: across[name] for name, load in LOADS.items() if load.inplane}
    return found | {"thrust": thrust, "torque": torque}


def files(table: LoadTable) -> Files:
    """The propeller's XML, that of the reactions across its axis, and the note."""
    samples = sample(table)
    forms = fit_multinomial(samples, table.content.density)
    found = errors(samples, model_loads(table, samples, forms))
    of_thrust, of_torque = axial_error(table)
    advance, thrust, power = coefficients(table)
    values = {"advance": advance, "thrust": thrust, "power": power}
    inches = 2.0 * table.content.radius / METERS_PER_INCH
    told = {"advance": advance, "of_thrust": of_thrust, "of_torque": of_torque}
    return {
        f"{identifier(table)}.xml": rendered("jsbsim.xml", table, inches=inches, **values),
        f"{identifier(table)}_reactions.xml": rendered(
            "jsbsim_reactions.xml", table, forms=forms, **_reaction_units()
        ),
        "README-jsbsim.txt": note(table, "jsbsim", found, **told),
    }


def _reaction_units() -> dict[str, float]:
    """Of the reactions' factors: density in slug/ft^3, a velocity in ft/s, force and moment in lbf
    and lbf ft."""
    per_pound = KG_M3_PER_SLUG_FT3 * METERS_PER_FOOT / NEWTONS_PER_POUND
    return {
        "per_lbs": per_pound,
        "per_lbsft": per_pound / METERS_PER_FOOT,
        "rad_s_per_rpm": np.pi / 30.0,
        "m_per_ft": METERS_PER_FOOT,
    }


def axial_error(table: LoadTable) -> tuple[float, float]:
    """Worst errors of thrust and torque in axial climb, as shares of static loads."""
    ends = (table.envelope["omega"], table.envelope["speed"])
    omega, speed = (
        x.ravel() for x in np.meshgrid(*(np.linspace(*end, 41) for end in ends), indexing="ij")
    )
    beta = table.envelope["beta"][0]
    expected, still = table.loads(omega, speed, beta), table.loads(omega, 0.0, beta)
    thrust, torque = _axial_loads(table, omega, speed)
    return (
        float(np.nanmax(abs(thrust - expected.thrust) / still.thrust)),
        float(np.nanmax(abs(torque - expected.torque) / still.torque)),
    )


def _axial_loads(table: LoadTable, omega: Floats, axial: Floats) -> tuple[Floats, Floats]:
    """JSBSim's thrust [N] and torque [N m] at n axial velocities, (n,)."""
    advance, thrust, power = coefficients(table)
    turns, diameter = omega / (2.0 * np.pi), 2.0 * table.content.radius
    ratio, force = axial / (turns * diameter), table.content.density * turns**2 * diameter**4
    arm = diameter / (2.0 * np.pi)
    return np.interp(ratio, advance, thrust) * force, np.interp(ratio, advance, power) * force * arm
