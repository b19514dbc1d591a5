"""PROP and the options that choose a rotor, shared by the commands that compute loads."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any, Concatenate, ParamSpec, get_type_hints, overload

import numpy as np
import typer

from propmap.catalogue.expected import ExpectedBlade
from propmap.catalogue.identified import Identified
from propmap.catalogue.lookup import (
    airfoil,
    constants_to_expect,
    meant_by,
    own_constants,
    propeller,
)
from propmap.cli.plausibility import say_doubts, say_expected
from propmap.errors import InputError
from propmap.model.airfoil import Airfoil, SectionTable, airfoil_names
from propmap.model.corrections import CORRECTIONS, apart, as_text, correction, corrections_of
from propmap.model.model import PAPER_DENSITY, PAPER_VISCOSITY, Air, Model, Propeller
from propmap.model.plausibility import doubts_on_air, doubts_on_blade

if TYPE_CHECKING:
    from propmap.rotor import Rotor
    from propmap.typing import Floats

Others = ParamSpec("Others")

PropArgument = Annotated[
    str,
    typer.Argument(
        metavar="PROP",
        help="Name in the catalogue, designation such as 'HQ 5x4.3x3', or geometry file.",
    ),
]
PropOption = Annotated[
    str,
    typer.Option(
        "--prop",
        metavar="PROP",
        help="Name in the catalogue, designation such as 'HQ 5x4.3x3', or geometry file.",
    ),
]
Blades = Annotated[int | None, typer.Option("--blades", metavar="N", help="Number of blades.")]
Radius = Annotated[
    float | None, typer.Option("--radius", help="Tip radius [m], where the file gives none.")
]
RootCutout = Annotated[
    float | None, typer.Option("--root-cutout", help="Where the loaded blade begins [m].")
]


Corrections = Annotated[
    list[str] | None,
    typer.Option(
        "--correction",
        metavar="NAME[:FIELD=VALUE]",
        help=f"Added to the model: {', '.join(CORRECTIONS)} (a field as in "
        "hub-loss:radius_m=0.012); may be repeated.",
    ),
]


class ModelName(StrEnum):
    """The keys of ``MODELS``."""

    recommended = "recommended"
    paper = "paper"


ModelOption = Annotated[
    ModelName | None,
    typer.Option(
        "--model",
        help="Physics: recommended, the paper's with an inflow that varies around the disk "
        "(pitt-peters), or paper, Gill & D'Andrea 2017 to the letter. By default that with which "
        "the section law's constants were found, else recommended.",
    ),
]


class AccuracyName(StrEnum):
    """The settings of ``Rotor``."""

    standard = "standard"
    fine = "fine"


AirfoilOption = Annotated[
    str | None,
    typer.Option(
        "--airfoil",
        metavar="NAME|FILE",
        help="Section law: a name of propmap airfoils, a fit or parameter set (.toml), or a "
        "section table of AeroDyn, XFOIL (a file or a folder), CACTUS or CSV. By default the "
        "constants identified for the propeller, else those to be expected of its family or of "
        "any; a fit starts from the paper's first guess.",
    ),
]
AccuracyOption = Annotated[
    AccuracyName, typer.Option("--accuracy", help="Loads to 0.1 % or, slower, to 0.01 %.")
]


@dataclass(frozen=True)
class RotorChoice:
    """What the user said about the rotor; the fields are the command's parameters."""

    prop: PropArgument
    airfoil: AirfoilOption = None
    rho: Annotated[
        float | None, typer.Option("--rho", help=f"Air density [kg/m^3], else {PAPER_DENSITY}.")
    ] = None
    mu: Annotated[
        float | None, typer.Option("--mu", help=f"Viscosity [Pa s], else {PAPER_VISCOSITY}.")
    ] = None
    altitude: Annotated[
        float | None, typer.Option("--altitude", help="Air of the standard atmosphere here [m].")
    ] = None
    temperature_offset: Annotated[
        float | None,
        typer.Option("--temperature-offset", help="Warmer than the standard atmosphere by [K]."),
    ] = None
    model: ModelOption = None
    correction: Corrections = None
    root_cutout: RootCutout = None
    blades: Blades = None
    radius: Radius = None
    accuracy: AccuracyOption = AccuracyName.standard

    def rotor(self) -> Rotor:
        """The rotor that the options tell of."""
        blade, air = self.blade(), self.medium()
        section = with_physics(self.section(blade), self.model, self.correction)

        from propmap.rotor import Rotor

        return Rotor(Model(blade, section, air), accuracy=self.accuracy.value)

    def section(self, blade: Propeller) -> Airfoil | SectionTable:
        """The section law: that which is named, else constants known for the ``blade``.

        These are the identified ones, else those to be expected of its family or of any propeller;
        a note says which.
        """
        if self.airfoil is not None:
            return airfoil(self.airfoil)
        found = self.identified(blade.blades)
        if found is not None:
            law, told = found.airfoil, found.told
        else:
            meant = meant_by(self.prop)
            expected = constants_to_expect(meant, blade)
            law, told = expected.airfoil, expected.told
            if isinstance(meant, ExpectedBlade) and meant.own is None:
                return law  # the note on the blade tells of the constants too
        typer.echo(f"note: {told}; another law by --airfoil", err=True)
        return law

    def identified(self, blades: int) -> Identified | None:
        """The constants identified for PROP with so many ``blades``, where none are named."""
        return own_constants(meant_by(self.prop), blades) if self.airfoil is None else None

    def blade(self) -> Propeller:
        """The propeller; notes say what is odd about it, and if it was not measured."""
        found = propeller(self.prop, self.blades, self.radius, self.root_cutout)
        say_expected(self.prop)
        say_doubts(doubts_on_blade(found))
        return found

    def medium(self) -> Air:
        """The air; notes say what is odd about its figures."""
        stated = self.rho is not None or self.mu is not None
        standard = self.altitude is not None or self.temperature_offset is not None
        if stated and standard:
            raise InputError(
                "the air is given twice, by its figures and by the standard atmosphere",
                "give --rho and --mu, or --altitude and --temperature-offset",
            )
        if standard:
            return Air.standard(self.altitude or 0.0, self.temperature_offset or 0.0)
        air = Air(
            PAPER_DENSITY if self.rho is None else self.rho,
            PAPER_VISCOSITY if self.mu is None else self.mu,
        )
        say_doubts(doubts_on_air(air))
        return air


@overload
def with_physics(law: Airfoil, model: ModelName | None, added: Sequence[str] | None) -> Airfoil: ...


@overload
def with_physics(
    law: Airfoil | SectionTable, model: ModelName | None, added: Sequence[str] | None
) -> Airfoil | SectionTable: ...


def with_physics(
    law: Airfoil | SectionTable, model: ModelName | None, added: Sequence[str] | None
) -> Airfoil | SectionTable:
    """The section law with the corrections that ``--model`` and ``--correction`` ask for."""
    own, more = law.corrections, [as_text(correction(text)) for text in added or ()]
    physics, mount = apart(more)
    if model is None and not physics and own is not None:
        return law.with_corrections([*apart(own)[0], *mount])
    chosen = corrections_of(model or ModelName.recommended, more)
    return law.with_corrections([as_text(value) for value in chosen])


def constants(name_or_path: str) -> Airfoil:
    """The set of constants that ``--airfoil`` names; ``InputError`` for a section table."""
    found = airfoil(name_or_path)
    if isinstance(found, SectionTable):
        raise InputError(
            "this is a section table, which has no constants such as c_l1 to fit or to fly with",
            f"give one of {', '.join(airfoil_names())}, or a .toml file",
            name_or_path,
        )
    return found


def say_reynolds(model: Model, omega: Floats, speed: Floats, beta: Floats) -> None:
    """Say where a section table does not reach at operating points [rad/s], [m/s], [rad]."""
    if not isinstance(model.airfoil, SectionTable):
        return
    points = np.broadcast_arrays(omega, speed, beta)
    some = np.unique(np.linspace(0, points[0].size - 1, 400).astype(int))
    low, high = model.reynolds(*(values.ravel()[some] for values in points))
    first, last = model.airfoil.reynolds[[0, -1]]
    if low < first or high > last:
        covered = f"covers {first:.2g} to {last:.2g}, its nearest row is used outside"
        if first == last:
            covered = "has one Reynolds number, which is used for all"
        told = f"note: Re from {low:.2g} to {high:.2g} along the blade; the table {covered}"
        typer.echo(told, err=True)


def takes_rotor(
    command: Callable[Concatenate[RotorChoice, Others], None], prop: Any = PropArgument
) -> Callable[..., None]:
    """A command with the parameters of ``RotorChoice`` in place of its first argument.

    ``prop`` says how the propeller is given: as an argument, or by an option.
    """
    own = list(inspect.signature(command, eval_str=True).parameters.values())[1:]
    types = get_type_hints(RotorChoice, include_extras=True)
    shared = [
        inspect.Parameter(
            field.name,
            inspect.Parameter.KEYWORD_ONLY,
            annotation=types[field.name] if field.name != "prop" else prop,
            default=field.default if field.name != "prop" else inspect.Parameter.empty,
        )
        for field in fields(RotorChoice)
    ]
    own = [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in own]

    @functools.wraps(command)
    def run(**given: Any) -> None:
        choice = RotorChoice(**{parameter.name: given.pop(parameter.name) for parameter in shared})
        command(choice, **given)  # type: ignore[call-arg]

    parameters = [shared[0], *own, *shared[1:]]
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return run
