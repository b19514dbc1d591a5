"""The model of a rotor: propeller, section law, air and corrections, as one value."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from propmap.errors import InputError
from propmap.loads import DRAG_FACTOR, MOUNT_AREA
from propmap.model.air import Air
from propmap.model.airfoil import SectionUncertainty
from propmap.model.corrections import (
    CORRECTIONS,
    INSTALLED,
    TYPICAL_FACTOR,
    BladeToHub,
    Correction,
    InflowShape,
    Installed,
    agreed,
    as_text,
    correction,
    name_of,
    split_mount,
)
from propmap.model.propeller import Propeller

OneOf = TypeVar("OneOf", bound=Correction)


@runtime_checkable
class Section(Protocol):
    """Interface of a section law: ``Airfoil``, ``SectionTable`` or your own class."""

    @property
    def name(self) -> str:
        """Name of the law."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the parameters with derivatives of the loads."""

    def core_law(self) -> dict[str, Any]:
        """Return the law in the form that the compiled core reads."""

    def metadata(self) -> dict[str, Any]:
        """Return texts and numbers by name, for files."""

    def fingerprint(self) -> str:
        """Return a SHA-256 hash of everything that determines lift and drag."""


@dataclass(frozen=True)
class Model:
    """The model of a rotor: everything that determines its loads.

    Attributes
    ----------
    propeller : Propeller
        Geometry.
    airfoil : Section
        Section law.
    air : Air
        Density and viscosity; by default those of the paper.
    corrections : tuple
        Terms beyond the physics of the paper, from ``propmap.correction``; at most one of each
        kind.  By default the corrections with which the constants of the airfoil were fitted, if
        known.  ``propmap.model_corrections("recommended")`` returns the default corrections of the
        commands.

    Raises
    ------
    InputError
        For arguments of a wrong type, a correction that does not fit the propeller, and corrections
        that differ from those of the fit of the constants.
    """

    propeller: Propeller
    airfoil: Section
    air: Air = field(default_factory=Air)
    corrections: tuple[Correction, ...] = ()

    def __post_init__(self) -> None:
        for name, kind, wanted in (
            ("propeller", Propeller, "a Propeller, from propmap.propeller(...)"),
            ("airfoil", Section, "an Airfoil, from propmap.airfoil(...)"),
            ("air", Air, "an Air, from propmap.Air(...)"),
        ):
            value = getattr(self, name)
            if not isinstance(value, kind):
                raise InputError(f"{name} is {value!r}: give {wanted}")
        object.__setattr__(self, "corrections", tuple(self.corrections))
        own = getattr(self.airfoil, "corrections", None)
        if own is not None:
            physics, mount = split_mount(self.correction_texts)
            texts = agreed(self.airfoil.name, own, [*(physics or split_mount(own)[0]), *mount])
            object.__setattr__(self, "corrections", tuple(correction(text) for text in texts))
        names = [name_of(value) for value in self.corrections]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"correction {name} is given twice: give it once")
        shapes = [name_of(one) for one in self.corrections if isinstance(one, InflowShape)]
        if len(shapes) > 1:
            found = f"{' and '.join(shapes)} both define the variation of the inflow over the disk"
            raise InputError(found, "give only one of them")
        for value in self.corrections:
            value.check(self)

    def with_airfoil(self, airfoil: Section) -> Model:
        """Return the model with another section law ``airfoil``."""
        return replace(self, airfoil=airfoil)

    def with_mount(self, mount: Correction) -> Model:
        """Return the model with the installation ``mount``, a correction ``installed``."""
        others = [value for value in self.corrections if name_of(value) != INSTALLED]
        return replace(self, corrections=(*others, mount))

    def with_correction(self, value: Correction) -> Model:
        """Return the model with ``value`` in place of its correction of this kind, if any.

        The section law gets the same corrections, as if it was fitted with them.
        """
        corrections = (*(one for one in self.corrections if type(one) is not type(value)), value)
        law: Any = self.airfoil
        if getattr(law, "corrections", None) is not None:
            law = replace(law, corrections=tuple(as_text(one) for one in corrections))
        return replace(self, airfoil=law, corrections=corrections)

    def correction_of(self, kind: type[OneOf]) -> OneOf | None:
        """Return the correction of this ``kind``, such as ``Installed``, or None."""
        return next((value for value in self.corrections if isinstance(value, kind)), None)

    @property
    def span(self) -> tuple[float, float]:
        """Radii at which the blade, extended by any ``BladeToHub``, begins and ends [m]."""
        to_hub = self.correction_of(BladeToHub)
        blade = self.propeller
        return (blade.root if to_hub is None else to_hub.hub(blade)), blade.radius

    @property
    def applied(self) -> tuple[Correction, ...]:
        """The corrections in the order in which they act, the order of ``CORRECTIONS``."""
        order = list(CORRECTIONS)
        return tuple(sorted(self.corrections, key=lambda one: order.index(name_of(one))))

    @property
    def uncertainty(self) -> SectionUncertainty | None:
        """Uncertainty of the section constants; None if it is not known."""
        known = getattr(self.airfoil, "uncertainty", None)
        filed = getattr(self.airfoil, "corrections", None) or ()
        mounts = [split_mount(list(texts))[1] for texts in (self.correction_texts, filed)]
        if known is not None and (not mounts[0] or mounts[0] != mounts[1]):
            # The covariance of a fitted mount does not apply to another mount or to bare blades.
            known = known.without(MOUNT_AREA).without(DRAG_FACTOR)
        return known

    @property
    def correction_texts(self) -> list[str]:
        """The corrections as texts for files and ``propmap.correction``."""
        return [as_text(value) for value in self.corrections]

    @property
    def law_title(self) -> str:
        """Names of the section law and the corrections, as in "paper-apc + tip-loss"."""
        return " + ".join([self.airfoil.name, *self.correction_texts])

    def reynolds(self, omega: ArrayLike, speed: ArrayLike, beta: ArrayLike) -> tuple[float, float]:
        """Return the range of Reynolds numbers along the blade at operating points.

        Compare this range with the Reynolds numbers of a ``SectionTable``: outside its Reynolds
        numbers, the table uses the nearest row.

        Parameters
        ----------
        omega, speed, beta : array_like
            Operating points as in ``Rotor.loads`` [rad/s], [m/s], [rad].

        Returns
        -------
        low, high : float
            Smallest and largest Reynolds number over all points.  At each point the range contains
            98 % of the integral of dynamic pressure times chord.  The induced velocity, which
            changes Re little, is neglected.
        """
        w, v, b = (np.ravel(a)[:, None, None] for a in np.broadcast_arrays(omega, speed, beta))
        y = np.linspace(*self.span, 61)[:, None]
        # Inside the first station, where loads are small, its chord is used.
        chord = np.interp(y, self.propeller.station, self.propeller.chord)
        psi = 2.0 * np.pi * np.arange(24) / 24
        flow = np.hypot(w * y + v * np.sin(b) * np.sin(psi), v * np.cos(b))
        re = (self.air.density / self.air.viscosity * flow * chord).reshape(flow.shape[0], -1)
        order = np.argsort(re, axis=1)
        weight = np.take_along_axis((flow**2 * chord).reshape(re.shape), order, axis=1)
        share = np.cumsum(weight, axis=1)
        inside = (share >= 0.01 * share[:, -1:]) & (share - weight <= 0.99 * share[:, -1:])
        kept = np.take_along_axis(re, order, axis=1)[inside]
        return float(kept.min()), float(kept.max())

    def fingerprint(self) -> str:
        """Return the SHA-256 hash of geometry, section law, air and corrections."""
        import hashlib

        parts = [
            self.propeller.fingerprint(),
            f"{type(self.airfoil).__qualname__} {self.airfoil.fingerprint()}",
            f"{self.air.density!r} {self.air.viscosity!r}",
            *sorted(self.correction_texts),
        ]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def installation_note(model: Model) -> str:
    """Return a sentence on the rotor drag: of bare blades, or of an installed rotor."""
    mount, radius = model.correction_of(Installed), model.propeller.radius
    if mount is None:
        return (
            "the rotor drag is that of bare blades; rotors on motors or stands have about "
            f"{TYPICAL_FACTOR[0]:g} times this drag, plus the drag of the parts in the slipstream "
            "(correction installed)"
        )
    unknown = mount.deviations(radius)
    factor, area = f"{mount.blade_factor:g}", f"{1e4 * mount.area(radius):.3g}"
    if DRAG_FACTOR in unknown:
        factor += f" (+- {unknown[DRAG_FACTOR]:g})"
    if MOUNT_AREA in unknown:
        area += f" (+- {1e4 * unknown[MOUNT_AREA]:.3g})"
    return (
        f"the rotor drag is that of the installed rotor: {factor} times the drag of the blades, "
        f"plus the drag of parts with a drag area of {area} cm^2 in the slipstream"
    )
