"""What exports share: files all or none, templates, names, provenance, notes on errors."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import propmap
from propmap.errors import InputError
from propmap.io.csv import replacing
from propmap.loads import LOADS, error_scales
from propmap.table.interpolation import VORTEX_RING
from propmap.table.query import LoadTable
from propmap.typing import Floats
from propmap.units import DEGREE, RPM
from propmap.vehicle.vehicle import Vehicle

# -------------------------------------------------------------------------------------------------
# Several files at once, all of them or none.

Files = Mapping[str, str | Callable[[Path], None]]
"""What to write: by name, a text or a function that writes to the path that it is given."""


def check_folder(folder: Path) -> None:
    """Raise ``InputError`` where no files can be written to ``folder``, made if need be."""
    where = str(folder)
    try:
        if not folder.exists():
            parent = folder.parent
            if not parent.is_dir():
                raise InputError(
                    f"there is no folder {str(parent)!r}", "make it or choose another", where
                )
            writable = os.access(parent, os.W_OK)
        elif not folder.is_dir():
            raise InputError("this is a file", "name a folder to write into", where)
        else:
            writable = os.access(folder, os.W_OK)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"not a path: {error}", "choose another name", where) from None
    if not writable:
        raise InputError("the folder cannot be written to", "choose another", where)


def write_files(files: Files, folder: Path, *, replace: bool) -> list[Path]:
    """Write files into a folder, which is made if need be; their paths.

    Without ``replace``, files that are there already raise ``InputError``.  All are complete
    before the first gets its name.
    """
    check_folder(folder)
    paths = [folder / name for name in files]
    for path in paths:
        if path.is_dir():
            raise InputError("this is a folder", "choose another folder to write into", str(path))
        if path.exists() and not replace:
            raise InputError("the file exists", "pass --force to replace it", str(path))
    made = not folder.exists()
    folder.mkdir(exist_ok=True)
    try:
        with ExitStack() as stack:
            for path, content in zip(paths, files.values(), strict=True):
                part = stack.enter_context(replacing(path))
                if isinstance(content, str):
                    part.write_text(content, encoding="utf-8", newline="")
                else:
                    content(part)
    except BaseException:
        if made:
            folder.rmdir()
        raise
    return paths


# -------------------------------------------------------------------------------------------------
# Text from the templates in ``templates/``: sources, notes, and the comments in them.


def rendered(template: str, table: LoadTable, **values: Any) -> str:
    """Text of a template; ``values`` that are functions serve as filters.

    Every template knows the table, the registry's ``loads``, the name ``p`` of the propeller and
    that name in capitals, ``P``, and the ``lines`` of the provenance.
    """
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"),
        variable_start_string="@",
        variable_end_string="@",
        line_statement_prefix="%%",
        undefined=StrictUndefined,
        keep_trailing_newline=True,
    )
    filters: dict[str, Callable[..., str]] = {
        "c_comment": c_comment,
        "hash_comment": hash_comment,
        "xml_comment": xml_comment,
    }
    environment.filters |= filters | {k: v for k, v in values.items() if callable(v)}
    name = identifier(table)
    common = {"table": table, "loads": LOADS, "p": name, "P": name.upper()}
    found = environment.get_template(f"{template}.j2")
    return found.render(**common, lines=provenance(table), **values)


def c_comment(lines: Sequence[str]) -> str:
    """Lines for the inside of a C comment."""
    return "\n".join(f" * {line.replace('*/', '* /')}".rstrip() for line in lines)


def xml_comment(lines: Sequence[str]) -> str:
    """Lines as an XML comment, inside which two hyphens must not occur."""
    text = "\n".join(f"  {line}" for line in lines)
    return f"<!--\n{re.sub('-(?=-)', '- ', text)}\n-->"


def hash_comment(lines: Sequence[str]) -> str:
    """Lines as a Python comment."""
    return "\n".join(f"# {line}".rstrip() for line in lines)


# -------------------------------------------------------------------------------------------------
# Where an export comes from, as lines for notes and comments.

ABSENT = "not stated"


def identifier(table: LoadTable) -> str:
    """The propeller's name as one that programs and file systems accept."""
    name = re.sub(r"[^0-9a-z]+", "_", str(table.info["propeller"].get("name")).lower()).strip("_")
    return name if name[:1].isalpha() else f"prop_{name}".rstrip("_")


def vehicle_identifier(vehicle: Vehicle) -> str:
    """The name of a ``vehicle`` as one that file systems accept."""
    return re.sub(r"[^0-9a-z]+", "_", vehicle.name.lower()).strip("_") or "vehicle"


def vehicle_name(vehicle: Vehicle, table: LoadTable) -> str:
    """The same for programs, and another than that of the propeller of a ``table``."""
    name = vehicle_identifier(vehicle)
    name = name if name[0].isalpha() else f"vehicle_{name}"
    return f"{name}_vehicle" if name == identifier(table) else name


def map_sha256(table: LoadTable) -> str:
    """SHA-256 of the map's numbers: axes, envelope, coefficients and cells, little-endian."""
    content = table.content
    axes = (content.advance, content.beta, content.omega, content.speed)
    digest = hashlib.sha256(np.concatenate(axes).astype("<f8").tobytes())
    digest.update(content.coefficients.astype("<f4").tobytes())
    digest.update(content.cells.tobytes())
    return digest.hexdigest()


def provenance(table: LoadTable) -> list[str]:
    """Printable lines: where the map comes from, and what wrote the export."""
    return [*origin(table), f"written by propmap {propmap.__version__}"]


def origin(table: LoadTable) -> list[str]:
    """Printable lines: propeller, section law, corrections, air, envelope, certificate, map."""
    info, content = table.info, table.content
    blade, section = info["propeller"], info.get("airfoil") or {}
    (w0, w1), (v0, v1), (b0, b1) = table.envelope.values()
    lines = [
        f"propeller: {blade.get('name', ABSENT)}, {blade.get('blades', ABSENT)} blades, "
        f"R = {content.radius:.6g} m, from {blade.get('source') or ABSENT}",
        f"section law: {section.get('name', ABSENT)}",
        f"corrections: {', '.join(info.get('corrections') or ['none'])}",
        f"air: {content.density:.6g} kg/m^3, viscosity "
        f"{info['air'].get('viscosity_Pa_s', ABSENT)} Pa s",
        f"envelope: {w0 / RPM:.6g} to {w1 / RPM:.6g} rpm, {v0:g} to {v1:g} m/s, "
        f"beta {b0 / DEGREE:.6g} to {b1 / DEGREE:.6g} deg",
        f"map: {_certified(table)}",
        *_of_parameters(table),
        f"map built: {info.get('created', ABSENT)}, propmap {info.get('propmap_version', ABSENT)}",
        f"map's SHA-256: {map_sha256(table)}",
    ]
    clean = ("".join(c if c.isprintable() else "?" for c in line) for line in lines)
    return [part for line in clean for part in textwrap.wrap(line, 88, subsequent_indent="  ")]


def _certified(table: LoadTable) -> str:
    found = table.certificate
    if not found:
        return "not certified"
    worst, loose = (max(found[key].values()) for key in ("max_error", "unresolved_max_error"))
    told = f"within {worst:.2%} of the model on {found['points']} points"
    if not found["unresolved_cells"]:
        return told
    return (
        f"{told}, and within {loose:.2%} on {found['unresolved_points']} points of the cells "
        f"marked unresolved, {found['unresolved_volume']:.2%} of the envelope"
    )


def _of_parameters(table: LoadTable) -> list[str]:
    """What the section law's covariance means for the loads, if the map says it."""
    found = table.info.get("parameter_uncertainty")
    if not found:
        return []
    each = (f"{LOADS[load].label} {share:.2%}" for load, share in found["median"].items())
    return [
        f"section law known to one standard deviation of: {', '.join(each)} of static, in the "
        "median over the envelope"
    ]


# -------------------------------------------------------------------------------------------------
# Values as the Python text that makes them again, for exported modules.


def literal(value: Any) -> str:
    """The text of an expression that is ``value``: a dataclass, a tuple, an array, a number.

    Classes stand by their names alone; fields that are as by default are left out.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        parts = [
            f"{field.name}={literal(getattr(value, field.name))}"
            for field in dataclasses.fields(value)
            if not _by_default(field, getattr(value, field.name))
        ]
        return f"{type(value).__name__}({', '.join(parts)})"
    if isinstance(value, tuple):
        return f"({''.join(f'{literal(each)}, ' for each in value).strip()})"
    if isinstance(value, np.ndarray):
        return repr(value.tolist())
    return repr(value)


def _by_default(field: Any, value: Any) -> bool:
    if field.default_factory is not dataclasses.MISSING:
        return bool(value == field.default_factory())
    return field.default is not dataclasses.MISSING and bool(value == field.default)


# -------------------------------------------------------------------------------------------------
# The note that goes with an export: what the target can represent, and at what cost.

SHARES = ", ".join(load.share for load in LOADS.values())


def note(table: LoadTable, target: str, found: Sequence[Errors] = (), **values: Any) -> str:
    """The text of a note.

    Parameters
    ----------
    table : LoadTable
        The map.
    target : str
        Names the template, ``README-<target>.txt.j2``.
    found : sequence of Errors
        What the target's model costs; none where nothing is simplified.
    **values
        For the template.
    """
    text = rendered(f"README-{target}.txt", table, simple=SIMPLE, **values)
    parts = [f"propmap export: {target}", *map(_fill, text.strip().split("\n\n"))]
    if found:
        parts.append(_fill(f"Error against the map, at the same omega: {SHARES}."))
        parts += [error_table(errors) for errors in found]
    else:
        parts.append("Nothing is simplified: the errors are those of the map.")
    parts.append("\n".join(provenance(table)))
    return "\n\n".join(parts) + "\n"


def error_table(errors: Errors) -> str:
    """Lines of plain text, a row per load."""
    rows = [f"over {errors.where} ({errors.points} points)"]
    rows.append(f"  {'':12s}{'rms':>10s}{'worst':>10s}")
    for name, rms, worst in zip(LOADS, errors.rms.tolist(), errors.worst.tolist(), strict=True):
        rows.append(f"  {name:12s}{rms:>10.2%}{worst:>10.2%}")
    return "\n".join(rows)


def _fill(paragraph: str) -> str:
    return textwrap.fill(paragraph, 88, break_on_hyphens=False, break_long_words=False)


# -------------------------------------------------------------------------------------------------
# The note that goes with the export of a whole vehicle.


def vehicle_note(vehicle: Vehicle, table: LoadTable, target: str, **values: Any) -> str:
    """The text of a note.

    Parameters
    ----------
    vehicle, table : Vehicle, LoadTable
        What is exported.
    target : str
        Names the template, ``README-vehicle-<target>.txt.j2``.
    **values
        For the template.
    """
    text = rendered(f"README-vehicle-{target}.txt", table, vehicle=vehicle, **values)
    parts = [f"propmap export: {target}, {vehicle.name}"]
    parts += [
        textwrap.fill(part, 88, break_on_hyphens=False, break_long_words=False)
        for part in text.strip().split("\n\n")
    ]
    return "\n\n".join([*parts, "\n".join(provenance(table))]) + "\n"


# -------------------------------------------------------------------------------------------------
# Points of a table's envelope, and what a simpler model's errors at them are.

POINTS = 32_768

CLIMB = (-0.05, 0.2)
LARGEST_MU = 0.25
"""The advance ratios, along the axis and in the disk plane, for which the simple models are
meant: climb and slow descent.  In faster descent their errors triple."""

SIMPLE = f"lambda_c from {CLIMB[0]:g} to {CLIMB[1]:g}, mu up to {LARGEST_MU:g}, no vortex ring"


@dataclass(frozen=True)
class Samples:
    """A table's loads at n points that fill its envelope evenly; arrays (n,).

    Attributes
    ----------
    omega, axial, inplane : ndarray
        Rotational speed [rad/s], velocity along the axis and in the disk plane [m/s].
    loads, static : mapping of str to ndarray
        Every load [N], [N m], and what its errors are shares of, see ``loads.error_scales``.
    climb, mu : ndarray
        Advance ratios along the axis and in the disk plane [-].
    ring : ndarray of bool
        Where momentum theory does not hold.
    """

    omega: Floats
    axial: Floats
    inplane: Floats
    loads: Mapping[str, Floats]
    static: Mapping[str, Floats]
    climb: Floats
    mu: Floats
    ring: NDArray[np.bool_]

    @property
    def simple(self) -> NDArray[np.bool_]:
        """Where the simple models are fitted: small advance ratios, no vortex ring; (n,)."""
        climbs = (self.climb >= CLIMB[0]) & (self.climb <= CLIMB[1])
        return climbs & (self.mu <= LARGEST_MU) & ~self.ring


@dataclass(frozen=True)
class Errors:
    """Errors of a model as shares of static loads.

    Attributes
    ----------
    where : str
        The points' range, in words.
    points : int
        How many.
    rms, worst : ndarray, shape (L,)
        In the order of ``LOADS`` [-].
    """

    where: str
    points: int
    rms: Floats
    worst: Floats


def sample(table: LoadTable) -> Samples:
    """Points of the envelope that have loads.

    Raises
    ------
    InputError
        For a table without hover, which has no static loads, and for one without points for
        simple models.
    """
    omega, speed, beta = evenly(table, POINTS)
    found = table.loads(omega, speed, beta)
    loads = {name: getattr(found, name) for name in LOADS}
    valid = np.isfinite(list(loads.values())).all(axis=0)
    axial, inplane = speed * np.cos(beta), speed * np.sin(beta)
    tip = omega * table.content.radius
    static = static_loads(table, omega)
    samples = Samples(
        omega=omega[valid],
        axial=axial[valid],
        inplane=inplane[valid],
        loads={name: values[valid] for name, values in loads.items()},
        static={name: values[valid] for name, values in static.items()},
        climb=(axial / tip)[valid],
        mu=(inplane / tip)[valid],
        ring=np.asarray(found.code == VORTEX_RING)[valid],
    )
    if not samples.simple.any():
        raise InputError(
            f"the map has no points with {SIMPLE}", "build it over an envelope with slow flight"
        )
    return samples


def static_loads(table: LoadTable, omega: Floats) -> dict[str, Floats]:
    """What errors are shares of at omega (n,), by load; see ``Samples``."""
    still = table.loads(omega, 0.0, table.envelope["beta"][0])
    static = {name: np.asarray(getattr(still, name)) for name in LOADS}
    if not np.isfinite(static["thrust"]).all():
        least = table.envelope["speed"][0]
        raise InputError(
            f"the map has no loads at rest, its speed begins at {least:g} m/s",
            "this target's model needs hover: build the map with --speed 0:...",
        )
    return error_scales(static, table.content.radius)


def slope(samples: Samples, load: str) -> float:
    """A ``load`` over Omega times the in-plane speed, for simple models, by least squares of the
    ``samples``' shares of static loads [N s^2/m], [N s^2]."""
    chosen = samples.simple
    scale = samples.static[load][chosen]
    x = (samples.omega * samples.inplane)[chosen] / scale
    return float(x @ (samples.loads[load][chosen] / scale) / (x @ x))


def middle_omega(table: LoadTable) -> float:
    """Omega [rad/s] at which the Reynolds term is halfway between the envelope's ends."""
    return float(np.mean(table.content.omega**-0.5) ** -2.0)


def errors(samples: Samples, model: Mapping[str, Floats]) -> tuple[Errors, Errors]:
    """Errors of a model where simple models are meant, and over the envelope.

    A load (n,) that ``model`` lacks it takes to be zero.
    """
    share = np.stack(
        [
            (model.get(name, 0.0) - load) / samples.static[name]
            for name, load in samples.loads.items()
        ],
        axis=-1,
    )
    return _sizes(SIMPLE, share[samples.simple]), _sizes("the map's whole envelope", share)


def _sizes(where: str, share: Floats) -> Errors:
    return Errors(where, len(share), np.sqrt((share**2).mean(axis=0)), abs(share).max(axis=0))


def evenly(table: LoadTable, count: int) -> tuple[Floats, Floats, Floats]:
    """omega, speed and beta of points that fill a table's envelope evenly, (count,) each.

    By the additive recurrence of the root of x^4 = x + 1; SciPy has better sequences, but a
    table's user need not have SciPy.
    """
    root = 1.2207440846057596
    steps = root ** -np.arange(1.0, 4.0)
    unit = (0.5 + np.arange(1, count + 1)[:, None] * steps) % 1.0
    low, high = np.array(list(table.envelope.values())).T
    omega, speed, beta = (low + (high - low) * unit).T
    return omega, speed, beta
