"""Options that commands share: PROP and its rotor, operating points, workers, bands, notes."""

from __future__ import annotations

import functools
import inspect
import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
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
from propmap.errors import InputError
from propmap.io.csv import OperatingPoints, check_value
from propmap.model.airfoil import Airfoil, SectionTable, airfoil_names
from propmap.model.corrections import CORRECTIONS, apart, as_text, correction, corrections_of
from propmap.model.model import PAPER_DENSITY, PAPER_VISCOSITY, Air, Model, Propeller
from propmap.model.plausibility import doubts_on_air, doubts_on_blade, doubts_on_points
from propmap.tasks import InTurn, Workers
from propmap.typing import Floats

if TYPE_CHECKING:
    from propmap.model.model import Model
    from propmap.rotor import Rotor
    from propmap.typing import Floats


# -------------------------------------------------------------------------------------------------
# PROP and the options that choose a rotor, shared by the commands that compute loads.

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


# -------------------------------------------------------------------------------------------------
# Operating points as options of the command line.


def single_point(rpm: float, speed: float, beta: float, **further: float | None) -> OperatingPoints:
    """One checked operating point, with what of ``further`` variables is not None."""
    values = {"rpm": rpm, "speed": speed, "beta": beta}
    more = {name: value for name, value in further.items() if value is not None}
    checked = {k: np.array([check_value(k, v)]) for k, v in (values | more).items()}
    rpm_, speed_, beta_ = (checked.pop(name) for name in values)
    return OperatingPoints(rpm_, speed_, beta_, checked)


def parse_axis(option: str, quantity: str, text: str, count: int | None = None) -> Floats:
    """Rising values (n,) from "6000", "10,20" or "A:B:N", N values from A to B.

    ``option`` is its name in messages, ``count`` N where "A:B" is written, None to ask for it.
    """
    parts = text.split(":")
    form = "A:B:N" if count is None else "A:B or A:B:N"
    remedy = f"write a number, a list such as 10,20, or {form} (N values from A to B)"
    try:
        if len(parts) == 1:
            values = np.array([float(part) for part in text.split(",")])
        elif len(parts) == 3 or (len(parts) == 2 and count is not None):
            number = int(parts[2]) if len(parts) == 3 else int(count or 0)
            if not 2 <= number <= 1_000_000:
                raise InputError(f"{option} {text}: N is {number}", "use 2 to 1000000 values")
            values = np.linspace(float(parts[0]), float(parts[1]), number)
        else:
            raise ValueError
    except InputError:
        raise
    except (ValueError, OverflowError):
        raise InputError(f"{option} {text!r} cannot be read", remedy) from None
    for value in values.tolist():
        check_value(quantity, value)
    if any(b <= a for a, b in itertools.pairwise(values.tolist())):
        raise InputError(f"{option} {text}: the values do not rise", "write each once, rising")
    return values


# -------------------------------------------------------------------------------------------------
# Columns and cells of how sure the loads are.

Bands = Annotated[
    bool,
    typer.Option(
        "--bands/--no-bands",
        help="Standard deviations or bands of the loads, where the constants or the blade say "
        "how well they are known.",
    ),
]
StdBySource = Annotated[
    bool,
    typer.Option(
        "--std-by-source",
        help="Standard deviations by what they are from, too: parameters of the section law, "
        "geometry that was not measured, discrepancy of the model, another tunnel.",
    ),
]


def say_not_counted(model: Model) -> None:
    """Name constants of which the data of a fit said nothing, on standard error."""
    known = model.uncertainty
    if known is not None and known.covariance.unknown:
        names = ", ".join(known.covariance.unknown)
        typer.echo(
            f"note: standard deviations do not count {names}, of which the data of the fit say "
            "nothing",
            err=True,
        )


# -------------------------------------------------------------------------------------------------
# What is unlike small propellers or not measured, as notes beside the output of a command.


def say_doubts(doubts: Iterable[str]) -> None:
    """A line on standard error for each."""
    for doubt in doubts:
        typer.echo(f"note: {doubt}", err=True)


def say_expected(prop: str) -> None:
    """Say what a blade rests on that was not measured."""
    meant = meant_by(prop)
    if isinstance(meant, ExpectedBlade):
        typer.echo(f"note: {meant.told}", err=True)


def say_doubts_on_points(model: Model, omega: Floats, speed: Floats, beta: Floats) -> None:
    """Say what is odd about operating points [rad/s], [m/s], [rad], before loads are computed.

    Raises ``InputError`` where a blade tip is faster than sound.
    """
    say_doubts(doubts_on_points(model.propeller, omega, speed, beta))


# -------------------------------------------------------------------------------------------------
# ``--cluster``: who does the work, and how far it is.

Cluster = Annotated[
    str | None,
    typer.Option(
        "--cluster",
        metavar="local[:N]|tcp://HOST:PORT",
        help="Work on N processes of this machine, by default one per core, or on the workers of a "
        "Dask scheduler. Results are the same.",
    ),
]


@contextmanager
def workers_of(cluster: str | None, otherwise: Workers | None = None) -> Iterator[Workers]:
    """The workers that ``--cluster`` asks for; without it ``otherwise``, by default this process.

    A line on standard error says how many, and where their dashboard is.
    """
    if cluster is None:
        yield otherwise or InTurn()
        return
    from propmap.cluster import connected

    with connected(cluster) as workers:
        typer.echo(
            f"{workers.count} worker threads, dashboard at {workers.client.dashboard_link}",
            err=True,
        )
        yield workers


def workers_of_bootstrap(cluster: str | None, bootstrap: int) -> AbstractContextManager[Workers]:
    """The same for a fit, of which only the refits of ``bootstrap`` are independent tasks."""
    if cluster is not None and not bootstrap:
        raise InputError(
            "--cluster spreads the refits of --bootstrap, of which there are none",
            "give --bootstrap 200, or leave --cluster out",
        )
    return workers_of(cluster)


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on a terminal, told how much is done and of how much; with what is left."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left:"),
        TimeRemainingColumn(),
    )
    with Progress(
        *columns, console=console, disable=not console.is_terminal, transient=True
    ) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
