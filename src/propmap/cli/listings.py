"""``propmap props`` and ``propmap airfoils``: propellers and section laws of the catalogue."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any

import numpy as np
import typer
from typer import Argument
from typer.core import TyperGroup

from propmap.catalogue import Entry
from propmap.catalogue.expected import Meant
from propmap.catalogue.identified import PARAMETERS, all_identified
from propmap.catalogue.lookup import meant_by, own_constants, predicted_constants, search
from propmap.cli import options as opt
from propmap.cli import output as out
from propmap.model.airfoil import CONSTANTS, airfoil_names, parameter_set
from propmap.model.propeller import Propeller

ENTRY = ("name", "title", "family", "blades", "diameter_m", "source")
OUTLINE_WIDTH = 72  # characters from the axis to the tip


class ListByDefault(TyperGroup):
    """A group with `list` as its default command: `props apc` means `props list apc`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Insert `list` if the arguments name no command of the group."""
        if not args or args[0] not in {*self.commands, "--help"}:
            args = ["list", *args]
        return super().parse_args(ctx, args)


props_app = typer.Typer(
    name="props",
    cls=ListByDefault,
    help="List propellers, or show one.",
    rich_markup_mode=None,
)
airfoils_app = typer.Typer(
    name="airfoils",
    cls=ListByDefault,
    help="List section laws (airfoil models), or show one.",
    rich_markup_mode=None,
)


@airfoils_app.command("list")
def list_airfoils(format_: out.FormatOption = None, output: out.TextOutput = None) -> None:
    """List the section laws that propmap includes."""
    chosen = out.chosen_format(format_, output)
    sets = [parameter_set(name) for name in airfoil_names()]
    if chosen != "table":
        rows = [one.metadata() for one in sets]
        out.emit_rows(list(rows[0]), rows, chosen, output)
        return
    cells = []
    for one in sets:
        figures = (f"{value:g}" for value in (one.c_l1, one.c_l2, one.c_d))
        angles = (f"{np.degrees(angle):.1f}" for angle in (one.alpha_0, one.zero_lift_angle))
        cells.append((one.name, *figures, *angles, one.source))
    heads = "<name|c_l1 [1/rad]|c_l2|c_d|alpha_0 [deg]|zero lift [deg]|<source"
    out.show(output, out.grid(heads, cells))


@airfoils_app.command("show")
def show_airfoil(
    name: Annotated[
        str,
        Argument(
            metavar="NAME|FILE", help="Name of a section law, or a fit or parameter file (.toml)."
        ),
    ],
    output: out.TextOutput = None,
) -> None:
    """Print a section law as TOML, for example as a template."""
    if output is not None:
        out.check_output(output, (".toml",))
    out.emit(opt.constants(name).to_toml(), output)


@props_app.command("list")
def list_props(
    words: Annotated[
        list[str] | None, Argument(metavar="[TEXT]...", help="Words to search for.")
    ] = None,
    format_: out.FormatOption = None,
    output: out.TextOutput = None,
) -> None:
    """List all propellers, or those that match every word of TEXT."""
    chosen = out.chosen_format(format_, output)
    text = " ".join(words or [])
    entries = search(text)
    if chosen != "table":
        out.emit_rows(ENTRY, [asdict(entry) for entry in entries], chosen, output)
        return
    cells = [(e.name, e.title, str(e.blades), f"{1e3 * e.diameter_m:.1f}") for e in entries]
    found = f"{len(entries)} propellers" + (f" with {text!r}" if text else "")
    if not entries:
        found += "; other commands also accept a designation with the size, such as 'HQ 5x4.3x3'"
    listed = [out.grid("<name|<propeller|blades|diameter [mm]", cells)] if entries else []
    out.show(output, *listed, found)


@props_app.command("show")
def show_prop(
    prop: opt.PropArgument,
    blades: opt.Blades = None,
    radius: opt.Radius = None,
) -> None:
    """Show the blade and the section constants of a propeller."""
    from rich.text import Text

    blade = opt.propeller_noted(prop, blades, radius)
    rows = [
        (f"{y:.5f}", f"{y / blade.radius:.4f}", f"{1e3 * c:.3f}", f"{np.degrees(twist):.2f}")
        for y, c, twist in zip(blade.station, blade.chord, blade.twist, strict=True)
    ]
    out.show(
        None,
        f"{blade.name}: {blade.blades} blades, radius {blade.radius:.5g} m, loaded part from "
        f"{blade.root:.5g} m",
        out.grid("radius [m]|r/R|chord [mm]|twist [deg]", rows),
        Text("\n".join(outline(blade)), no_wrap=True),
        f"source: {blade.source or 'not given'}",
        f"citation: {blade.citation or 'not given'}",
        *_constants(meant_by(prop, blades), blade),
    )


def outline(blade: Propeller) -> list[str]:
    """Return a drawing of the blade to scale, centered on mid-chord, in half-block characters."""
    step = blade.radius / OUTLINE_WIDTH
    middles = (np.arange(OUTLINE_WIDTH) + 0.5) * step
    chord = np.interp(middles, blade.station, blade.chord, left=0.0)
    # A part of the blade that is narrower than a half block is still drawn.
    chord = np.where(middles >= blade.station[0], np.maximum(chord, step), 0.0)
    rows = max(2, 2 * int(np.ceil(chord.max() / step / 2.0)))
    heights = (np.arange(rows) + 0.5 - 0.5 * rows) * step
    filled = np.abs(heights[:, None]) < 0.5 * chord
    marks = np.array([" ", "▀", "▄", "█"])
    lines = marks[filled[0::2].astype(int) + 2 * filled[1::2]]
    lines[rows // 4, 0] = "┼"
    return ["".join(line).rstrip() for line in lines]


def _constants(meant: Meant, blade: Propeller) -> list[object]:
    """Return the default section constants of PROP with their standard deviations, for display."""
    if meant is None:
        return []
    shown: list[object] = []
    found = own_constants(meant, blade.blades)
    if found is not None:
        law = found.airfoil
        shown += [found.summary.removesuffix(f"; {found.verdict}"), f"verdict: {found.verdict}"]
    else:
        predicted = predicted_constants(meant, blade)
        law = predicted.airfoil
        if isinstance(meant, Entry):
            # Otherwise a note on the blade already states the source.
            shown.append(predicted.summary)
    name = meant.name if isinstance(meant, Entry) else None
    same = [one.blades for one in all_identified() if one.propeller == name]
    others = sorted({*same} - {blade.blades})
    if others:
        shown.append(f"also identified with {' and '.join(map(str, others))} blades: --blades N")
    assert law.uncertainty is not None  # identified and predicted constants have it
    deviations = np.sqrt(np.diag(law.uncertainty.covariance.matrix))
    rows = [
        (name, f"{getattr(law, name):.4f}", f"{deviation:.4f}", CONSTANTS[name].unit)
        for name, deviation in zip(PARAMETERS, deviations, strict=True)
    ]
    return [out.grid("<constant|value|standard deviation|<unit", rows), *shown]
