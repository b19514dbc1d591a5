"""Options that several commands share: rotor, aircraft, operating points and workers."""

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
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, cast, get_type_hints

import numpy as np
import typer
from typer import Argument, Option, echo

from propmap.bands import MEASURED_TO
from propmap.catalogue import lookup
from propmap.catalogue.expected import ExpectedBlade
from propmap.cli.output import note
from propmap.errors import InputError
from propmap.io.csv import OperatingPoints, check_value, read_lines
from propmap.io.geometry import blades_in_title, how_read
from propmap.model.air import PAPER_DENSITY, PAPER_VISCOSITY, Air
from propmap.model.airfoil import Airfoil, SectionLaw, SectionTable, airfoil_names
from propmap.model.corrections import (
    CORRECTIONS,
    as_text,
    correction,
    model_corrections,
    split_mount,
)
from propmap.model.model import Model
from propmap.model.plausibility import air_warnings, blade_warnings, point_warnings
from propmap.model.propeller import Propeller
from propmap.tasks import InTurn, Workers
from propmap.typing import Floats
from propmap.units import RPM

if TYPE_CHECKING:
    from propmap.aircraft.trim import Aircraft
    from propmap.rotor import Rotor
    from propmap.vehicle.files import VehicleFile
    from propmap.vehicle.vehicle import Vehicle


# --- PROP and the options that define the rotor --------------------------------------------------

SAME_BLADE = 0.02  # relative difference in radius and chord below which two blades are the same
Law = TypeVar("Law", bound=SectionLaw)

PROP_HELP = "Propeller: catalogue name, designation such as 'HQ 5x4.3x3', or geometry file."
BETA_HELP = "Angle beta between velocity and rotor axis"
AXIS_HELP = "N values from A to B, or a list such as 1,5,9"
PropArgument = Annotated[str, Argument(metavar="PROP", help=PROP_HELP)]
PropOption = Annotated[str, Option("--prop", metavar="PROP", help=PROP_HELP)]
Blades = Annotated[
    int | None,
    Option("--blades", metavar="N", help="Number of blades (default: from the catalogue or file)."),
]
Radius = Annotated[
    float | None, Option("--radius", help="Tip radius in m, if the file does not state it.")
]
RootCutout = Annotated[
    float | None, Option("--root-cutout", help="Radius in m at which the loads of the blade begin.")
]
Corrections = Annotated[
    list[str] | None,
    Option(
        "--correction",
        metavar="NAME[:FIELD=VALUE]",
        help="Correction to add to the model; may be repeated. To set a field: "
        f"hub-loss:radius_m=0.012. Names: {', '.join(CORRECTIONS)}.",
    ),
]
ModelName = Literal["recommended", "paper"]  # the keys of ``MODELS``
ModelOption = Annotated[
    ModelName | None,
    Option(
        "--model",
        help="Physical model. paper: exactly the model of Gill & D'Andrea 2017. recommended: also "
        "an inflow that varies around the disk (pitt-peters) and spanwise skin friction "
        "(radial-friction). Default: the model used to identify the section constants, or "
        "recommended if that model is not recorded.",
    ),
]
BareOption = Annotated[
    bool,
    Option(
        "--bare",
        help="Report the rotor drag of the bare blades. By default, the correction 'installed' "
        "models the rotor on a motor. Exceptions: --model paper, and an --airfoil that does "
        "not contain this correction.",
    ),
]
AccuracyName = Literal["standard", "fine"]
AirfoilOption = Annotated[
    str | None,
    Option(
        "--airfoil",
        metavar="NAME|FILE",
        help="Section law (airfoil model): a name that `propmap airfoils` lists, or a file: a fit "
        "or parameter set (.toml), or a table (AeroDyn, XFOIL file or folder, QBlade, CACTUS, "
        "CSV). Default: constants identified for the propeller, or else constants predicted from "
        "its family or from all propellers.",
    ),
]
FitAirfoilOption = Annotated[
    str | None,
    Option(
        "--airfoil",
        metavar="NAME|FILE",
        help="Values of the fixed section constants and start values of the free ones: a name that "
        "`propmap airfoils` lists, or a fit or parameter set (.toml). Default: the "
        "mean of the prior (--prior-from); without a prior, the first guess of the paper.",
    ),
]
AccuracyOption = Annotated[
    AccuracyName,
    Option(
        "--accuracy",
        help="Accuracy relative to static loads: standard 0.1 %, fine 0.01 % (slower).",
    ),
]


@dataclass(frozen=True)
class RotorChoice:
    """Choice of propeller, section law and air; each field becomes an option."""

    prop: PropArgument
    airfoil: AirfoilOption = None
    rho: Annotated[
        float | None, Option(help=f"Air density in kg/m^3 (default: {PAPER_DENSITY}).")
    ] = None
    mu: Annotated[
        float | None, Option(help=f"Viscosity of the air in Pa s (default: {PAPER_VISCOSITY}).")
    ] = None
    altitude: Annotated[
        float | None, Option(help="Use the standard atmosphere at this altitude in m.")
    ] = None
    temperature_offset: Annotated[
        float | None, Option(help="Temperature offset from the standard atmosphere in K.")
    ] = None
    model: ModelOption = None
    correction: Corrections = None
    bare: BareOption = False
    root_cutout: RootCutout = None
    blades: Blades = None
    radius: Radius = None
    accuracy: AccuracyOption = "standard"

    def rotor(self) -> Rotor:
        """Return the rotor, and print notes on assumptions and implausible values."""
        blade, air = self.blade(), self.medium()
        law = section_law(self.airfoil, self.prop, blade, self.blades)
        installed = False if self.bare else self.airfoil is None or None
        section = with_physics(law, self.model, self.correction, installed=installed)

        from propmap.rotor import Rotor

        return Rotor(Model(blade, section, air), accuracy=self.accuracy)

    def blade(self) -> Propeller:
        """Return the propeller, and print notes on assumptions and implausible values."""
        return propeller_noted(self.prop, self.blades, self.radius, self.root_cutout)

    def medium(self) -> Air:
        """Return the air, and print notes on implausible values."""
        stated = self.rho is not None or self.mu is not None
        if self.altitude is not None or self.temperature_offset is not None:
            if stated:
                found = "both the properties of the air and a standard atmosphere are given"
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
    """Read PROP, and print notes on its interpretation and on implausible values."""
    found = lookup.propeller(prop, blades, radius, root_cutout)
    note_reading(prop, found, blades)
    note(*blade_warnings(found))
    return found


def note_reading(prop: str, found: Propeller, asked: int | None = None) -> None:
    """Note how PROP was interpreted as ``found``, for the number of blades ``asked``."""
    meant = lookup.meant_by(prop, asked)
    if isinstance(meant, ExpectedBlade):
        note(meant.summary)
    elif meant is None:
        note(*how_read(prop, asked))
    in_title = blades_in_title(prop, read_lines(prop)) if meant is None else None
    if in_title not in (None, found.blades):
        whose = "the data of the file" if asked is None else "--blades"
        note(f"the title states {in_title} blades; {found.blades} are used, from {whose}")
    elif in_title is not None and asked is None:
        note(f"{in_title} blades, from the title of the file")


def section_law(
    asked: str | None, prop: str, blade: Propeller, blades: int | None = None
) -> Airfoil | SectionTable:
    """Return the law of ``--airfoil``; without it, note and return the law identified or predicted
    for PROP with the given number of ``blades``."""
    if asked is not None:
        note(*_of_another_propeller(asked, blade))
        return lookup.airfoil(asked)
    meant = lookup.meant_by(prop, blades)
    found = lookup.best_constants(meant, blade)
    if not (isinstance(meant, ExpectedBlade) and meant.own is None):
        # Otherwise the note on the blade already states the source of the constants.
        note(f"{found.summary}. --airfoil selects another law")
    return found.airfoil


def _of_another_propeller(asked: str, blade: Propeller) -> list[str]:
    """Return a remark if ``--airfoil`` names a fit to a propeller other than the ``blade``."""
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
    law: Law, model: ModelName | None, added: Sequence[str] | None, *, installed: bool | None = None
) -> Law:
    """Return the law with the corrections of ``--model`` and ``--correction``.

    If ``added`` contains no installation, ``installed`` decides: True adds a typical installation
    (not to the paper's model), False removes the law's installation, None keeps it.
    """
    own, more = law.corrections, [as_text(correction(text)) for text in added or ()]
    physics, mount = split_mount(more)
    if installed is False and own is not None:
        own, given = split_mount(own)[0], cast(Any, law)
        law = replace(given, corrections=own)
    typical = ["installed"] if installed and own else []
    if model is None and not physics and own is not None:
        return law.with_corrections([*split_mount(own)[0], *(mount or typical)])
    chosen = model_corrections(model or "recommended", more, installed=bool(installed))
    return law.with_corrections([as_text(value) for value in chosen])


def constants(name_or_path: str) -> Airfoil:
    """Return the constants that ``--airfoil`` names; raise ``InputError`` for a section table."""
    found = lookup.airfoil(name_or_path)
    if isinstance(found, SectionTable):
        fault = "this is a section table, but the command needs section constants such as c_l1"
        remedy = f"give one of {', '.join(airfoil_names())}, or a .toml file"
        raise InputError(fault, remedy, name_or_path)
    return found


def takes_choices(command: Callable[..., None], **changed: Any) -> Callable[..., None]:
    """Turn each field of a command's dataclass parameters into an option, or into the ``changed``
    option of this name; None omits a field."""
    own = inspect.signature(command, eval_str=True).parameters
    kinds: dict[str, Any] = {n: p.annotation for n, p in own.items() if is_dataclass(p.annotation)}
    plain = [one.replace(kind=one.KEYWORD_ONLY) for n, one in own.items() if n not in kinds]
    needed, shared = [], []
    for name, kind in kinds.items():
        types = get_type_hints(kind, include_extras=True) | changed
        for field in (one for one in fields(kind) if types[one.name] is not None):
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
            names = [field.name for field in fields(kind) if field.name in given]
            given[name] = kind(**{field: given.pop(field) for field in names})
        command(**given)

    parameters = [*needed, *plain, *shared]
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return run


# --- VEHICLE and the options that define the loads of its rotors ---------------------------------

VehicleArgument = Annotated[
    Path, Argument(metavar="VEHICLE.toml", help="Vehicle file with rotors and motors.")
]
VehicleOption = Annotated[Path, Option("--vehicle", metavar="VEHICLE.toml", help="Vehicle file.")]
VehicleOfLogs = Annotated[
    Path | None, Option("--vehicle", metavar="VEHICLE.toml", help="Vehicle file, for flight logs.")
]
MaximumRpm = Annotated[
    float | None, Option("--max-rpm", help="Maximum rotational speed of the rotors in rpm.")
]
Charge = Annotated[
    float,
    Option(
        "--charge",
        help="State of charge of the battery for top speed and thrust margin; 1 is full.",
    ),
]
NoWakes = Annotated[
    bool, Option("--no-wakes", help="Ignore the effect of rotor wakes on other rotors.")
]


def vehicle_of(path: Path, *, no_wakes: bool) -> VehicleFile:
    """Read a vehicle file, and print notes on implausible air; ``no_wakes`` removes the effect of
    the rotors on each other."""
    from propmap.vehicle.files import read_vehicle

    found = read_vehicle(path)
    note(*air_warnings(found.vehicle.air))
    return replace(found, vehicle=replace(found.vehicle, wakes=None)) if no_wakes else found


def aircraft_of(
    file: VehicleFile,
    airfoil: str | None,
    table: Path | None,
    model: ModelName | None,
    correction: list[str] | None,
    accuracy: AccuracyName = "standard",
    maximum_rpm: float | None = None,
    charge: float = 1.0,
) -> Aircraft:
    """Return the aircraft, with loads from a table or from a rotor in the vehicle's air."""
    limits = {"maximum_rotor_speed": checked_rpm(maximum_rpm), "charge": charge}
    vehicle = file.vehicle
    from propmap.aircraft.trim import Aircraft

    if table is not None:
        if airfoil or model or correction:
            fault = "--table is given with --airfoil, --model or --correction"
            raise InputError(fault, "leave these out: the table already contains a section law")
        from propmap.table.query import LoadTable

        return Aircraft(vehicle, LoadTable.load(table), **limits)
    blade = vehicle.propeller
    note_reading(file.propeller, blade, file.blades)
    note(*blade_warnings(blade))
    law = section_law(airfoil, file.propeller, blade, file.blades)
    law = with_physics(law, model, correction, installed=airfoil is None or None)
    refuse_two_mounts(vehicle, correction)

    from propmap.rotor import Rotor

    return Aircraft(vehicle, Rotor(Model(blade, law, vehicle.air), accuracy=accuracy), **limits)


def refuse_two_mounts(vehicle: Vehicle, added: Sequence[str] | None) -> None:
    """Raise ``InputError`` if the vehicle and ``--correction`` both specify the rotor mounts."""
    if any(mount.drag for mount in vehicle.mounts) and split_mount(added or ())[1]:
        found = "--correction installed is given, but the vehicle file has [mount]"
        raise InputError(found, "remove one of the two")


def checked_rpm(maximum: float | None) -> float:
    """Return ``--max-rpm`` in rad/s, or infinity without the option."""
    if maximum is None:
        return math.inf
    if not 0.0 < maximum < math.inf:
        raise InputError(f"--max-rpm is {maximum:g}", "give revolutions per minute, above 0")
    return maximum * RPM


# --- Operating points, and the standard deviations of their loads --------------------------------


def single_point(rpm: float, speed: float, beta: float, **further: float | None) -> OperatingPoints:
    """Return one checked operating point [1/min], [m/s], [deg] with ``further`` quantities."""

    def checked(name: str, value: float) -> Floats:
        return np.array([check_value(name, value)])

    more = {name: checked(name, v) for name, v in further.items() if v is not None}
    w, v, b = (checked(*one) for one in (("rpm", rpm), ("speed", speed), ("beta", beta)))
    return OperatingPoints(w, v, b, more)


def parse_axis(option: str, quantity: str, text: str, count: int | None = None) -> Floats:
    """Read increasing values (n,) from "6000", "10,20" or "A:B:N" (N values from A to B); "A:B"
    needs a ``count``, and messages name the ``option``."""
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
        raise InputError(f"{option} {text}: the values do not increase", "give increasing values")
    return values


def note_points(model: Model, omega: Floats, speed: Floats, beta: Floats) -> None:
    """Note points [rad/s], [m/s], [rad] that are implausible or beyond the data of the section
    constants; raise ``InputError`` for a supersonic blade tip."""
    if np.any(omega < 0.0):
        note(
            "negative rpm: the propeller turns backward, and its thrust changes sign; no "
            "measurement confirms these loads; for both spins (cw, ccw), give a positive rpm"
        )
        omega = np.abs(omega)
    note_reynolds(model, omega, speed, beta)
    note(*point_warnings(model.propeller, omega, speed, beta))
    known = model.uncertainty
    if known is not None and known.envelope is not None:
        omega, speed, beta = (np.ravel(a) for a in np.broadcast_arrays(omega, speed, beta))
        flow = omega, speed * np.cos(beta), speed * np.abs(np.sin(beta))
        note(*known.envelope.beyond(*flow, model.propeller.radius).sentences())


def note_reynolds(model: Model, omega: Floats, speed: Floats, beta: Floats) -> None:
    """Note operating points [rad/s], [m/s], [rad] outside the range of a section table."""
    if not isinstance(model.airfoil, SectionTable):
        return
    points = np.broadcast_arrays(omega, speed, beta)
    some = np.unique(np.linspace(0, points[0].size - 1, 400).astype(int))
    low, high = model.reynolds(*(values.ravel()[some] for values in points))
    first, last = model.airfoil.reynolds[[0, -1]]
    if low < first or high > last:
        covered = f"covers {first:.2g} to {last:.2g}; outside, its nearest row is used"
        if first == last:
            covered = "has one Reynolds number, which is used everywhere"
        note(f"Re is {low:.2g} to {high:.2g} along the blade; the table {covered}")


Bands = Annotated[
    bool,
    Option(
        "--bands/--no-bands",
        help="Show standard deviations of the loads, if the section constants or the blade have "
        "an uncertainty.",
    ),
]
StdBySource = Annotated[
    bool,
    Option(
        "--std-by-source",
        help="Also show the standard deviations by source: section constants, unmeasured blade "
        "geometry, errors of the model, differences between tunnels, installation.",
    ),
]


def check_bands(bands: bool, by_source: bool) -> None:
    """Raise ``InputError`` for ``--std-by-source`` without standard deviations."""
    if by_source and not bands:
        raise InputError("--std-by-source is given with --no-bands", "leave out one of them")


def note_not_counted(model: Model) -> None:
    """Note constants that the fit does not determine and the standard deviations exclude."""
    known = model.uncertainty
    if known is not None and known.covariance.unknown:
        names = ", ".join(known.covariance.unknown)
        note(f"standard deviations exclude {names}: the data of the fit do not determine them")


def note_untested_bands(model: Model, omega: Floats, speed: Floats, beta: Floats) -> None:
    """Note points where bands were not compared with data: in descent and above ``MEASURED_TO``."""
    known = model.uncertainty
    if known is None or not known.another_tunnel:
        return
    along, across = speed * np.cos(beta), speed * np.abs(np.sin(beta))
    fast = across > MEASURED_TO * omega * model.propeller.radius
    places = [f"at V sin(beta)/(Omega R) above {MEASURED_TO:g}"] if fast.any() else []
    if (along < -1e-9 * speed).any():
        places.append("in descent")
    if places:
        note(f"the bands were not compared with measurements {' and '.join(places)}")


# --- The command line as typed, and the workers of ``--cluster`` ---------------------------------


def command_line(context: typer.Context) -> str:
    """Return the command as typed, for the metadata of output files."""
    return shlex.join(["propmap", *context.obj])


Cluster = Annotated[
    str | None,
    Option(
        "--cluster",
        metavar="local[:N]|tcp://HOST:PORT",
        help="Compute in N processes on this computer (default: one per core), or on the workers "
        "of a Dask scheduler. The choice does not change the results.",
    ),
]


@contextmanager
def workers_of(cluster: str | None, otherwise: Workers | None = None) -> Iterator[Workers]:
    """Connect to the workers of ``--cluster``; without it, yield ``otherwise`` or this process."""
    if cluster is None:
        yield otherwise or InTurn()
        return
    from propmap.cluster import connected

    with connected(cluster) as workers:
        link = workers.client.dashboard_link
        echo(f"{workers.count} worker threads, dashboard at {link}", err=True)
        yield workers


def workers_of_bootstrap(cluster: str | None, bootstrap: int) -> AbstractContextManager[Workers]:
    """Connect like ``workers_of``, for a fit, whose only independent tasks are its refits."""
    if cluster is not None and not bootstrap:
        found = "--cluster distributes only the refits of --bootstrap, and there are none"
        raise InputError(found, "give --bootstrap 200, or leave --cluster out")
    return workers_of(cluster)
