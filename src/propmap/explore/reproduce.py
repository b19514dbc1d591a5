"""The command lines and the lines of Python that make the same numbers as the page."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import PurePath

from propmap.explore.session import KNOWN, Session
from propmap.fit.parameters import constants_of
from propmap.io.propeller_toml import propeller_toml
from propmap.model.airfoil import Airfoil
from propmap.model.propeller import Propeller

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
