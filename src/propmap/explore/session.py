"""Session of a browser tab: propeller, constants and files, their model, and its commands."""

from __future__ import annotations

import functools
import re
import secrets
import shlex
import tempfile
import threading
import tomllib
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePath
from typing import Any, Generic, Literal, TypeVar

import numpy as np

from propmap.catalogue import load
from propmap.catalogue.expected import ExpectedBlade
from propmap.catalogue.lookup import (
    best_constants,
    looks_like_path,
    meant_by,
    measurement,
    measurement_names,
    propeller,
)
from propmap.errors import InputError, quoted
from propmap.fit.files import is_fit, read_fit
from propmap.fit.parameters import constants_of
from propmap.fit.tunnel import TunnelData, measured_in_catalogue, measured_loads
from propmap.hover import HoverModel
from propmap.io.coefficients import looks_like_coefficients
from propmap.io.csv import LOAD_COLUMNS, columns_in, read_lines
from propmap.io.geometry import propeller_toml, read_geometry_file
from propmap.model.air import Air
from propmap.model.airfoil import Airfoil, airfoil_names, parameter_set, read_airfoil
from propmap.model.corrections import as_text, model_corrections
from propmap.model.model import Model
from propmap.model.propeller import Propeller
from propmap.rotor import Rotor
from propmap.table.query import LoadTable
from propmap.units import RPM

DEFAULT = "apc-8x6e"
KNOWN = "known"  # value of ``law`` for the best available constants of the propeller
FILE = "file-"  # prefix of the kinds of files in the address
PHYSICS = ("recommended", "paper")


@dataclass(frozen=True)
class Session:
    """Propeller and constants of a tab, by name or from files."""

    prop: str = DEFAULT  # catalogue name or designation
    law: str = KNOWN  # or the name of a set of constants
    physics: str = ""  # one of ``PHYSICS``; "": the model with which the constants were identified
    files: Mapping[str, Given] = field(default_factory=dict, compare=False)  # by kind
    tokens: Mapping[str, str] = field(default_factory=dict, hash=False)  # shelf names by kind

    @classmethod
    def of(cls, query: Mapping[str, str], first: Session, shelf: Shelf) -> Session:
        """Return the session of an address, or ``first`` if the address contains none; raise
        ``InputError`` for unknown names and for files that are not on the ``shelf``."""
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
                raise InputError(f"wrong file for {quoted(kind)}", "open the start page /")
        check_name(found.prop, ", a designation such as 'HQ 5x4.3x3', or drop a file")
        meant_by(found.prop)
        check_law(found.law)
        if found.physics not in ("", *PHYSICS):
            fault = f"unknown model {quoted(found.physics)}"
            raise InputError(fault, "choose recommended or paper")
        return found

    def query(self) -> dict[str, str]:
        """Return the parameters of the address."""
        names = {"prop": self.prop, "law": self.law, "physics": self.physics}
        return {
            **{key: value for key, value in names.items() if value},
            **{FILE + kind: token for kind, token in self.tokens.items()},
        }

    def with_file(self, given: Given, token: str) -> Session:
        """Return the session with a file, and without the files that it replaces."""
        gone = {
            "fit": ("geometry", "constants", "vehicle"),
            "geometry": ("fit", "vehicle"),
            "constants": ("fit",),
            "vehicle": ("fit", "geometry"),
        }
        rest = self.without(*gone.get(given.kind, ()))
        files, tokens = {**rest.files, given.kind: given}, {**rest.tokens, given.kind: token}
        return replace(rest, files=files, tokens=tokens)

    def without(self, *kinds: str) -> Session:
        """Return the session without the files of these kinds."""
        files = {kind: one for kind, one in self.files.items() if kind not in kinds}
        return replace(self, files=files, tokens={k: self.tokens[k] for k in files})

    def given(self, kind: str) -> Any:
        """Return the content of the file of this kind, or None."""
        one = self.files.get(kind)
        return None if one is None else one.found

    @property
    def model(self) -> Model:
        """Return the model from propeller, constants, air and corrections."""
        return _model(self)

    @property
    def name(self) -> str:
        """Return the catalogue name or designation of the blade; "" if only a file defines it."""
        if "fit" in self.files or "vehicle" in self.files:
            blade = _blade(self)
            try:
                found = meant_by(blade.name)
            except InputError:
                return ""
            if found is None or isinstance(found, ExpectedBlade):
                return ""
            same = load(found.name).fingerprint() == blade.fingerprint()
            return blade.name if same else ""
        return "" if "geometry" in self.files else self.prop

    def measured(self, which: str) -> TunnelData | None:
        """Return measured loads: None for "none", the "file", or a catalogue measurement."""
        if which == "file":
            make = self.given("data")
            return None if make is None else make(self.model.propeller, self.model.air)
        if which in measurement_names():
            return measured_in_catalogue(which, self.model.air)
        return None

    def measurements(self) -> list[str]:
        """Return the names of the measured loads of this propeller, the file first."""
        own = [name for name in measurement_names() if measurement(name).propeller == self.name]
        return [*(["file"] if "data" in self.files else []), *own]


def check_name(name: str, others: str = "") -> None:
    """Raise ``InputError`` for a path instead of a propeller name."""
    if looks_like_path(name):
        found = f"{quoted(name)} is not a propeller name"
        raise InputError(found, f"give a catalogue name{others}")


def check_law(law: str) -> None:
    """Raise ``InputError`` for an unknown set of constants."""
    known = (KNOWN, *airfoil_names())
    if law not in known:
        found = f"unknown constants {quoted(law)}"
        raise InputError(found, f"choose one of {', '.join(known)}")


@functools.lru_cache(maxsize=64)
def _model(session: Session) -> Model:
    """Return the model with the same constants and corrections as `propmap predict`."""
    blade, files = _blade(session), session.files
    described = session.given("vehicle")
    air = Air() if described is None else described.vehicle.air
    if "fit" in files:
        air, law = session.given("fit").model.air, session.given("fit").airfoil
    elif "constants" in files:
        law = session.given("constants")
    elif session.law != KNOWN:
        law = parameter_set(session.law)
    else:
        if described is not None:
            meant = meant_by(described.propeller, described.blades)
        else:
            meant = meant_by(session.name) if session.name else None
        law = best_constants(meant, blade).airfoil
    if session.physics or law.corrections is None:
        by_name = law.uncertainty is not None
        chosen = model_corrections(session.physics or "recommended", installed=by_name)
        law = law.with_corrections([as_text(one) for one in chosen])
    return Model(blade, law, air)


def _blade(session: Session) -> Propeller:
    if "fit" in session.files:
        return session.given("fit").model.propeller
    if "geometry" in session.files:
        return session.given("geometry")
    vehicle = session.given("vehicle")
    return propeller(session.prop) if vehicle is None else vehicle.vehicle.propeller


# --- Files of the sessions: their kinds, reading and storage -------------------------------------

Kind = Literal["geometry", "constants", "fit", "table", "vehicle", "data"]

MOST_BYTES = 5_000_000  # maximum size of an uploaded file
MOST_FILES = 200  # maximum number of stored files of all tabs; the least recently used is deleted
Value = TypeVar("Value")
ENDINGS = (".toml", ".npz", ".csv", ".txt", ".dat", ".pe0", ".prop", ".xrotor", ".bem")


@dataclass(frozen=True, eq=False)
class Given:
    """The content of a file."""

    kind: Kind
    name: str  # without folder
    data: bytes
    path: str  # as on the command line; "" for uploaded files
    # A ``Propeller``, ``Airfoil``, ``FitFile``, ``LoadTable``, ``Vehicle``, or a function that
    # returns ``TunnelData`` for a propeller and air.
    found: Any


def read_path(path: Path) -> Given:
    """Read a file of the command line; raise ``InputError`` for an unknown format."""
    kind, found = _read(path, trusted=True)
    return Given(kind, path.name, path.read_bytes(), str(path), found)


def read_upload(name: str, data: bytes) -> Given:
    """Read an uploaded file in a temporary folder.

    Messages of ``InputError`` contain only the last part of ``name``, not the folder.
    """
    plain = (
        re.sub(r"[^\w.+ -]", "_", Path(name.replace("\\", "/")).name)[-80:].lstrip(".-") or "file"
    )
    if len(data) > MOST_BYTES:
        fault = f"the file has {len(data) / 1e6:.1f} MB, expected at most {MOST_BYTES / 1e6:g}"
        raise InputError(fault, "give a smaller file", plain)
    with tempfile.TemporaryDirectory(prefix="propmap-") as folder:
        path = Path(folder) / plain
        path.write_bytes(data)
        try:
            kind, found = _read(path, trusted=False)
        except InputError as error:
            # The message must not reveal the temporary folder.
            text = str(error).replace(f"{path}", plain).replace(folder, "")
            raise InputError(text) from None
    return Given(kind, plain, data, "", found)


def _read(path: Path, *, trusted: bool) -> tuple[Kind, Any]:
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        remedy = "give a propeller, constants, a fit, a table, a vehicle or measured loads: "
        remedy += f"{', '.join(ENDINGS)}"
        raise InputError(f"unknown file extension {quoted(path.suffix)}", remedy, str(path))
    if ending == ".npz":
        return "table", LoadTable.load(path)
    if ending == ".toml":
        return _read_toml(path, trusted=trusted)
    lines = read_lines(path, "geometry or measurement")
    first = next((line for line in lines if line.strip()), "")
    loads = ending == ".csv" and columns_in(first, ("rpm", *LOAD_COLUMNS))
    if looks_like_coefficients(path) or loads:
        # Errors in the file are reported now, not at the first use.
        return "data", measured_loads(path)
    return "geometry", read_geometry_file(str(path))


def _read_toml(path: Path, *, trusted: bool) -> tuple[Kind, Any]:
    text = "\n".join(read_lines(path, "TOML"))
    try:
        fields = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"not valid TOML ({error})", "correct the file", str(path)) from None
    if "rotors" in fields or "mass" in fields:
        from propmap.vehicle.files import read_vehicle

        named = fields.get("propeller", "")
        named = named.get("geometry", "") if isinstance(named, dict) else named
        if not trusted and isinstance(named, str) and looks_like_path(named):
            found = f"the key 'propeller' refers to another file, {quoted(named)}"
            remedy = "give a catalogue name, or open the vehicle with `propmap explore FILE`"
            raise InputError(found, remedy, str(path))
        return "vehicle", read_vehicle(path)
    if "station_m" in fields:
        return "geometry", read_geometry_file(str(path))
    if is_fit(path):
        return "fit", read_fit(path)
    return "constants", read_airfoil(path)


class Recent(Generic[Value]):
    """Values by name, for all threads; above ``most``, the least recently used is deleted."""

    def __init__(self, most: int) -> None:
        self._kept: OrderedDict[str, Value] = OrderedDict()
        self._most, self._lock = most, threading.Lock()

    def put(self, name: str, value: Value) -> None:
        """Store a value under a name."""
        with self._lock:
            self._kept[name] = value
            self._kept.move_to_end(name)
            if len(self._kept) > self._most:
                self._kept.popitem(last=False)

    def get(self, name: str) -> Value | None:
        """Return the value with a name, or None."""
        with self._lock:
            if name in self._kept:
                self._kept.move_to_end(name)
            return self._kept.get(name)


class Shelf:
    """The files of all tabs, each under a name that only its tab knows."""

    def __init__(self) -> None:
        self._files = Recent[Given](MOST_FILES)

    def put(self, given: Given) -> str:
        """Store a file and return its name."""
        token = secrets.token_urlsafe(12)
        self._files.put(token, given)
        return token

    def __contains__(self, token: str) -> bool:
        return self._files.get(token) is not None

    def get(self, token: str) -> Given:
        """Return the file with a name; raise ``InputError`` if it was deleted."""
        given = self._files.get(token)
        if given is None:
            raise InputError("the server no longer stores a dropped file", "drop the file again")
        return given


# --- Rotors and hover models, which the views share ----------------------------------------------

KEPT = 32  # number of models in the cache


@functools.lru_cache(maxsize=KEPT)
def rotor_of(model: Model) -> Rotor:
    """Return the rotor of a model."""
    return Rotor(model)


@functools.lru_cache(maxsize=KEPT)
def hover_model(model: Model) -> HoverModel:
    """Return the hover model with the static loads of a model."""
    return HoverModel.from_rotor(rotor_of(model))


def fastest(model: Model) -> float:
    """Return the maximum rotational speed of the sliders [rad/s], for a tip at 200 m/s."""
    return float(np.ceil(200.0 / model.propeller.radius / RPM / 500.0)) * 500.0 * RPM


# --- Command lines and Python code that compute the numbers of the page --------------------------

BLADE_FILE, CONSTANTS_FILE = "blade.toml", "constants.toml"
POINT = ("rpm", "speed", "beta")  # controls of the operating point


class Recipe:
    """Commands and scripts of a session, with an optional other ``blade`` or ``constants``."""

    def __init__(
        self, session: Session, blade: Propeller | None = None, constants: Airfoil | None = None
    ) -> None:
        self.session = session
        self._texts: dict[str, str] = {}
        self.options: list[str] = []
        model = session.model
        if blade is None and not session.name and "geometry" in session.files:
            self.prop = self.file("geometry")
        elif blade is None and session.name:
            self.prop = session.name
        else:
            self.prop = self._write(BLADE_FILE, propeller_toml(blade or model.propeller))
        law = ""
        if constants is not None:
            law = self._write(CONSTANTS_FILE, constants.to_toml())
        elif "fit" in session.files or "constants" in session.files:
            law = self.file("fit" if "fit" in session.files else "constants")
        elif session.law != KNOWN:
            law = session.law
        elif blade is not None:
            # The catalogue constants of the name belong to the unchanged blade.
            law = self._write(CONSTANTS_FILE, constants_of(model.airfoil).to_toml())
        if law:
            self.options += ["--airfoil", law]
        if session.physics and constants is None:
            self.options += ["--model", session.physics]
        self._air = ""
        if model.air != Air():
            self.options += ["--rho", repr(model.air.density), "--mu", repr(model.air.viscosity)]
            self._air = f", air=propmap.Air({model.air.density!r}, {model.air.viscosity!r})"

    def file(self, kind: str) -> str:
        """Return the path of a file; the commands first write it if it was uploaded."""
        one = self.session.files[kind]
        if one.path:
            return one.path
        if PurePath(one.name).suffix.lower() == ".npz":
            return one.name
        return self._write(one.name, one.data.decode("utf-8-sig", "replace"))

    def _write(self, name: str, text: str) -> str:
        # Rename a file whose name belongs to another text or to a file of the command line.
        text = text if text.endswith("\n") else text + "\n"
        paths = {one.path for one in self.session.files.values()}
        while self._texts.get(name, text) != text or name in paths:
            name = f"new-{name}"
        self._texts[name] = text
        return name

    def predict(self, values: Mapping[str, Any]) -> list[str]:
        """Return the command for the loads at the operating point."""
        point = [part for key in POINT for part in (f"--{key}", number(values[key]))]
        return ["predict", self.prop, *point, *self.options]

    def sweep(self, values: Mapping[str, Any], top: float, count: int, file: str) -> list[str]:
        """Return the command for the loads at ``count`` airspeeds up to ``top`` [m/s]."""
        return [
            *("sweep", self.prop, "--rpm", number(values["rpm"])),
            *("--speed", axis(0.0, top, count), "--beta", number(values["beta"])),
            *(*self.options, "--no-bands", "-o", file, "--force"),
        ]

    def shell(self, *commands: Sequence[str]) -> str:
        """Return shell lines that write the required files and run the propmap commands."""
        lines = [written_by_shell(name, text) for name, text in self._texts.items()]
        lines += [shlex.join(["propmap", *command]) for command in commands]
        return "\n".join(lines)

    def python(self, rest: str) -> str:
        """Return Python code that defines ``model`` and ``rotor``, then runs ``rest``."""
        lines = ["import numpy as np", "import propmap", ""]
        for name, text in self._texts.items():
            lines.append(f"open({name!r}, 'w', encoding='utf-8').write({text!r})")
        if "--airfoil" not in self.options:
            bare = ", corrections=()" if self.session.physics == "paper" else ""
            lines.append(f"model = propmap.catalogue_model({self.prop!r}{self._air}{bare})")
        else:
            name = self.options[self.options.index("--airfoil") + 1]
            lines.append(f"blade = propmap.propeller({self.prop!r})")
            lines.append(f"law = propmap.airfoil({name!r})")
            own = constants_of(self.session.model.airfoil).corrections
            corrections = tuple(self.session.model.correction_texts)
            if own is None or tuple(own) != corrections or self.session.physics:
                lines.append(f"law = law.with_corrections({list(corrections)!r})")
            lines.append(f"model = propmap.Model(blade, law{self._air})")
        lines.append("rotor = propmap.Rotor(model)")
        return "\n".join([*lines, rest.strip(), ""])


def written_by_shell(name: str, text: str) -> str:
    """Return a command that writes a text file, with an end mark that the text excludes."""
    end = "END_OF_FILE" if "END_OF_FILE" not in text else secrets.token_hex(8)
    return f"cat > {shlex.quote(name)} <<'{end}'\n{text}{end}"


def number(value: float) -> str:
    """Return a number with up to ten digits for a command, without trailing zeros."""
    return f"{float(value):.10g}"


def axis(low: float, high: float, count: int) -> str:
    """Return ``A:B:N`` for a command."""
    return f"{number(low)}:{number(high)}:{count}"
