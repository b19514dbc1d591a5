"""Standard deviations of the loads of a model, by source of the error.

The sources are independent.  The difference between specimens or runs is estimated from held-out
runs of UIUC's tunnel.  The error of the theory in oblique flow is estimated from campaigns in two
other tunnels.  The bands exclude errors of the force balance, and the difference of about 10 %
between static thrust on other test stands and in UIUC's tunnel.  ``python -m tools.coverage``
computes the numbers below, and coverage, width and score of the bands.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from propmap.loads import DRAG_FACTOR, LOADS, MOUNT_AREA
from propmap.model.airfoil import SectionCovariance, SectionUncertainty
from propmap.model.corrections import Installed
from propmap.model.model import Model
from propmap.operating_points import FlowPoints
from propmap.typing import Floats

SOURCES = ("parameters", "geometry", "discrepancy", "tunnel", "installation")

MEASURED_TO = 0.35  # advance ratio [-] up to which bands were compared with measurements

TUNNEL_GAIN = 0.015  # standard deviation of thrust and torque between specimens or runs [-]

OBLIQUE = {"thrust": 0.47, "torque": 0.30}
"""Standard deviation of the error of the theory in oblique flow, divided by the load and by the
advance ratio V sin(beta)/(Omega R) [-].  The values minimize the interval score over two campaigns
after removal of the balance errors."""

INPLANE = {"roll_moment": 0.35, "side_force": 0.28, "pitch_moment": 0.70}
"""Standard deviation of the loads that vanish in axial tests, divided by thrust times advance
ratio [-].  The moments are also divided by R."""

RING = 0.11
"""Standard deviation of thrust in the vortex ring state, as a fraction of the thrust.

It equals the rms error of three propellers in axial descent (Shetty & Selig, AIAA 2011-1254;
``tools.descent``)."""

NEAR_GROUND = 0.05
"""Standard deviation of thrust on the ground or at a ceiling, as a fraction of the thrust.

It decreases with the distance in proportion to the effect."""

BLADE_DRAG_SHARE = 0.10
"""Relative standard deviation of the drag of bare blades.  The drag is within about 20 % of a
free-wake lifting line, of Ribner's fin analogy and of measurements (docs/validation.md)."""


Derivatives = Callable[
    [Sequence[str]], Floats
]  # derivatives of the loads (L, P, N) with respect to the named parameters


def deviations(
    model: Model, at: FlowPoints, loads: Floats, derivatives: Derivatives
) -> dict[str, Floats]:
    """Return the standard deviations (L, N) of the loads (L, N) of a ``model`` by source.

    They are first-order estimates sqrt(g' S g), where g are the derivatives of a load and S is the
    covariance of the uncertain parameters.
    """
    known = model.uncertainty
    if known is None:
        return {}
    return _by_parameters(known, derivatives) | errors_of_loads(model, at, loads)


def errors_of_loads(model: Model, at: FlowPoints, loads: Floats) -> dict[str, Floats]:
    """Return standard deviations (L, N) by source, except section constants and blade."""
    known = model.uncertainty
    if known is None:
        return {}
    found = {"discrepancy": _discrepancy(model, known, at, loads)}
    if known.another_tunnel:
        found["tunnel"] = _tunnel(loads)
    mount = model.correction_of(Installed)
    if mount is not None:
        found["installation"] = _installation(model, mount, at, loads)
    return found


def _by_parameters(known: SectionUncertainty, derivatives: Derivatives) -> dict[str, Floats]:
    """Return the standard deviations (L, N) from uncertain section constants and blade."""
    whole = known.covariance.determined
    if not whole.names:
        return {}
    slopes = derivatives(whole.names)

    def variance(of: SectionCovariance) -> Floats:
        return np.maximum(np.einsum("lpn,pq,lqn->ln", slopes, of.matrix, slopes), 0.0)

    if known.with_blade is None:
        return {"parameters": np.sqrt(variance(whole))}
    # The covariances with and without a measured blade are estimated separately, so the first may
    # exceed the second.  The variance of the section constants is therefore limited to the total;
    # the rest of the total is the variance of the geometry.
    total = variance(whole)
    own = np.minimum(variance(known.with_blade), total)
    return {"parameters": np.sqrt(own), "geometry": np.sqrt(total - own)}


def _discrepancy(model: Model, known: SectionUncertainty, at: FlowPoints, loads: Floats) -> Floats:
    """Return the standard deviations (L, N) of the errors of the model with the best constants."""
    blade, air = model.propeller, model.air
    # The loads of a slow rotor in wind scale with the wind instead of the rotation.
    square = at.omega**2 + (at.v_axial**2 + at.v_inplane**2) / blade.radius**2
    force = air.density * square / (2.0 * np.pi) ** 2 * blade.diameter**4
    advance = _advance(model, at)
    by_name = dict(zip(LOADS, loads, strict=True))
    size = np.abs(by_name["thrust"]) * advance
    found = {name: share * size for name, share in INPLANE.items()}
    for name in ("roll_moment", "pitch_moment"):
        found[name] = found[name] * blade.radius
    found["drag"] = BLADE_DRAG_SHARE * np.abs(by_name["drag"])
    axial = {
        "thrust": known.thrust_coefficient * force,
        "torque": known.power_coefficient / (2.0 * np.pi) * force * blade.diameter,
    }
    for name, own in axial.items():
        share = OBLIQUE[name] * np.maximum(advance - _fitted_to(known), 0.0)
        found[name] = np.hypot(own, share * np.abs(by_name[name]))
    # The decay lengths of both effects are those in ground_effect.hpp.
    ground = NEAR_GROUND * np.exp(-at.height / (0.686 * blade.radius))
    ground = np.hypot(ground, NEAR_GROUND * np.exp(-at.ceiling / (1.61 * blade.radius)))
    share = np.hypot(ground, RING * _ring(model, at, by_name["thrust"]))
    found["thrust"] = np.hypot(found["thrust"], share * np.abs(by_name["thrust"]))
    return np.stack([found[name] for name in LOADS])


def _fitted_to(known: SectionUncertainty) -> float:
    """Return the largest advance ratio of the fitted data, defined as in ``_advance``.

    Up to this ratio, the residuals of the fit contain the error of the theory in oblique flow.  The
    ratio is 0 for constants from another tunnel, and infinite for a fit without a known envelope.
    """
    if known.another_tunnel:
        return 0.0
    if known.envelope is None:
        return np.inf
    fitted = known.envelope.edgewise_ratio[1]
    return float(fitted / np.hypot(1.0, fitted))


def _ring(model: Model, at: FlowPoints, thrust: Floats) -> Floats:
    """Return a weight (N,) of the vortex ring state.

    The weight is 1 for axial descent at 0.5 to 1.4 times the hover inflow, and 0 at twice or more.
    """
    hover = np.sqrt(np.abs(thrust) / (2.0 * model.air.density * np.pi * model.propeller.radius**2))
    hover = np.maximum(hover, 1e-9)
    descent = -at.v_axial / hover
    axial = np.clip(2.0 * descent, 0.0, 1.0) * np.clip((2.0 - descent) / 0.6, 0.0, 1.0)
    return np.asarray(axial / (1.0 + (at.v_inplane / hover) ** 2))


def _tunnel(loads: Floats) -> Floats:
    """Return the standard deviations (L, N) between specimens or runs."""
    gain = [[TUNNEL_GAIN * (name in ("thrust", "torque"))] for name in LOADS]
    return np.asarray(gain * np.abs(loads))


def _installation(model: Model, mount: Installed, at: FlowPoints, loads: Floats) -> Floats:
    """Return the standard deviations (L, N) from unspecified properties of the installation."""
    by_name = dict(zip(LOADS, loads, strict=True))
    radius, density = model.propeller.radius, model.air.density
    inflow = _glauert_inflow(by_name["thrust"] / (2.0 * density * np.pi * radius**2), at)
    speed = np.hypot(at.v_inplane, at.v_axial + mount.wake * inflow)
    per_area = 0.5 * density * at.v_inplane * speed
    blades = np.abs(by_name["drag"] - mount.area(radius) * per_area)
    slopes = {DRAG_FACTOR: blades / max(mount.blade_factor, 1e-9), MOUNT_AREA: per_area}
    unknown = mount.deviations(radius)
    found = np.zeros_like(loads)
    found[list(LOADS).index("drag")] = np.sqrt(
        sum(((unknown[name] * slopes[name]) ** 2 for name in unknown), start=0.0 * blades)
    )
    return found


def _advance(model: Model, at: FlowPoints) -> Floats:
    """Return V sin(beta) divided by the resultant of tip speed and V sin(beta) [-] (N,)."""
    tip = np.hypot(at.omega * model.propeller.radius, at.v_inplane)
    return np.divide(at.v_inplane, tip, out=np.zeros_like(tip), where=tip > 0.0)


def _glauert_inflow(square: Floats, at: FlowPoints) -> Floats:
    """Return the inflow (N,) [m/s] of (10) for the disk; ``square`` is T/(2 rho A) [m^2/s^2]."""
    v = np.sqrt(np.abs(square))
    for _ in range(30):
        speed = np.hypot(at.v_inplane, at.v_axial + v)
        v = 0.5 * (v + np.sign(square) * np.abs(square) / np.maximum(speed, 1e-9))
        v = np.clip(v, -np.sqrt(np.abs(square)) * 3.0, np.sqrt(np.abs(square)) * 3.0)
    return v
