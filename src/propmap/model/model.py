"""A propeller, a section law, air and corrections: all that loads depend on."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np

from propmap.errors import InputError
from propmap.model.air import Air
from propmap.model.corrections import Correction, as_text, name_of
from propmap.model.propeller import Propeller

if TYPE_CHECKING:
    from propmap.physics.sections.law import SectionLaw
    from propmap.solve.problem import RotorArrays


@runtime_checkable
class Section(Protocol):
    """What may be the section law of a model: ``Airfoil``, ``SectionTable`` or a value of one's
    own."""

    @property
    def name(self) -> str:
        """What it is called."""
        ...

    def law(self) -> SectionLaw:
        """Lift and drag as arrays for the solver."""
        ...

    def metadata(self) -> dict[str, Any]:
        """What files say of it: texts and numbers by name."""
        ...

    def fingerprint(self) -> str:
        """SHA-256 of all that its lift and drag depend on."""
        ...


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

    Raises
    ------
    InputError
        For arguments of another kind, or a correction that does not fit the propeller.
    """

    propeller: Propeller
    airfoil: Section
    air: Air = field(default_factory=Air)
    corrections: tuple[Correction, ...] = ()

    def __post_init__(self) -> None:
        for name, kind, told in (
            ("propeller", Propeller, "a Propeller, from propmap.propeller(...)"),
            ("airfoil", Section, "an Airfoil, from propmap.airfoil(...)"),
            ("air", Air, "an Air, from propmap.Air(...)"),
        ):
            value = getattr(self, name)
            if not isinstance(value, kind):
                raise InputError(f"{name} is {value!r}: give {told}")
        object.__setattr__(self, "corrections", tuple(self.corrections))
        names = [name_of(value) for value in self.corrections]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"correction {name} is given twice: give it once")
        for value in self.corrections:
            value.factor(self.propeller.root)

    def with_airfoil(self, airfoil: Section) -> Model:
        """The same model with another section law, ``airfoil``."""
        return replace(self, airfoil=airfoil)

    def arrays(self) -> RotorArrays:
        """The model as arrays of NumPy float64, for the solver."""
        from propmap.arrays.namespace import by_numpy
        from propmap.physics.element import Medium
        from propmap.physics.geometry import make_blade
        from propmap.solve.problem import RotorArrays

        p, number = self.propeller, np.float64
        blades: Any = (number(p.blades), number(p.root))
        with by_numpy():
            blade = make_blade(p.station, p.chord, p.twist, *blades)
        air: Any = (number(self.air.density), number(self.air.viscosity))
        factors = tuple(value.factor(p.root) for value in self.corrections)
        return RotorArrays(blade, self.airfoil.law(), Medium(*air), factors)

    @property
    def correction_texts(self) -> list[str]:
        """The corrections as ``propmap.correction`` reads them, for files."""
        return [as_text(value) for value in self.corrections]

    def fingerprint(self) -> str:
        """SHA-256 that tells this model from any other: geometry, law, air and corrections."""
        parts = [
            self.propeller.fingerprint(),
            f"{type(self.airfoil).__qualname__} {self.airfoil.fingerprint()}",
            f"{self.air.density!r} {self.air.viscosity!r}",
            *sorted(self.correction_texts),
        ]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()
