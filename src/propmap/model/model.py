"""A propeller, a section law, air and corrections: all that loads depend on."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from propmap.errors import InputError, quoted
from propmap.loads import DRAG_FACTOR, MOUNT_AREA
from propmap.model.airfoil import ByValue, SectionUncertainty
from propmap.model.corrections import (
    CORRECTIONS,
    INSTALLED,
    BladeToHub,
    Correction,
    InflowShape,
    agreed,
    as_text,
    correction,
    name_of,
    split_mount,
)
from propmap.model.plausibility import check_blade, check_blades, check_root_cutout
from propmap.typing import Floats


@dataclass(frozen=True, eq=False, repr=False)
class Propeller(ByValue):
    """Chord and twist of a blade at its measured stations, and how many blades there are.

    The arrays are kept as read-only float64 copies.

    Attributes
    ----------
    name : str
        What the propeller is called.
    blades : int
        Number of blades, 1 to 12.
    station : ndarray, shape (n,)
        Radii [m], n >= 4, rising from the first measured section to the tip.
    chord : ndarray, shape (n,)
        [m].
    twist : ndarray, shape (n,)
        The chord line against the disk plane [rad].
    root_cutout : float or None
        Where the loaded part of the blade begins [m]; None is the first station.
    source, citation : str
        Where the figures are from and what was done to them, and whom to cite.

    Raises
    ------
    InputError
        For a blade that cannot be: see ``propmap.model.plausibility``.
    """

    name: str
    blades: int
    station: Floats
    chord: Floats
    twist: Floats
    root_cutout: float | None = None
    source: str = ""
    citation: str = ""

    def __post_init__(self) -> None:
        for array in ("station", "chord", "twist"):
            object.__setattr__(self, array, _frozen_array(getattr(self, array), array))
        check_blade(self.station, self.chord, self.twist)
        object.__setattr__(self, "blades", check_blades(self.blades))
        if self.root_cutout is not None:
            root = check_root_cutout(self.root_cutout, self.station)
            object.__setattr__(self, "root_cutout", root)

    @property
    def radius(self) -> float:
        """Tip radius [m], the last station."""
        return float(self.station[-1])

    @property
    def diameter(self) -> float:
        """Diameter [m]."""
        return 2.0 * self.radius

    @property
    def summary(self) -> str:
        """Number of blades and radius in words."""
        return f"{self.blades} blades, R = {self.radius:.4g} m"

    @property
    def root(self) -> float:
        """Where the loaded part of the blade begins [m]."""
        return float(self.station[0]) if self.root_cutout is None else self.root_cutout

    def with_root_cutout(self, radius_m: float) -> Propeller:
        """Load this propeller from ``radius_m`` [m] outwards."""
        return replace(self, root_cutout=radius_m)

    def scaled(self, factor: float) -> Propeller:
        """Make radius and chord ``factor`` times as large."""
        root = None if self.root_cutout is None else factor * self.root_cutout
        return replace(
            self, station=factor * self.station, chord=factor * self.chord, root_cutout=root
        )

    def fingerprint(self) -> str:
        """SHA-256 of station [m], chord [m], twist [rad], root [m] and blades, as little-endian f8.

        Name and source play no part.
        """
        import hashlib

        figures = (self.station, self.chord, self.twist, [self.root, float(self.blades)])
        return hashlib.sha256(np.concatenate(figures).astype("<f8").tobytes()).hexdigest()

    def __repr__(self) -> str:
        return (
            f"Propeller({self.name!r}, {self.blades} blades, diameter {self.diameter:.4g} m, "
            f"{self.station.size} stations)"
        )


def _frozen_array(values: Any, field: str) -> Floats:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        found = f"{field} is {quoted(values)}, expected a list of numbers"
        raise InputError(found, f"give {field} as one number per station") from None
    array.flags.writeable = False
    return array


PAPER_DENSITY = 1.225
PAPER_VISCOSITY = 1.983e-5


@dataclass(frozen=True)
class Air:
    """The air around the propeller; by default the paper's values.

    Attributes
    ----------
    density : float
        rho [kg/m^3].
    viscosity : float
        Dynamic viscosity mu [Pa s].

    Raises
    ------
    InputError
        For values that are not finite and positive.
    """

    density: float = PAPER_DENSITY
    viscosity: float = PAPER_VISCOSITY

    def __post_init__(self) -> None:
        for name, unit in (("density", "kg/m^3"), ("viscosity", "Pa s")):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise InputError(f"air {name} is {value!r}: give a number in {unit}")
            if not (math.isfinite(value) and value > 0.0):
                raise InputError(f"air {name} is {value}: it must be positive and finite [{unit}]")

    @classmethod
    def standard(cls, altitude: float = 0.0, temperature_offset: float = 0.0) -> Air:
        """ICAO standard atmosphere, optionally warmer or colder at the same pressure.

        The viscosity follows Sutherland's law of the same standard (ICAO Doc 7488/3, 1993).

        Parameters
        ----------
        altitude : float
            Geometric, above mean sea level [m], -5000 to 80000.
        temperature_offset : float
            To the standard temperature [K], -60 to 60.

        Raises
        ------
        InputError
            Outside these ranges.
        """
        if not -5000.0 <= altitude <= 80000.0:
            raise InputError(f"altitude is {altitude} m: it must lie between -5000 and 80000 m")
        if not -60.0 <= temperature_offset <= 60.0:
            raise InputError(
                f"temperature offset is {temperature_offset} K: it must lie between -60 and 60 K"
            )
        from ambiance import CONST, Atmosphere

        day = Atmosphere(altitude)
        temperature = float(day.temperature[0]) + temperature_offset
        density = float(day.pressure[0]) / (CONST.R * temperature)
        viscosity = CONST.beta_s * temperature**1.5 / (temperature + CONST.S)
        return cls(density, float(viscosity))


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
