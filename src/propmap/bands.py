"""Standard deviations of a rotor's loads, by what they are from."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from propmap.loads import LOADS
from propmap.model.airfoil import (
    INPLANE_SHARES,
    TUNNEL_GAIN,
    TUNNEL_TILT,
    UNKNOWN_SHARE,
    SectionCovariance,
    SectionUncertainty,
)
from propmap.model.model import Model
from propmap.operating_points import FlowPoints
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.rotor import Rotor


def load_deviations(rotor: Rotor, at: FlowPoints, loads: Floats) -> dict[str, Floats]:
    """Standard deviations (L, N) of the loads (L, N) by source, for each of ``SOURCES`` that is
    known.

    To first order: sqrt(g' S g) with g the derivatives by uncertain parameters and S their
    covariance; NaN where the derivatives were not found.
    """
    model = rotor.model
    known = model.uncertainty
    if known is None:
        return {}
    return _by_parameters(known, rotor, at) | errors_of_loads(model, at, loads)


def errors_of_loads(model: Model, at: FlowPoints, loads: Floats) -> dict[str, Floats]:
    """Standard deviations of the loads themselves, not of what they rest on; see
    ``load_deviations``."""
    known = model.uncertainty
    if known is None:
        return {}
    found = {"discrepancy": _discrepancy(model, known, at, loads)}
    if known.another_tunnel:
        found["tunnel"] = _tunnel(model, at, loads)
    return found


def _by_parameters(known: SectionUncertainty, rotor: Rotor, at: FlowPoints) -> dict[str, Floats]:
    """Standard deviations (L, N) that follow from the uncertain constants and blade."""
    whole = known.covariance.determined
    if not whole.names:
        return {}
    slopes = rotor.gradients_at(whole.names, at).slopes

    def variance(of: SectionCovariance) -> Floats:
        return np.maximum(np.einsum("lpn,pq,lqn->ln", slopes, of.matrix, slopes), 0.0)

    if known.with_blade is None:
        return {"parameters": np.sqrt(variance(whole))}
    # The two populations are estimated apart: their sum is to be the whole all the same.
    total = variance(whole)
    own = np.minimum(variance(known.with_blade), total)
    return {"parameters": np.sqrt(own), "geometry": np.sqrt(total - own)}


def _discrepancy(model: Model, known: SectionUncertainty, at: FlowPoints, loads: Floats) -> Floats:
    """Errors (L, N) of the model with the best constants."""
    blade, air = model.propeller, model.air
    # In a wind a rotor that turns slowly has the loads of the wind.
    square = at.omega**2 + (at.v_axial**2 + at.v_inplane**2) / blade.radius**2
    force = air.density * square / (2.0 * np.pi) ** 2 * blade.diameter**4
    of_axial = {
        "thrust": known.thrust_coefficient * force,
        "torque": known.power_coefficient / (2.0 * np.pi) * force * blade.diameter,
    }
    return np.stack(
        [
            of_axial[name]
            if name in of_axial
            else INPLANE_SHARES.get(name, UNKNOWN_SHARE) * np.abs(load)
            for name, load in zip(LOADS, loads, strict=True)
        ]
    )


def _tunnel(model: Model, at: FlowPoints, loads: Floats) -> Floats:
    """Differences (L, N) between the loads that several tunnels, or the open air, would read."""
    tip = np.hypot(at.omega * model.propeller.radius, np.hypot(at.v_axial, at.v_inplane))
    speed = np.hypot(at.v_axial, at.v_inplane)
    advance = np.divide(speed, tip, out=np.zeros_like(tip), where=tip > 0.0)
    share = np.full_like(loads, TUNNEL_GAIN)
    share[list(LOADS).index("thrust")] = np.hypot(TUNNEL_GAIN, TUNNEL_TILT * advance)
    return np.asarray(share * np.abs(loads))
