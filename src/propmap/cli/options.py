"""Options that commands share, and what they describe: rotor, aircraft, points, workers."""

from __future__ import annotations

import functools
import inspect
import itertools
import math
import shlex
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, get_type_hints

import numpy as np
import typer
from typer import Argument, Option, echo

from propmap import catalogue
from propmap.bands import MEASURED_TO
from propmap.catalogue import lookup
from propmap.catalogue.expected import ExpectedBlade
from propmap.cli.output import note
from propmap.errors import InputError
from propmap.io.csv import OperatingPoints, check_value, read_lines
from propmap.io.geometry import blades_in_title, how_read
from propmap.model.air import PAPER_DENSITY, PAPER_VISCOSITY, Air
from propmap.model.airfoil import Airfoil, SectionLaw, SectionTable, airfoil_names
from propmap.model.corrections import CORRECTIONS, as_text, correction, corrections_of, split_mount
from propmap.model.model import Model
from propmap.model.plausibility import air_warnings, blade_warnings, point_warnings
from propmap.model.propeller import Propeller
from propmap.tasks import InTurn, Workers
from propmap.typing import Floats
from propmap.units import RPM

if TYPE_CHECKING:
    from propmap.aircraft.trim import Aircraft
    from propmap.rotor import Rotor
    from propmap.vehicle.vehicle import Vehicle


# -------------------------------------------------------------------------------------------------
# PROP and the options that choose a rotor.

SAME_BLADE = 0.02  # share within which radius and chord are those of one blade
Law = TypeVar("Law", bound=SectionLaw)

PROP_HELP = "Name in the catalogue, designation such as 'HQ 5x4.3x3', or geometry file."
PropArgument = Annotated[str, Argument(metavar="PROP", help=PROP_HELP)]
PropOption = Annotated[str, Option("--prop", metavar="PROP", help=PROP_HELP)]
Blades = Annotated[int | None, Option("--blades", metavar="N", help="Number of blades.")]
Radius = Annotated[
    float | None, Option("--radius", help="Tip radius [m], where the file gives none.")
]
RootCutout = Annotated[
    float | None, Option("--root-cutout", help="Radius where the loaded blade begins [m].")
]
Corrections = Annotated[
    list[str] | None,
    Option(
        "--correction",
        metavar="NAME[:FIELD=VALUE]",
        help=f"Add a correction to the model: {', '.join(CORRECTIONS)} (a field as in "
        "hub-loss:radius_m=0.012); may be repeated.",
    ),
]
ModelName = Literal["recommended", "paper"]  # the keys of ``MODELS``
ModelOption = Annotated[
    ModelName | None,
    Option(
        "--model",
        help="Physics: recommended is the paper's with an inflow that varies around the disk "
        "(pitt-peters) and friction along the flow (radial-friction), paper is Gill & D'Andrea "
        "2017 to the letter. By default the one with which the section law's constants were found, "
        "else recommended.",
    ),
]
BareOption = Annotated[
    bool,
    Option(
        "--bare",
        help="Give the rotor drag of the blades alone. By default a propeller by name is installed "
        "as rotors on motors are, with the correction installed, except with --model paper.",
    ),
]
AccuracyName = Literal["standard", "fine"]
AirfoilOption = Annotated[
    str | None,
    Option(
        "--airfoil",
        metavar="NAME|FILE",
        help="Section law: a name of propmap airfoils, a fit or parameter set (.toml), or a "
        "section table of AeroDyn, XFOIL (a file or a folder), CACTUS or CSV. By default the "
        "constants identified for the propeller, else those predicted from its family or from all "
        "propellers; a fit starts from the paper's first guess.",
    ),
]
AccuracyOption = Annotated[
    AccuracyName,
    Option("--accuracy", help="Compute loads to 0.1 % (standard) or to 0.01 %, slower."),
]


@dataclass(frozen=True)
class RotorChoice:
    """The propeller, section law and air that a user asked for; its fields become options."""

    prop: PropArgument
    airfoil: AirfoilOption = None
    rho: Annotated[float | None, Option(help=f"Air density [kg/m^3], else {PAPER_DENSITY}.")] = None
    mu: Annotated[float | None, Option(help=f"Viscosity [Pa s], else {PAPER_VISCOSITY}.")] = None
    altitude: Annotated[
        float | None, Option(help="Take the standard atmosphere's air at this height [m].")
    ] = None
    temperature_offset: Annotated[
        float | None, Option(help="Difference from the standard atmosphere's [K].")
    ] = None
    model: ModelOption = None
    correction: Corrections = None
    bare: BareOption = False
    root_cutout: RootCutout = None
    blades: Blades = None
    radius: Radius = None
    accuracy: AccuracyOption = "standard"

    def rotor(self) -> Rotor:
        """Make the rotor; notes say what is assumed and what is implausible about it."""
        blade, air = self.blade(), self.medium()
        law = section_law(self.airfoil, self.prop, blade, self.blades)
        by_name = self.airfoil is None and not self.bare
        section = with_physics(law, self.model, self.correction, installed=by_name)

        from propmap.rotor import Rotor

        return Rotor(Model(blade, section, air), accuracy=self.accuracy)

    def blade(self) -> Propeller:
        """Read the propeller; notes say what is assumed and what is implausible about it."""
        return propeller_noted(self.prop, self.blades, self.radius, self.root_cutout)

    def medium(self) -> Air:
        """Make the air; notes say what is implausible about its figures."""
        stated = self.rho is not None or self.mu is not None
        if self.altitude is not None or self.temperature_offset is not None:
            if stated:
                found = "the air is given twice, by its figures and by the standard atmosphere"
                remedy = "give --rho and --mu, or --altitude and --temperature-offset"
                raise InputError(found, remedy)
            return Air.standard(self.altitude or 0.0, self.temperature_offset or 0.0)
        density = PAPER_DENSITY if self.rho is None else self.rho
        air = Air(density, PAPER_VISCOSITY if self.mu is None else self.mu)
        note(*air_warnings(air))
        return air


def propeller_noted(
    prop: str,
    blades: int | None = None,
    radius: float | None = None,
    root_cutout: float | None = None,
) -> Propeller:
    """Read PROP, with notes on how, on a blade not measured and on what is implausible."""
    found = lookup.propeller(prop, blades, radius, root_cutout)
    note_reading(prop, found, blades)
    note(*blade_warnings(found))
    return found


def note_reading(prop: str, found: Propeller, asked: int | None = None) -> None:
    """Note how PROP, no name of the catalogue, was read as ``found`` with ``asked`` blades."""
    meant = lookup.meant_by(prop, asked)
    if isinstance(meant, ExpectedBlade):
        note(meant.summary)
    elif meant is None:
        note(*how_read(prop, asked))
    in_title = blades_in_title(prop, read_lines(prop)) if meant is None else None
    if in_title not in (None, found.blades):
        whose = "the file has" if asked is None else "--blades says"
        note(f"its title tells of {in_title} blades; {found.blades} are taken, as {whose}")
    elif in_title is not None and asked is None:
        note(f"{in_title} blades, as its title tells")


def section_law(
    asked: str | None, prop: str, blade: Propeller, blades: int | None = None
) -> Airfoil | SectionTable:
    """Find the law that ``--airfoil`` asks for, else with a note that identified or predicted for
    PROP with so many ``blades`` as were asked for."""
    if asked is not None:
        note(*_of_another_propeller(asked, blade))
        return lookup.airfoil(asked)
    meant = lookup.meant_by(prop, blades)
    found = lookup.own_constants(meant, blade.blades) or lookup.predicted_constants(meant, blade)
    if not (isinstance(meant, ExpectedBlade) and meant.own is None):
        # Else the note on the blade has said what the constants rest on too.
        note(f"{found.summary}; another law by --airfoil")
    return found.airfoil


def _of_another_propeller(asked: str, blade: Propeller) -> list[str]:
    """Remark that ``--airfoil`` asks for a fit to another propeller than the ``blade``."""
    path = Path(asked)
    if path.suffix.lower() != ".toml" or not path.is_file():
        return []
    from propmap.fit.files import is_fit, read_fit

    if not is_fit(path):
        return []
    fitted = read_fit(path).record.propeller.propeller()
    own, mine = ((one.radius, one.blades, one.chord.max()) for one in (fitted, blade))
    if np.allclose(own, mine, rtol=SAME_BLADE):
        return []
    whose = f"{fitted.name}, {fitted.summary}"
    return [f"the constants of {asked} were fitted to another propeller: {whose}"]


def with_physics(
    law: Law, model: ModelName | None, added: Sequence[str] | None, *, installed: bool = False
) -> Law:
    """Return the law with what ``--model`` and ``--correction`` ask for, see ``corrections_of``."""
    own, more = law.corrections, [as_text(correction(text)) for text in added or ()]
    physics, mount = split_mount(more)
    if model is None and not physics and own is not None:
        return law.with_corrections([*split_mount(own)[0], *mount])
    chosen = corrections_of(model or "recommended", more, installed=installed)
    return law.with_corrections([as_text(value) for value in chosen])


def constants(name_or_path: str) -> Airfoil:
    """Read the constants that ``--airfoil`` names; ``InputError`` for a section table."""
    found = lookup.airfoil(name_or_path)
    if isinstance(found, SectionTable):
        fault = "this is a section table, which has no constants such as c_l1 to fit or to fly with"
        remedy = f"give one of {', '.join(airfoil_names())}, or a .toml file"
        raise InputError(fault, remedy, name_or_path)
    return found


def takes_choices(command: Callable[..., None], prop: Any = PropArgument) -> Callable[..., None]:
    """Give a command the fields of its parameters that are dataclasses as options, by default as in
    such a parameter's default; ``prop``, of ``RotorChoice``, is an argument or an option."""
    own = inspect.signature(command, eval_str=True).parameters
    kinds: dict[str, Any] = {n: p.annotation for n, p in own.items() if is_dataclass(p.annotation)}
    plain = [one.replace(kind=one.KEYWORD_ONLY) for n, one in own.items() if n not in kinds]
    needed, shared = [], []
    for name, kind in kinds.items():
        types = get_type_hints(kind, include_extras=True) | {"prop": prop}
        for field in fields(kind):
            default = getattr(own[name].default, field.name, field.default)
            option = inspect.Parameter(
                field.name, inspect.Parameter.KEYWORD_ONLY, annotation=types[field.name]
            )
            if default is MISSING:
                needed.append(option)
            else:
                shared.append(option.replace(default=default))

    @functools.wraps(command)
    def run(**given: Any) -> None:
        for name, kind in kinds.items():
            given[name] = kind(**{field.name: given.pop(field.name) for field in fields(kind)})
        command(**given)

    parameters = [*needed, *plain, *shared]
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return run


# -------------------------------------------------------------------------------------------------
# VEHICLE and the options that choose the loads of its rotors.

VehicleArgument = Annotated[
    Path, Argument(metavar="VEHICLE.toml", help="Vehicle file with rotors and motors.")
]
VehicleOption = Annotated[Path, Option("--vehicle", metavar="VEHICLE.toml", help="Vehicle file.")]
VehicleOfLogs = Annotated[
    Path | None, Option("--vehicle", metavar="VEHICLE.toml", help="Vehicle file, for flight logs.")
]
MaximumRpm = Annotated[
    float | None, Option("--max-rpm", help="Largest speed of the rotors [1/min].")
]
Charge = Annotated[
    float, Option("--charge", help="State of charge at which limits hold, 1 when full.")
]
NoWakes = Annotated[
    bool, Option("--no-wakes", help="Leave out what the rotors' wakes do to each other.")
]


def vehicle_of(path: Path, *, no_wakes: bool) -> Vehicle:
    """Read a vehicle; with ``no_wakes`` its rotors do not act on each other."""
    from propmap.vehicle.files import read_vehicle

    found = read_vehicle(path).vehicle
    return replace(found, wakes=None) if no_wakes else found


def aircraft_of(
    vehicle: Vehicle,
    airfoil: str | None,
    table: Path | None,
    model: ModelName | None,
    correction: list[str] | None,
    accuracy: AccuracyName = "standard",
    maximum_rpm: float | None = None,
    charge: float = 1.0,
) -> Aircraft:
    """Make the aircraft, with loads from a table or from a rotor in the vehicle's air."""
    limits = {"maximum_rotor_speed": checked_rpm(maximum_rpm), "charge": charge}
    from propmap.aircraft.trim import Aircraft

    if table is not None:
        if airfoil or model or correction:
            fault = "--table is given with --airfoil, --model or --correction"
            raise InputError(fault, "leave these out: the table was built with its own")
        from propmap.table.query import LoadTable

        return Aircraft(vehicle, LoadTable.load(table), **limits)
    blade = vehicle.propeller
    # A name that is not in the catalogue is of a file, written so that it is taken for one.
    name = blade.name if blade.name in catalogue.names() else f"./{blade.name}"
    law = section_law(airfoil, name, blade)
    law = with_physics(law, model, correction, installed=airfoil is None)

    from propmap.rotor import Rotor

    return Aircraft(vehicle, Rotor(Model(blade, law, vehicle.air), accuracy=accuracy), **limits)


def checked_rpm(maximum: float | None) -> float:
    """Return ``--max-rpm`` in rad/s, infinite where it is not given."""
    if maximum is None:
        return math.inf
    if not 0.0 < maximum < math.inf:
        raise InputError(f"--max-rpm is {maximum:g}", "give revolutions per minute, above 0")
    return maximum * RPM


# -------------------------------------------------------------------------------------------------
# Operating points, and how sure their loads are.


def single_point(rpm: float, speed: float, beta: float, **further: float | None) -> OperatingPoints:
    """Check one operating point [1/min], [m/s], [deg], with those ``further`` given."""

    def checked(name: str, value: float) -> Floats:
        return np.array([check_value(name, value)])

    more = {name: checked(name, v) for name, v in further.items() if v is not None}
    w, v, b = (checked(*one) for one in (("rpm", rpm), ("speed", speed), ("beta", beta)))
    return OperatingPoints(w, v, b, more)


def parse_axis(option: str, quantity: str, text: str, count: int | None = None) -> Floats:
    """Read rising values (n,) from "6000", "10,20" or "A:B:N", N values from A to B; ``count`` is
    the N of "A:B", refused without it, and messages name the ``option``."""
    parts = text.split(":")
    form = "A:B:N" if count is None else "A:B or A:B:N"
    remedy = f"write a number, a list such as 10,20, or {form} (N values from A to B)"
    try:
        if len(parts) == 1:
            values = np.array([float(part) for part in text.split(",")])
        elif len(parts) == 3 or (len(parts) == 2 and count is not None):
            number = int(parts[2]) if len(parts) == 3 else int(count or 0)
            ends = float(parts[0]), float(parts[1])
            values = np.linspace(*ends, number) if 2 <= number <= 1_000_000 else np.empty(0)
        else:
            raise ValueError
    except (ValueError, OverflowError):
        raise InputError(f"{option} {text!r} cannot be read", remedy) from None
    if not values.size:
        raise InputError(f"{option} {text}: N is {number}", "use 2 to 1000000 values")
    for value in values.tolist():
        check_value(quantity, value)
    if any(b <= a for a, b in itertools.pairwise(values.tolist())):
        raise InputError(f"{option} {text}: the values do not rise", "write each once, rising")
    return values


def note_points(model: Model, omega: Floats, speed: Floats, beta: Floats) -> None:
    """Note what is implausible about points [rad/s], [m/s], [rad] and how far they are beyond the
    constants' data; ``InputError`` where a blade tip is faster than sound."""
    note_reynolds(model, omega, speed, beta)
    note(*point_warnings(model.propeller, omega, speed, beta))
    known = model.uncertainty
    if known is not None and known.envelope is not None:
        omega, speed, beta = (np.ravel(a) for a in np.broadcast_arrays(omega, speed, beta))
        flow = omega, speed * np.cos(beta), speed * np.abs(np.sin(beta))
        note(*known.envelope.beyond(*flow, model.propeller.radius).sentences())


def note_reynolds(model: Model, omega: Floats, speed: Floats, beta: Floats) -> None:
    """Note where a section table does not reach at operating points [rad/s], [m/s], [rad]."""
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
        note(f"Re from {low:.2g} to {high:.2g} along the blade; the table {covered}")


Bands = Annotated[
    bool,
    Option(
        "--bands/--no-bands",
        help="Show standard deviations of the loads, where the constants or the blade say how "
        "well they are known.",
    ),
]
StdBySource = Annotated[
    bool,
    Option(
        "--std-by-source",
        help="Show standard deviations by source, too: parameters of the section law, geometry "
        "that was not measured, discrepancy of the model, another tunnel.",
    ),
]


def note_not_counted(model: Model) -> None:
    """Note which constants the standard deviations leave out: the fit's data do not show them."""
    known = model.uncertainty
    if known is not None and known.covariance.unknown:
        names = ", ".join(known.covariance.unknown)
        note(f"standard deviations do not count {names}, of which the data of the fit say nothing")


def note_untested_bands(model: Model, omega: Floats, speed: Floats, beta: Floats) -> None:
    """Note where bands were not compared with data: in descent, and above ``MEASURED_TO``."""
    known = model.uncertainty
    if known is None or not known.another_tunnel:
        return
    along, across = speed * np.cos(beta), speed * np.abs(np.sin(beta))
    fast = across > MEASURED_TO * omega * model.propeller.radius
    places = [f"at V sin(beta)/(Omega R) above {MEASURED_TO:g}"] if fast.any() else []
    if (along < -1e-9 * speed).any():
        places.append("in descent")
    if places:
        note(f"no measurement was compared with the bands {' and '.join(places)}")


# -------------------------------------------------------------------------------------------------
# The command line as it was given, and ``--cluster``: who does the work, and how far it is.


def command_line(context: typer.Context) -> str:
    """Write the command as it was typed, for files that say what made them."""
    return shlex.join(["propmap", *context.obj])


Cluster = Annotated[
    str | None,
    Option(
        "--cluster",
        metavar="local[:N]|tcp://HOST:PORT",
        help="Work on N processes of this machine, by default one per core, or on the workers of a "
        "Dask scheduler. Results do not depend on it.",
    ),
]


@contextmanager
def workers_of(cluster: str | None, otherwise: Workers | None = None) -> Iterator[Workers]:
    """Connect to the workers of ``--cluster``; without it give ``otherwise`` or this process."""
    if cluster is None:
        yield otherwise or InTurn()
        return
    from propmap.cluster import connected

    with connected(cluster) as workers:
        link = workers.client.dashboard_link
        echo(f"{workers.count} worker threads, dashboard at {link}", err=True)
        yield workers


def workers_of_bootstrap(cluster: str | None, bootstrap: int) -> AbstractContextManager[Workers]:
    """Connect as ``workers_of`` does for a fit, whose only independent tasks are its refits."""
    if cluster is not None and not bootstrap:
        found = "--cluster spreads the refits of --bootstrap, of which there are none"
        raise InputError(found, "give --bootstrap 200, or leave --cluster out")
    return workers_of(cluster)
