"""A model as the arrays that the solver works on: the one place that knows both."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from propmap.arrays.namespace import by_numpy
from propmap.physics import inflow_harmonics
from propmap.physics.blade_to_hub import continued_to
from propmap.physics.element import Medium
from propmap.physics.geometry import make_blade
from propmap.physics.mount_drag import Mounted
from propmap.physics.radial_friction import RadialFriction
from propmap.physics.rotor import RotorArrays
from propmap.physics.sections.blended import BlendedLaw
from propmap.physics.sections.compressible import CompressibleLaw
from propmap.physics.sections.law import SectionLaw, coefficients_at
from propmap.physics.sections.stall_delay import StallDelayLaw
from propmap.physics.sections.tabulated import tabulated_law
from propmap.physics.tip_loss import PrandtlLoss
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.model.model import Model

Applied = Callable[[RotorArrays, Any, Any], RotorArrays]

LEFT_OUT_WHERE_ZERO = ("reynolds_camber", "drag_angle")
"""Terms of the blended law that programs do without where they are zero, as in the paper."""


def rotor_arrays(model: Model) -> RotorArrays:
    """The ``model`` as arrays of NumPy float64."""
    p, number = model.propeller, np.float64
    blades: Any = (number(p.blades), number(p.root))
    with by_numpy():
        blade = make_blade(p.station, p.chord, p.twist, *blades)
    air: Any = (number(model.air.density), number(model.air.viscosity))
    rotor = RotorArrays(blade, section_law(model.airfoil), Medium(*air))
    for value in model.applied:
        own = getattr(value, "applied", None)  # of a correction of one's own
        rotor = own(rotor) if own else APPLIED[type(value).__name__](rotor, value, model)
    return rotor


def section_law(section: Any) -> SectionLaw:
    """An ``Airfoil``, a ``SectionTable`` or a section of one's own as arrays for the solver."""
    if hasattr(section, "law"):
        own: SectionLaw = section.law()
        return own
    return blended(section) if hasattr(section, "lift_law") else tabulated(section)


def blended(airfoil: Any) -> BlendedLaw:
    """The constants of an ``Airfoil`` as arrays."""
    attached = np.float64(1.0 if airfoil.lift_law == "blended" else 0.0)
    numbers: Any = {name: np.float64(getattr(airfoil, name)) for name in airfoil.parameters}
    numbers |= {name: None for name in LEFT_OUT_WHERE_ZERO if numbers[name] == 0.0}
    return BlendedLaw(attached=attached, **numbers)  # type: ignore[arg-type]


def tabulated(table: Any) -> SectionLaw:
    """The figures of a ``SectionTable`` as arrays."""
    figures = (table.angle, table.reynolds, table.lift, table.drag)
    return tabulated_law(*figures, drag_factor=table.drag_factor)


def section_coefficients(
    section: Any, alpha: ArrayLike, reynolds: ArrayLike
) -> tuple[Floats, Floats]:
    """C_L and C_D [-] of a section at angles [rad] from the chord line and Reynolds numbers."""
    at: Any = np.broadcast_arrays(np.asarray(alpha, np.float64), np.asarray(reynolds, np.float64))
    with by_numpy():
        found = coefficients_at(section_law(section), *at)
    shape = at[0].shape
    lift, drag = (np.array(np.broadcast_to(c, shape)) for c in (found.lift, found.drag))
    return lift, drag


def _to_hub(rotor: RotorArrays, value: Any, model: Any) -> RotorArrays:
    hub = value.hub(model.propeller)
    if hub >= float(rotor.blade.root):
        return rotor
    return rotor._replace(blade=continued_to(rotor.blade, hub))


def _untwisting(rotor: RotorArrays, value: Any, _: Any) -> RotorArrays:
    angle: Any = np.float64(value.tip_angle)
    return rotor._replace(blade=rotor.blade._replace(untwist=angle))


def _tip_loss(rotor: RotorArrays, _value: Any, _: Any) -> RotorArrays:
    return rotor._replace(factors=(*rotor.factors, PrandtlLoss()))


def _hub_loss(rotor: RotorArrays, value: Any, _: Any) -> RotorArrays:
    hub: Any = np.float64(value.radius(float(rotor.blade.root)))
    return rotor._replace(factors=(*rotor.factors, PrandtlLoss(hub)))


def _shaped(rotor: RotorArrays, value: Any, _: Any) -> RotorArrays:
    return rotor._replace(shape=getattr(inflow_harmonics, type(value).__name__)())


def _mounted(rotor: RotorArrays, value: Any, model: Any) -> RotorArrays:
    numbers: Any = (np.float64(value.area(model.propeller.radius)), np.float64(value.wake))
    return rotor._replace(mount=Mounted(*numbers))


def _stall_delay(rotor: RotorArrays, value: Any, _: Any) -> RotorArrays:
    strength: Any = np.float64(value.strength)
    return rotor._replace(law=StallDelayLaw(rotor.law, strength))


def _compressible(rotor: RotorArrays, value: Any, _: Any) -> RotorArrays:
    sound: Any = np.float64(value.sound_mps)
    return rotor._replace(law=CompressibleLaw(rotor.law, sound))


def _radial_friction(rotor: RotorArrays, _value: Any, _: Any) -> RotorArrays:
    return rotor._replace(added=(*rotor.added, RadialFriction()))


APPLIED: dict[str, Applied] = {
    "BladeToHub": _to_hub,
    "BladeUntwist": _untwisting,
    "TipLoss": _tip_loss,
    "HubLoss": _hub_loss,
    "PittPeters": _shaped,
    "PittPetersGradient": _shaped,
    "Coleman": _shaped,
    "Drees": _shaped,
    "WhiteBlake": _shaped,
    "MountDrag": _mounted,
    "StallDelay": _stall_delay,
    "PrandtlGlauert": _compressible,
    "RadialFriction": _radial_friction,
}
"""What each correction of ``propmap.model.corrections`` changes, by the name of its class."""
