"""What one browser tab explores: names and files, the model that follows, and what it is called."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from propmap.catalogue import load
from propmap.catalogue.expected_blade import ExpectedBlade
from propmap.catalogue.known import constants_to_expect, own_constants
from propmap.catalogue.lookup import looks_like_path, meant_by, propeller
from propmap.catalogue.measurements import measurement, measurement_names
from propmap.errors import InputError, quoted
from propmap.explore.given import Given, Shelf
from propmap.fit.tunnel import measured_in_catalogue
from propmap.model.air import Air
from propmap.model.airfoil import Airfoil, airfoil_names, parameter_set
from propmap.model.corrections import as_text, corrections_of
from propmap.model.model import Model
from propmap.model.propeller import Propeller

if TYPE_CHECKING:
    from propmap.fit.tunnel import TunnelData
    from propmap.table.query import LoadTable
    from propmap.vehicle.vehicle import Vehicle

DEFAULT = "apc-8x6e"

KNOWN = "known"
"""The section law where none is chosen: the best constants that are known."""

FILE = "file-"
"""Before the kinds of files in the address."""

PHYSICS = ("recommended", "paper")


@dataclass(frozen=True)
class Session:
    """What a tab explores.

    Attributes
    ----------
    prop : str
        A name of the catalogue or a designation; it counts where no geometry is given.
    law : str
        ``KNOWN`` or the name of a set of constants; it counts where no constants are given.
    physics : str
        Of ``PHYSICS``, or "" for what the constants were found with.
    files : mapping of str to Given
        By what they are.
    tokens : mapping of str to str
        Under which names these are on the shelf.
    """

    prop: str = DEFAULT
    law: str = KNOWN
    physics: str = ""
    files: Mapping[str, Given] = field(default_factory=dict, compare=False)
    tokens: Mapping[str, str] = field(default_factory=dict, hash=False)

    @classmethod
    def of(cls, query: Mapping[str, str], first: Session, shelf: Shelf) -> Session:
        """What an address tells.

        Parameters
        ----------
        query : mapping of str
            Parameters of the address.
        first : Session
            That of the command line, which counts where the address tells nothing.
        shelf : Shelf
            Where files are.

        Raises
        ------
        InputError
            For names that mean nothing, files of the server, and files that are not kept any more.
        """
        tokens = {
            key.removeprefix(FILE): token for key, token in query.items() if key.startswith(FILE)
        }
        if not tokens and "prop" not in query:
            return first
        found = cls(
            query.get("prop") or DEFAULT,
            query.get("law") or KNOWN,
            query.get("physics") or "",
            {kind: shelf.get(token) for kind, token in tokens.items()},
            tokens,
        )
        for kind, given in found.files.items():
            if given.kind != kind:
                raise InputError(f"the address is damaged at {quoted(kind)}", "open / instead")
        found._check()
        return found

    def query(self) -> dict[str, str]:
        """What the address tells."""
        told = {"prop": self.prop, "law": self.law, "physics": self.physics}
        return {
            **{key: value for key, value in told.items() if value},
            **{FILE + kind: token for kind, token in self.tokens.items()},
        }

    def _check(self) -> None:
        if looks_like_path(self.prop):
            raise InputError(
                f"{quoted(self.prop)} is no name of a propeller",
                "give one of the catalogue or such as 'HQ 5x4.3x3'; drop a file for another",
            )
        meant_by(self.prop)
        if self.law != KNOWN and self.law not in airfoil_names():
            raise InputError(
                f"{quoted(self.law)} is no set of constants",
                f"choose one of {', '.join((KNOWN, *airfoil_names()))}",
            )
        if self.physics not in ("", *PHYSICS):
            raise InputError(f"{quoted(self.physics)} is no physics", "choose recommended or paper")

    def with_file(self, given: Given, token: str) -> Session:
        """The session with one more file; a blade, constants or a fit take each other's place."""
        gone = {
            "fit": {"geometry", "constants", "vehicle"},
            "geometry": {"fit", "vehicle"},
            "constants": {"fit"},
            "vehicle": {"fit", "geometry"},
        }.get(given.kind, set())

        def kept(entries: Mapping[str, Any]) -> dict[str, Any]:
            return {kind: value for kind, value in entries.items() if kind not in gone}

        return replace(
            self,
            files={**kept(self.files), given.kind: given},
            tokens={**kept(self.tokens), given.kind: token},
        )

    def given(self, kind: str) -> Any:
        """What the file of this kind holds; None where there is none."""
        one = self.files.get(kind)
        return None if one is None else one.found

    @property
    def table(self) -> LoadTable | None:
        """The table that was given."""
        found: LoadTable | None = self.given("table")
        return found

    @property
    def vehicle(self) -> Vehicle | None:
        """The vehicle that was given."""
        found: Vehicle | None = self.given("vehicle")
        return found

    @property
    def model(self) -> Model:
        """Propeller, constants, air and corrections."""
        return _model(self)

    @property
    def name(self) -> str:
        """What the blade is called in the catalogue or by designation, "" where it is in a file."""
        return _name(self)

    def measured(self, which: str) -> TunnelData | None:
        """Loads to compare with: "none", the "file" that was given, or a measurement by name."""
        if which == "file":
            make = self.given("data")
            return None if make is None else make(self.model.propeller, self.model.air)
        if which in measurement_names():
            return measured_in_catalogue(which, self.model.air)
        return None

    def measurements(self) -> list[str]:
        """What ``measured`` knows of this propeller, the file first."""
        own = [name for name in measurement_names() if measurement(name).propeller == self.name]
        return [*(["file"] if "data" in self.files else []), *own]


@functools.lru_cache(maxsize=64)
def _model(session: Session) -> Model:
    blade = _blade(session)
    air = session.vehicle.air if session.vehicle is not None else Air()
    if "fit" in session.files:
        air = session.given("fit").model.air
    return Model(blade, with_physics(_constants(session, blade), session.physics), air)


def _blade(session: Session) -> Propeller:
    found: Propeller
    if "fit" in session.files:
        found = session.given("fit").model.propeller
    elif "geometry" in session.files:
        found = session.given("geometry")
    elif session.vehicle is not None:
        found = session.vehicle.propeller
    else:
        found = propeller(session.prop)
    return found


def _constants(session: Session, blade: Propeller) -> Airfoil:
    """The constants, as `propmap predict` chooses them."""
    law: Airfoil
    if "fit" in session.files:
        law = session.given("fit").airfoil
    elif "constants" in session.files:
        law = session.given("constants")
    elif session.law != KNOWN:
        law = parameter_set(session.law)
    else:
        meant = meant_by(session.name) if session.name else None
        law = (own_constants(meant, blade.blades) or constants_to_expect(meant, blade)).airfoil
    return law


def _name(session: Session) -> str:
    if "fit" in session.files or "vehicle" in session.files:
        blade = _blade(session)
        return blade.name if _in_catalogue(blade) else ""
    return "" if "geometry" in session.files else session.prop


def _in_catalogue(blade: Propeller) -> bool:
    try:
        found = meant_by(blade.name)
    except InputError:
        return False
    if found is None or isinstance(found, ExpectedBlade):
        return False
    return load(found.name).fingerprint() == blade.fingerprint()


def with_physics(law: Airfoil, physics: str) -> Airfoil:
    """The constants with the corrections that are meant, as by `--model`."""
    if not physics and law.corrections is not None:
        return law
    return law.with_corrections([as_text(one) for one in corrections_of(physics or "recommended")])
