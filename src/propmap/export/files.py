"""Shared parts of the exports: writing files, templates, names, provenance, notes on errors."""

from __future__ import annotations

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
from propmap.aircraft.assumptions import assumption_lines, assumptions
from propmap.errors import InputError
from propmap.io.csv import check_place, replacing
from propmap.loads import LOADS, error_scales
from propmap.table.interpolation import VORTEX_RING
from propmap.table.query import LoadTable
from propmap.typing import Floats
from propmap.units import DEGREE, RPM
from propmap.vehicle.vehicle import Vehicle

Files = Mapping[str, str | Callable[[Path], None]]  # by name, a text or a function that writes it


def check_folder(folder: Path) -> None:
    """Raise ``InputError`` if no files can be written to ``folder`` or the folder created."""
    if folder.exists() and not folder.is_dir():
        raise InputError("this is a file", "name a folder to write into", str(folder))
    check_place(folder / "a file" if folder.exists() else folder, str(folder))


def write_files(files: Files, folder: Path, *, replace: bool) -> list[Path]:
    """Write all files or none into a folder, created if it does not exist; ``InputError`` for
    existing files unless ``replace``."""
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


# --- Text from the templates in ``templates/``: source code, comments and notes ------------------


def rendered(template: str, table: LoadTable, **values: Any) -> str:
    """Render a template with ``values``, the ``table``, ``loads``, the provenance as ``lines``, and
    the propeller's identifier as ``p`` and, in capitals, ``P``."""
    name, lines = identifier(table), provenance(table)
    common = {"table": table, "loads": LOADS, "p": name, "P": name.upper(), "lines": lines}
    return filled(template, **common, **values)


def filled(template: str, **values: Any) -> str:
    """Render a template with ``values``; functions among them are also available as filters."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"),
        variable_start_string="@",
        variable_end_string="@",
        line_statement_prefix="%%",
        undefined=StrictUndefined,
        keep_trailing_newline=True,
    )
    environment.filters |= {
        "c_comment": _c_comment,
        "hash_comment": _hash_comment,
        "xml_comment": _xml_comment,
        **{name: value for name, value in values.items() if callable(value)},
    }
    return environment.get_template(f"{template}.j2").render(**values)


def _c_comment(lines: Sequence[str]) -> str:
    safe = (line.replace("*/", "* /").replace("/*", "/ *") for line in lines)
    return "\n".join(f" * {line}".rstrip() for line in safe)


def _hash_comment(lines: Sequence[str]) -> str:
    return "\n".join(f"# {line}".rstrip() for line in lines)


def _xml_comment(lines: Sequence[str]) -> str:
    text = "\n".join(f"  {line}" for line in lines)
    # XML forbids two hyphens in a comment.
    return f"<!--\n{re.sub('-(?=-)', '- ', text)}\n-->"


# --- File names, and the provenance of an export as lines for notes and comments -----------------


def identifier(table: LoadTable) -> str:
    """Return the propeller's name as an identifier for programs and file systems."""
    name = re.sub(r"[^0-9a-z]+", "_", str(table.info["propeller"].get("name")).lower()).strip("_")
    return name if name[:1].isalpha() else f"prop_{name}".rstrip("_")


def vehicle_identifier(vehicle: Vehicle) -> str:
    """Return the name of a ``vehicle`` as a valid file name."""
    return re.sub(r"[^0-9a-z]+", "_", vehicle.name.lower()).strip("_") or "vehicle"


def vehicle_name(vehicle: Vehicle, table: LoadTable) -> str:
    """Return the vehicle's name as an identifier that differs from the propeller's."""
    name = vehicle_identifier(vehicle)
    name = name if name[0].isalpha() else f"vehicle_{name}"
    return f"{name}_vehicle" if name == identifier(table) else name


def provenance(table: LoadTable) -> list[str]:
    """Return printable lines with the origin of the table and the version of propmap."""
    return [*origin(table), f"written by propmap {propmap.__version__}"]


def origin(table: LoadTable) -> list[str]:
    """Return printable lines with the inputs, the errors and the checksum of the table."""
    (w0, w1), speeds, (b0, b1) = table.envelope.values()
    ends = w0 / RPM, w1 / RPM, *speeds, b0 / DEGREE, b1 / DEGREE
    text = filled("origin.txt", table=table, ends=ends, loads=LOADS, share="{:.2%}".format)
    clean = ("".join(c if c.isprintable() else "?" for c in line) for line in text.splitlines())
    return [part for line in clean for part in textwrap.wrap(line, 88, subsequent_indent="  ")]


def note(
    target: str,
    table: LoadTable,
    found: Sequence[ErrorSizes] = (),
    vehicle: Vehicle | None = None,
    *,
    text: str = "",
    **values: Any,
) -> str:
    """Return the note of an export: its limits, the errors ``found``, and the provenance.

    The limits come from ``text``, or else from the template ``README-TARGET.txt.j2``, or
    ``README-TARGET-vehicle.txt.j2`` with a ``vehicle``, rendered with ``values``.
    """
    title, template = target, f"README-{target}.txt"
    if vehicle is not None:
        title, template = f"{target}, {vehicle.name}", f"README-{target}-vehicle.txt"
        values |= {"v": vehicle_name(vehicle, table), "vehicle": vehicle}
        values["rests_on"] = rests_on(vehicle, table)
    rpm = middle_omega(table) / RPM
    text = text or rendered(template, table, simple=SIMPLE, hover_rpm=rpm, **values)
    shares = ", ".join(load.share for load in LOADS.values())
    cost = "Nothing is simplified: the export has only the errors of the table."
    if found:
        cost = f"Error against the table, relative to static loads at the same omega: {shares}."
    parts = [f"propmap export: {title}"]
    for part in (*text.split("\n\n"), cost):
        words = " ".join(part.split())
        parts.append(textwrap.fill(words, 88, break_on_hyphens=False, break_long_words=False))
    for errors in found:
        rows = [f"over {errors.where}"]
        rows.append(f"  {'':12s}{'rms':>10s}{'worst':>10s}")
        for name, rms, worst in zip(LOADS, errors.rms.tolist(), errors.worst.tolist(), strict=True):
            rows.append(f"  {name:12s}{rms:>10.2%}{worst:>10.2%}")
        parts.append("\n".join(rows))
    return "\n\n".join([*parts, "\n".join(provenance(table))]) + "\n"


def rests_on(vehicle: Vehicle, table: LoadTable) -> str:
    """Return the assumptions of a vehicle's forces, for a note."""
    lines = assumption_lines(assumptions(vehicle, table))
    more = "" if vehicle.wakes is None else " --no-wakes ignores the wakes of rotors on each other."
    return f"{lines[0][:1].upper()}{lines[0][1:]}; {lines[1]}.{more}"


# --- Points in a table's envelope, and the errors of a simpler model at these points -------------


CLIMB = (-0.05, 0.2)
LARGEST_MU = 0.25
"""Advance ratios, along the axis and in the disk plane, for which the simple models are intended:
climb and slow descent.  In faster descent their errors triple."""

SPEEDS = f"axial speeds from {CLIMB[0]:g} to {CLIMB[1]:g}, in-plane speeds up to {LARGEST_MU:g}"
SIMPLE = f"{SPEEDS} of the tip speed, no vortex ring"


@dataclass(frozen=True)
class Samples:
    """A table's loads at n points that fill its envelope evenly; arrays (n,)."""

    omega: Floats  # [rad/s]
    axial: Floats  # velocity along the axis [m/s]
    inplane: Floats  # velocity in the disk plane [m/s]
    loads: Mapping[str, Floats]  # loads by name [N], [N m]
    static: Mapping[str, Floats]  # scales of relative errors, see ``loads.error_scales``
    climb: Floats  # advance ratio along the axis [-]
    mu: Floats  # advance ratio in the disk plane [-]
    ring: NDArray[np.bool_]  # whether the status is vortex ring

    @property
    def simple(self) -> NDArray[np.bool_]:
        """Return the points of the fits (n,): small advance ratios, no vortex ring."""
        climbs = (self.climb >= CLIMB[0]) & (self.climb <= CLIMB[1])
        return climbs & (self.mu <= LARGEST_MU) & ~self.ring


@dataclass(frozen=True)
class ErrorSizes:
    """Errors of a model relative to static loads, in the order of ``LOADS``."""

    where: str  # range and number of the points, in words
    rms: Floats  # (L,)
    worst: Floats  # (L,)


def sample(table: LoadTable) -> Samples:
    """Return the loads at valid points of the envelope.

    Raises ``InputError`` for a table without hover or without points for simple models.
    """
    omega, speed, beta = evenly(table)
    found = table.loads(omega, speed, beta)
    loads = {name: getattr(found, name) for name in LOADS}
    valid = np.isfinite(list(loads.values())).all(axis=0)
    omega, speed, beta, code = (each[valid] for each in (omega, speed, beta, found.code))
    axial, inplane, tip = speed * np.cos(beta), speed * np.sin(beta), omega * table.content.radius
    loads = {name: values[valid] for name, values in loads.items()}
    static, ring = static_loads(table, omega), np.asarray(code == VORTEX_RING)
    samples = Samples(omega, axial, inplane, loads, static, axial / tip, inplane / tip, ring)
    if not samples.simple.any():
        fault = f"the table has no points with {SIMPLE}"
        raise InputError(fault, "build it over an envelope with slow flight")
    return samples


def static_loads(table: LoadTable, omega: Floats) -> dict[str, Floats]:
    """Return the scales of relative errors at omega (n,), by load; see ``Samples``."""
    still = table.loads(omega, 0.0, table.envelope["beta"][0])
    static = {name: np.asarray(getattr(still, name)) for name in LOADS}
    if not np.isfinite(static["thrust"]).all():
        least = table.envelope["speed"][0]
        found = f"the table has no loads at rest, its speed begins at {least:g} m/s"
        remedy = "this target's model needs hover: build the table with --speed 0:..."
        raise InputError(found, remedy)
    return error_scales(static, table.content.radius)


def slope(samples: Samples, load: str) -> float:
    """Fit the slope of a ``load`` over Omega times in-plane velocity [N s^2/m], [N s^2], by least
    squares of relative errors at the points for simple models."""
    chosen = samples.simple
    scale = samples.static[load][chosen]
    x = (samples.omega * samples.inplane)[chosen] / scale
    return float(x @ (samples.loads[load][chosen] / scale) / (x @ x))


def middle_omega(table: LoadTable) -> float:
    """Return the omega [rad/s] at which the Reynolds number term omega^(-1/2) is at its middle."""
    return float(np.copysign(np.mean(table.content.roots) ** -2.0, table.content.omega[0]))


def errors(samples: Samples, model: Mapping[str, Floats]) -> tuple[ErrorSizes, ErrorSizes]:
    """Return the errors of a model's loads (n,) at the points for simple models, and at all points.

    Loads that the model does not have are zero.
    """
    share = shares(samples.loads, model, samples.static)
    near = share[samples.simple]
    return (
        error_sizes(f"{SIMPLE} ({len(near)} points)", near),
        error_sizes(f"the table's whole envelope ({len(share)} points)", share),
    )


def shares(
    loads: Mapping[str, Floats], model: Mapping[str, Floats], static: Mapping[str, Floats]
) -> Floats:
    """Return the errors (n, L) of a model's loads (n,), relative to the static loads."""
    each = [(model.get(name, 0.0) - load) / static[name] for name, load in loads.items()]
    return np.stack(each, axis=-1)


def error_sizes(where: str, share: Floats) -> ErrorSizes:
    """Return the sizes of the relative errors ``share`` (n, L) of n points."""
    return ErrorSizes(where, np.sqrt((share**2).mean(axis=0)), abs(share).max(axis=0))


def evenly(table: LoadTable, count: int = 32_768) -> tuple[Floats, Floats, Floats]:
    """Return omega, speed and beta of points that fill a table's envelope evenly, (count,) each."""
    # Additive recurrence of the root of x^4 = x + 1; SciPy has better sequences, but users of a
    # table may not have SciPy.
    root = 1.2207440846057596
    steps = root ** -np.arange(1.0, 4.0)
    unit = (0.5 + np.arange(1, count + 1)[:, None] * steps) % 1.0
    low, high = np.array(list(table.envelope.values())).T
    omega, speed, beta = (low + (high - low) * unit).T
    return omega, speed, beta
