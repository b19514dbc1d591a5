"""What one browser tab explores: names and files, the model that follows, and its commands."""

from __future__ import annotations

import functools
import re
import secrets
import shlex
import tempfile
import threading
import tomllib
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from propmap.baselines.hover import HoverModel
from propmap.catalogue import load
from propmap.catalogue.expected import ExpectedBlade
from propmap.catalogue.lookup import (
    looks_like_path,
    meant_by,
    measurement,
    measurement_names,
    own_constants,
    predicted_constants,
    propeller,
)
from propmap.errors import InputError, quoted
from propmap.fit.files import is_fit, read_fit
from propmap.fit.parameters import constants_of
from propmap.fit.tunnel import TunnelData, measured_in_catalogue, measured_loads
from propmap.io.csv import LOAD_COLUMNS, read_lines
from propmap.io.geometry import propeller_toml, read_geometry_file
from propmap.io.uiuc import looks_like_uiuc_loads
from propmap.model.airfoil import Airfoil, airfoil_names, parameter_set, read_airfoil
from propmap.model.corrections import as_text, corrections_of
from propmap.model.model import Air, Model, Propeller
from propmap.rotor import Rotor
from propmap.units import RPM

if TYPE_CHECKING:
    from propmap.fit.tunnel import TunnelData
    from propmap.table.query import LoadTable
    from propmap.vehicle.vehicle import Vehicle


# -------------------------------------------------------------------------------------------------
# What one browser tab explores: names and files, the model that follows, and what it is called.

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
        law = (own_constants(meant, blade.blades) or predicted_constants(meant, blade)).airfoil
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


# -------------------------------------------------------------------------------------------------
# Files that are explored: what they are, by the package's readers, and where they are kept.

Kind = Literal["geometry", "constants", "fit", "table", "vehicle", "data"]

MOST_BYTES = 5_000_000
"""Of a file that comes through the browser."""

MOST_FILES = 200
"""Kept at a time, of all tabs; the one not used for longest goes first."""

ENDINGS = (".toml", ".npz", ".csv", ".txt", ".dat")


@dataclass(frozen=True, eq=False)
class Given:
    """A file, read.

    Attributes
    ----------
    kind : str
        What it is.
    name : str
        Without its folder.
    data : bytes
        Its content.
    path : str
        As it was given on the command line, "" for what came through the browser.
    found : Any
        What the reader made of it: a ``Propeller``, an ``Airfoil``, a ``FitFile``, a ``LoadTable``,
        a ``Vehicle``, or a function that gives ``TunnelData`` of a propeller and air.
    """

    kind: Kind
    name: str
    data: bytes
    path: str
    found: Any


def read_path(path: Path) -> Given:
    """The file that the command line names; ``InputError`` in one line where it is none of ours."""
    kind, found = _read(path, trusted=True)
    return Given(kind, path.name, path.read_bytes(), str(path), found)


def read_upload(name: str, data: bytes) -> Given:
    """A file that came through the browser, written to a temporary folder for its reader.

    Parameters
    ----------
    name : str
        As the browser says; only its last part counts, and its ending.
    data : bytes
        Its content.

    Raises
    ------
    InputError
        The reader's, with the name alone; and for a file that is too large or of another kind.
    """
    plain = (
        re.sub(r"[^\w.+ -]", "_", Path(name.replace("\\", "/")).name)[-80:].lstrip(".") or "file"
    )
    if len(data) > MOST_BYTES:
        raise InputError(
            f"the file has {len(data) / 1e6:.1f} MB, expected at most {MOST_BYTES / 1e6:g}",
            "give a smaller one",
            plain,
        )
    with tempfile.TemporaryDirectory(prefix="propmap-") as folder:
        path = Path(folder) / plain
        path.write_bytes(data)
        try:
            kind, found = _read(path, trusted=False)
        except InputError as error:
            # Its own text alone may say where the file lay.
            text = str(error).replace(f"{path}", plain).replace(folder, "")
            raise InputError(text) from None
    return Given(kind, plain, data, "", found)


def _read(path: Path, *, trusted: bool) -> tuple[Kind, Any]:
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise InputError(
            f"the file's ending is {quoted(path.suffix)}",
            "give a propeller, constants, a fit, a table, a vehicle or measured loads: "
            f"{', '.join(ENDINGS)}",
            str(path),
        )
    if ending == ".npz":
        from propmap.table.query import LoadTable

        return "table", LoadTable.load(path)
    if ending == ".toml":
        return _read_toml(path, trusted=trusted)
    if looks_like_uiuc_loads(path) or (ending == ".csv" and _has_loads(path)):
        # Read once now, so that what is wrong is told at once.
        make = _loads_of(path)
        return "data", make
    return "geometry", read_geometry_file(str(path))


def _read_toml(path: Path, *, trusted: bool) -> tuple[Kind, Any]:
    text = "\n".join(read_lines(path, "TOML file"))
    try:
        fields = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"not valid TOML ({error})", "correct the file", str(path)) from None
    if "rotors" in fields or "mass" in fields:
        from propmap.vehicle.files import read_vehicle

        named = fields.get("propeller", "")
        named = named.get("geometry", "") if isinstance(named, dict) else named
        if not trusted and isinstance(named, str) and looks_like_path(named):
            raise InputError(
                f"propeller is {quoted(named)}, another file",
                "name one of the catalogue, or give the vehicle to `propmap explore`",
                str(path),
            )
        return "vehicle", read_vehicle(path).vehicle
    if "station_m" in fields:
        return "geometry", read_geometry_file(str(path))
    if is_fit(path):
        return "fit", read_fit(path)
    return "constants", read_airfoil(path)


def _has_loads(path: Path) -> bool:
    first = next((line for line in read_lines(path, "CSV file") if line.strip()), "")
    return any(name in first for name in LOAD_COLUMNS)


def _loads_of(path: Path) -> Callable[[Propeller, Air], TunnelData]:
    """What turns the file's rows into loads, coefficients by a propeller and air."""
    return measured_loads(path)


class Shelf:
    """The files of all tabs, each under a name that only its own tab knows."""

    def __init__(self) -> None:
        self._kept: OrderedDict[str, Given] = OrderedDict()
        self._first: dict[str, Given] = {}
        self._lock = threading.Lock()

    def put(self, given: Given, *, always: bool = False) -> str:
        """Keep a file, and give the name under which it is; ``always`` for the command line's."""
        token = secrets.token_urlsafe(12)
        with self._lock:
            if always:
                self._first[token] = given
                return token
            self._kept[token] = given
            while len(self._kept) > MOST_FILES:
                self._kept.popitem(last=False)
        return token

    def get(self, token: str) -> Given:
        """The file under a name; ``InputError`` where it is not here any more."""
        with self._lock:
            if token in self._first:
                return self._first[token]
            if token in self._kept:
                self._kept.move_to_end(token)
                return self._kept[token]
        raise InputError("a file that was dropped here is not kept any more", "drop it again")


# -------------------------------------------------------------------------------------------------
# Rotors that views share, made once for each model.

KEPT = 32


@functools.lru_cache(maxsize=KEPT)
def rotor_of(model: Model) -> Rotor:
    """The rotor of this model."""
    return Rotor(model)


@functools.lru_cache(maxsize=KEPT)
def hover_model(model: Model) -> HoverModel:
    """The hover model with this one's loads at rest."""
    return HoverModel.of(rotor_of(model))


def fastest(model: Model) -> float:
    """A high rotational speed for sliders [rad/s]: a tip at 200 m/s, as a round figure in rpm."""
    return float(np.ceil(200.0 / model.propeller.radius / RPM / 500.0)) * 500.0 * RPM


# -------------------------------------------------------------------------------------------------
# The command lines and the lines of Python that make the same numbers as the page.

BLADE_FILE, CONSTANTS_FILE = "blade.toml", "constants.toml"


class Recipe:
    """How a command and a script name what a session explores.

    Parameters
    ----------
    session : Session
        What is explored.
    blade : Propeller, optional
        Another blade that takes the place of the session's.
    constants : Airfoil, optional
        Other constants that take the place of the session's.
    """

    def __init__(
        self,
        session: Session,
        blade: Propeller | None = None,
        constants: Airfoil | None = None,
    ) -> None:
        self.session = session
        self._texts: dict[str, str] = {}
        self.prop, self.options = self._named(blade, constants)

    def _named(self, blade: Propeller | None, constants: Airfoil | None) -> tuple[str, list[str]]:
        session, options = self.session, []
        prop = session.name
        if blade is not None:
            prop = self._file(BLADE_FILE, propeller_toml(blade))
        elif not prop and "geometry" in session.files:
            prop = self._given("geometry")
        elif not prop:
            prop = self._file(BLADE_FILE, propeller_toml(session.model.propeller))
        if constants is not None:
            options += ["--airfoil", self._file(CONSTANTS_FILE, constants.to_toml())]
        elif "fit" in session.files or "constants" in session.files:
            options += ["--airfoil", self._given("fit" if "fit" in session.files else "constants")]
        elif session.law != KNOWN:
            options += ["--airfoil", session.law]
        elif blade is not None:
            # By name the constants would be those of another blade.
            options += [
                "--airfoil",
                self._file(CONSTANTS_FILE, constants_of(session.model.airfoil).to_toml()),
            ]
        if session.physics and constants is None:
            options += ["--model", session.physics]
        air = session.model.air
        if air != type(air)():
            options += ["--rho", repr(air.density), "--mu", repr(air.viscosity)]
        return prop, options

    def _given(self, kind: str) -> str:
        one = self.session.files[kind]
        if one.path:
            return one.path
        if PurePath(one.name).suffix.lower() == ".npz":
            return one.name
        return self._file(one.name, one.data.decode("utf-8-sig", "replace"))

    def _file(self, name: str, text: str) -> str:
        self._texts[name] = text if text.endswith("\n") else text + "\n"
        return name

    def file(self, kind: str) -> str:
        """The path of the session's file of this kind, which the command writes where it has to."""
        return self._given(kind)

    def shell(self, *commands: Sequence[str]) -> str:
        """Lines for a shell: the files that are needed, then ``propmap`` with each command."""
        lines = []
        for name, text in self._texts.items():
            lines.append(f"cat > {shlex.quote(name)} <<'END_OF_FILE'\n{text}END_OF_FILE")
        lines += [shlex.join(["propmap", *command]) for command in commands]
        return "\n".join(lines)

    def python(self, rest: str) -> str:
        """Lines of Python: the model as ``model``, then the ``rest``."""
        lines = ["import numpy as np", "import propmap", ""]
        for name, text in self._texts.items():
            lines.append(f"open({name!r}, 'w', encoding='utf-8').write({text!r})")
        blade = f"blade = propmap.propeller({self.prop!r})"
        if "--airfoil" not in self.options and self.session.physics != "paper":
            lines.append(f"model = propmap.known_model({self.prop!r}{self._air()})")
        elif "--airfoil" not in self.options:
            lines.append(f"model = propmap.known_model({self.prop!r}{self._air()}, corrections=())")
        else:
            name = self.options[self.options.index("--airfoil") + 1]
            lines += [blade, f"law = propmap.airfoil({name!r})"]
            own = constants_of(self.session.model.airfoil).corrections
            corrections = tuple(self.session.model.correction_texts)
            if own is None or tuple(own) != corrections or self.session.physics:
                lines.append(f"law = law.with_corrections({list(corrections)!r})")
            lines.append(f"model = propmap.Model(blade, law{self._air()})")
        lines.append("rotor = propmap.Rotor(model)")
        return "\n".join([*lines, rest.strip(), ""])

    def _air(self) -> str:
        air = self.session.model.air
        if air == type(air)():
            return ""
        return f", air=propmap.Air({air.density!r}, {air.viscosity!r})"


def number(value: float) -> str:
    """A number as it is written in a command: all digits that it has, none that it has not."""
    return f"{float(value):.10g}"


def axis(low: float, high: float, count: int) -> str:
    """``A:B:N`` of a command."""
    return f"{number(low)}:{number(high)}:{count}"
