"""A section law around another one: what corrections of lift and drag are made of."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

from jax.tree_util import register_dataclass

from propmap.arrays.namespace import Array
from propmap.physics.sections.law import Coefficients, LawBounds, SectionFlow, SectionLaw


@register_dataclass
@dataclass(frozen=True)
class WrappedLaw:
    """A law with the angles and the parameters of the one in it; a pytree.

    Attributes
    ----------
    law : SectionLaw
        The law in it.
    """

    law: SectionLaw

    def zero_lift_at(self, reynolds: Array) -> Array:
        """That of the law in it [rad]; ``reynolds`` as in ``SectionLaw``."""
        return self.law.zero_lift_at(reynolds)

    @property
    def least_drag_angle(self) -> Array | None:
        """That of the law in it [rad]."""
        return self.law.least_drag_angle

    @property
    def drag_factor(self) -> Array | float:
        """That of the law in it [-]."""
        return self.law.drag_factor

    @property
    def parameters(self) -> tuple[str, ...]:
        """Those of the law in it."""
        return self.law.parameters

    def plus(self, **changes: Array) -> Self:
        """The law with ``changes`` added to the parameters of the one in it."""
        return replace(self, law=self.law.plus(**changes))

    def coefficients(self, flow: SectionFlow) -> Coefficients:
        """C_L, C_D and their derivatives in this ``flow``."""
        return self.law.coefficients(flow)

    def attached_share(self, angle: Array) -> Array:
        """That of the law in it [-]; ``angle`` is from zero lift [rad]."""
        return self.law.attached_share(angle)

    def stall_angle(self, reynolds: Array, side: Array) -> Array:
        """That of the law in it [rad], with ``reynolds`` and ``side`` as in ``SectionLaw``."""
        return self.law.stall_angle(reynolds, side)

    def bounds(self) -> LawBounds:
        """Bounds on the coefficients."""
        return self.law.bounds()
