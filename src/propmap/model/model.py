"""A propeller, a section law, air and corrections: all that loads depend on."""

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
    """What a model's section law must have: ``Airfoil``, ``SectionTable`` or your own."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of what loads can be differentiated by."""

    def core_law(self) -> dict[str, Any]:
        """Give the law as the compiled core takes it."""

    def metadata(self) -> dict[str, Any]:
        """Give what files say of it: texts and numbers by name."""

    def fingerprint(self) -> str:
        """Hash all that its lift and drag depend on, by SHA-256."""


@dataclass(frozen=True)
class Model:
    """What is modelled, as one value that is passed on whole.

    Attributes
    ----------
    propeller : Propeller
        Geometry.
    airfoil : Section
        Section law.
    air : Air
        Density and viscosity; the paper's by default.
    corrections : tuple
        Values of ``propmap.correction``, each kind once: what is added to the paper's physics.
        Where none is given, those with which the airfoil's constants were found, as a fit's file
        says; else none.  ``propmap.corrections_of("recommended")`` gives those of the commands.

    Raises
    ------
    InputError
        For arguments of another kind, a correction that does not fit the propeller, or others than
        those with which the airfoil's constants were found.
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
            found = f"{' and '.join(shapes)} both set how the inflow varies around the disk"
            raise InputError(found, "give one of them")
        for value in self.corrections:
            value.check(self)

    def with_airfoil(self, airfoil: Section) -> Model:
        """Exchange the section law for ``airfoil``."""
        return replace(self, airfoil=airfoil)

    def with_mount(self, mount: Correction) -> Model:
        """Put ``mount``, an ``installed``, in the place of its own if any."""
        others = [value for value in self.corrections if name_of(value) != INSTALLED]
        return replace(self, corrections=(*others, mount))

    def with_correction(self, value: Correction) -> Model:
        """Put ``value`` in place of its own of that name, as if the law was found with it."""
        corrections = (*(one for one in self.corrections if type(one) is not type(value)), value)
        law: Any = self.airfoil
        if getattr(law, "corrections", None) is not None:
            law = replace(law, corrections=tuple(as_text(one) for one in corrections))
        return replace(self, airfoil=law, corrections=corrections)

    def correction_of(self, kind: type[OneOf]) -> OneOf | None:
        """Find the correction of this ``kind``, such as ``Installed``, or None."""
        return next((value for value in self.corrections if isinstance(value, kind)), None)

    @property
    def span(self) -> tuple[float, float]:
        """Where the blade begins and ends [m], continued to the hub or not."""
        to_hub = self.correction_of(BladeToHub)
        blade = self.propeller
        return (blade.root if to_hub is None else to_hub.hub(blade)), blade.radius

    @property
    def applied(self) -> tuple[Correction, ...]:
        """The corrections in the order in which they act, that of ``CORRECTIONS``."""
        order = list(CORRECTIONS)
        return tuple(sorted(self.corrections, key=lambda one: order.index(name_of(one))))

    @property
    def uncertainty(self) -> SectionUncertainty | None:
        """How well the section law is known; None where it says nothing of it."""
        known = getattr(self.airfoil, "uncertainty", None)
        filed = getattr(self.airfoil, "corrections", None) or ()
        mounts = [split_mount(list(texts))[1] for texts in (self.correction_texts, filed)]
        if known is not None and mounts[0] != mounts[1]:
            # What is mounted was given instead of found: it is known.
            known = known.without(MOUNT_AREA).without(DRAG_FACTOR)
        return known

    @property
    def correction_texts(self) -> list[str]:
        """The corrections as ``propmap.correction`` reads them, for files."""
        return [as_text(value) for value in self.corrections]

    @property
    def law_title(self) -> str:
        """The section law and the corrections by name, as in "paper-apc + tip-loss"."""
        return " + ".join([self.airfoil.name, *self.correction_texts])

    def reynolds(self, omega: ArrayLike, speed: ArrayLike, beta: ArrayLike) -> tuple[float, float]:
        """The range of Reynolds numbers along the blade at operating points.

        Outside the Reynolds numbers of a ``SectionTable`` its nearest row is used: compare the two.

        Parameters
        ----------
        omega, speed, beta : array_like
            Operating points as in ``Rotor.loads`` [rad/s], [m/s], [rad].

        Returns
        -------
        low, high : float
            Least and largest of any point, at each of which 98 % of the blades' dynamic pressure
            times chord lie between its own.  The induced velocity, which changes Re by little, is
            left out.
        """
        w, v, b = (np.ravel(a)[:, None, None] for a in np.broadcast_arrays(omega, speed, beta))
        y = np.linspace(*self.span, 61)[:, None]
        # Inside the first station, where little of the load is, the chord is taken to be its own.
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
        """Hash geometry, law, air and corrections by SHA-256; no two models have the same."""
        import hashlib

        parts = [
            self.propeller.fingerprint(),
            f"{type(self.airfoil).__qualname__} {self.airfoil.fingerprint()}",
            f"{self.air.density!r} {self.air.viscosity!r}",
            *sorted(self.correction_texts),
        ]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def installation_note(model: Model) -> str:
    """Say whether the rotor drag is that of the blades alone, or of a rotor as it is installed."""
    mount, radius = model.correction_of(Installed), model.propeller.radius
    if mount is None:
        return (
            "rotor drag is that of the blades alone; on a motor or a stand it was measured to be "
            f"about {TYPICAL_FACTOR[0]:g} times that, and more by what stands in the slipstream "
            "(correction installed)"
        )
    unknown = mount.deviations(radius)
    factor, area = f"{mount.blade_factor:g}", f"{1e4 * mount.area(radius):.3g}"
    if DRAG_FACTOR in unknown:
        factor += f" (+- {unknown[DRAG_FACTOR]:g})"
    if MOUNT_AREA in unknown:
        area += f" (+- {1e4 * unknown[MOUNT_AREA]:.3g})"
    return (
        f"rotor drag is that of the installed rotor: {factor} times the blades' own, and the drag "
        f"of {area} cm^2 in the slipstream"
    )
