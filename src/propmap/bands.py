"""How far the loads of a model may err, by what the errors are from: standard deviations.

Sources are independent of each other.  What is not a model's own, how wind tunnels differ and how
the theory fails in oblique flow, is estimated from campaigns in other tunnels than that of the
catalogue's constants: ``python -m tools.coverage`` finds the numbers below, and what bands hold.
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

TUNNEL_GAIN = 0.04  # of thrust and torque as shares, of another specimen or in another run [-]

OBLIQUE = {"thrust": 1.03, "torque": 1.38}
"""Standard deviations of what the theory errs by in oblique flow, as shares of the load per advance
ratio V sin(beta)/(Omega R) [-]: those of the campaign that errs more."""

INPLANE = {"roll_moment": 0.47, "side_force": 0.44, "pitch_moment": 0.70}
"""Standard deviations of loads that no axial test has seen, over thrust times advance ratio, and
times R for moments [-]."""

BLADE_DRAG_SHARE = 0.10
"""Standard deviation of the drag of bare blades as a share: it is within about 20 % of a free-wake
lifting line, of Ribner's fin analogy and of measurements (docs/validation.md)."""


Derivatives = Callable[
    [Sequence[str]], Floats
]  # of the loads (L, P, N) by parameters of these names


def deviations(
    model: Model, at: FlowPoints, loads: Floats, derivatives: Derivatives
) -> dict[str, Floats]:
    """Return the standard deviations (L, N) of the loads (L, N) of a ``model`` by source.

    They are first-order estimates sqrt(g' S g), with the derivatives g of the loads and the
    covariance S of the uncertain parameters.
    """
    known = model.uncertainty
    if known is None:
        return {}
    return _by_parameters(known, derivatives) | errors_of_loads(model, at, loads)


def errors_of_loads(model: Model, at: FlowPoints, loads: Floats) -> dict[str, Floats]:
    """Standard deviations (L, N) by source of loads (L, N), not of section constants and blade."""
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
    """Standard deviations (L, N) that follow from the uncertain constants and blade."""
    whole = known.covariance.determined
    if not whole.names:
        return {}
    slopes = derivatives(whole.names)

    def variance(of: SectionCovariance) -> Floats:
        return np.maximum(np.einsum("lpn,pq,lqn->ln", slopes, of.matrix, slopes), 0.0)

    if known.with_blade is None:
        return {"parameters": np.sqrt(variance(whole))}
    # The two populations are estimated separately; their sum has to be the whole.
    total = variance(whole)
    own = np.minimum(variance(known.with_blade), total)
    return {"parameters": np.sqrt(own), "geometry": np.sqrt(total - own)}


def _discrepancy(model: Model, known: SectionUncertainty, at: FlowPoints, loads: Floats) -> Floats:
    """Errors (L, N) of the model with the best constants."""
    blade, air = model.propeller, model.air
    # In a wind a rotor that turns slowly has the loads of the wind.
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
        # Constants that rest on data of this flow have met what it does.
        share = OBLIQUE[name] * advance if known.another_tunnel else 0.0 * advance
        found[name] = np.hypot(own, share * np.abs(by_name[name]))
    return np.stack([found[name] for name in LOADS])


def _tunnel(loads: Floats) -> Floats:
    """Differences (L, N) between the loads that several tunnels, or the open air, would read."""
    gain = [[TUNNEL_GAIN if name in ("thrust", "torque") else 0.0] for name in LOADS]
    return np.asarray(gain * np.abs(loads))


def _installation(model: Model, mount: Installed, at: FlowPoints, loads: Floats) -> Floats:
    """Errors (L, N) for what is not stated of how the rotor is installed."""
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
    """V sin(beta) over the speed of the tip [-] (N,); below 1 where the rotor stands in a wind."""
    tip = np.hypot(at.omega * model.propeller.radius, at.v_inplane)
    return np.divide(at.v_inplane, tip, out=np.zeros_like(tip), where=tip > 0.0)


def _glauert_inflow(square: Floats, at: FlowPoints) -> Floats:
    """The inflow (N,) [m/s] of (10) for the whole disk, from ``square``, T/(2 rho A) [m^2/s^2]."""
    v = np.sqrt(np.abs(square))
    for _ in range(30):
        speed = np.hypot(at.v_inplane, at.v_axial + v)
        v = 0.5 * (v + np.sign(square) * np.abs(square) / np.maximum(speed, 1e-9))
        v = np.clip(v, -np.sqrt(np.abs(square)) * 3.0, np.sqrt(np.abs(square)) * 3.0)
    return v
