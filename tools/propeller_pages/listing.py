"""The list of all propellers, which a script filters, and the worst of them with reasons."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from propmap import catalogue
from propmap.catalogue.identified import Identified
from propmap.catalogue.lookup import propeller
from tools.catalogue.database import MeasuredPropeller
from tools.catalogue.verdict import summary
from tools.propeller_pages import blade_picture
from tools.propeller_pages.card import raw
from tools.propeller_pages.comparison import ErrorParts, compare, error_parts, reynolds
from tools.propeller_pages.words import fixed, flagged, page_name, series_title, title

FOLDER = "propellers"
"""Folder of the cards, beside the page with the list."""

FILTER = """\
<div class="propeller-filter" hidden>
<label for="propeller-filter">Filter</label>
<input type="search" id="propeller-filter" autocomplete="off" spellcheck="false"
 aria-controls="propeller-list" placeholder="apc 10x7, 3 blades, flagged">
<output for="propeller-filter" aria-live="polite"></output>
</div>"""
"""Hidden until the script that makes it work is there."""

SCRIPT = '<script src="_static/propellers.js"></script>'

REASONS = {
    "da4022 5.0x3.75 - 4": "At rest the power coefficient falls by a seventh from the slowest "
    "rows to the fastest, the model's by half as much.",
    "gwsdd 5.0x4.3 - 2": "The runs are of three specimens, whose loads differ by a third, and the "
    "database does not say which run is of which: the constants lie between.",
    "mi 3.2x2.2 - 2": "Small Reynolds numbers: thrust at rest grows by a fifth with the speed of "
    "rotation, and the errors grow along J in fast runs and fall in slow ones. One shift of the "
    "zero-lift angle cannot do both.",
    "mi 4.0x2.7 - 2": "As the 3.2x2.2; at rest power, too, grows by more than half.",
    "mi 5.0x3.5 - 2": "As the 3.2x2.2; thrust at rest grows by a third.",
    "mit 4.3x3.5 - 2": "As the MI 3.2x2.2; at rest power first falls, then grows with the speed of "
    "rotation.",
    "gwssf 9.0x7.0 - 2": "Three runs agree. The fastest has less thrust from half its J on and "
    "none at a J an eighth lower, which is no effect of the Reynolds number. A blade that twists "
    "under load, or another specimen, would do so; the database does not say.",
    "nr640 5x3.16 - 4": "At rest thrust grows by two fifths from the slowest row to the fastest "
    "and power hardly; half of the squared errors are those of the two slowest rows.",
    "pl 57.0x20.0 - 2": "At rest the power coefficient grows by a third with the speed of rotation "
    "while thrust stays. Friction would make it fall; the torque of the slowest rows is below "
    "0.1 N mm.",
    "da4002 9.0x8.95 - 2": "Its pitch is its diameter: at rest the inner half of the blade is "
    "stalled, at J = 0.3 nothing is. One stall angle for all radii serves such a blade worst.",
    "da4022 5.0x3.75 - 3": "At rest neither coefficient goes one way with the speed of rotation: "
    "thrust dips in the middle of the range, as sections in transition do.",
}
"""What the cards of the worst show, by the name in the database."""


def listing(entries: Sequence[Identified]) -> str:
    """List all propellers with their outlines, by series and size; a script hides some."""
    ordered = sorted(
        entries,
        key=lambda one: (
            series_title(one.family).lower(),
            propeller(one.propeller).radius,
            title(one),
        ),
    )
    items = "\n".join(_item(one) for one in ordered)
    return raw(FILTER, f'<ul class="propellers" id="propeller-list">\n{items}\n</ul>', SCRIPT)


def _item(one: Identified) -> str:
    blade = propeller(one.propeller)
    kind = "flagged" if flagged(one) else "good"
    words = f"{one.propeller} {title(one)} {one.tested} {series_title(one.family)} {one.family}"
    # As people write it: 10x7e, 10x4.7sf.
    size = one.propeller.rpartition("-")[2] if one.propeller[-1].isdigit() else ""
    mark = one.family.removeprefix("apc")
    words = f"{words} {size}{mark} {one.blades}blades {kind}".lower().replace("-", " ")
    return (
        f'<li class="{kind}" data-words=" {escape(words)}">'
        f'<a href="{FOLDER}/{page_name(one)}.html">{blade_picture.small(blade)}'
        f"<strong>{escape(title(one))}</strong></a> <code>{escape(one.propeller)}</code> "
        f"<span>{one.blades} blades, {2e3 * blade.radius:.0f} mm; rms error C_T "
        f"{fixed(one.thrust_rms, 4)}, C_P {fixed(one.power_rms, 4)}</span> "
        f'<span class="told">{escape(one.verdict)}</span></li>'
    )


def counts(entries: Sequence[Identified]) -> str:
    """How many there are, and how many are flagged."""
    known = {one.propeller for one in entries}
    return (
        f"{len(entries)} sets of constants of {len(known)} blades; "
        f"{sum(map(flagged, entries))} carry a remark on what is wrong with the data or the fit "
        'and are found with the word "flagged".'
    )


def makers(entries: Sequence[Identified]) -> str:
    """Tabulate the blades by their makers' files, which have no cards but for ``entries``."""
    carded = {one.propeller for one in entries}
    by_series: dict[str, list[str]] = {}
    for entry in catalogue.entries():
        if entry.geometry == "maker" and entry.name not in carded:
            by_series.setdefault(series_title(entry.family), []).append(entry.name)
    lines = ["| series | propellers | names |", "|---|---:|---|"]
    for series, names in sorted(by_series.items()):
        lines.append(f"| {series} | {len(names)} | {', '.join(f'`{name}`' for name in names)} |")
    return "\n".join(lines)


def worst(entries: Sequence[Identified], rows: dict[str, MeasuredPropeller]) -> str:
    """Tabulate the worst fits: where their errors lie, and why."""
    lines = [
        "| propeller | C_T | C_P | Re at 3/4 R | most of the errors are | what is behind them |",
        "|---|---:|---:|---:|---|---|",
    ]
    for one in summary(entries).worst:
        low, high = reynolds(one, propeller(one.propeller))
        where = "-"
        if one.tested in rows:
            found = compare(one, rows[one.tested])
            names = ("C_T", "C_P")
            where = "; ".join(
                f"{name}: {_most(error_parts(found.tested, error))}"
                for name, error in zip(names, found.error, strict=True)
            )
        cells = (
            f"[{title(one)}]({FOLDER}/{page_name(one)}.md)",
            fixed(one.thrust_rms, 4),
            fixed(one.power_rms, 4),
            f"{low / 1e3:.0f}e3 to {high / 1e3:.0f}e3",
            where,
            REASONS.get(one.tested, "not looked into"),
        )
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


WORDS = {
    "rest": "at rest",
    "runs": "means of runs",
    "course": "slope over J in a run",
    "scatter": "scatter",
}
"""Names of the parts of the errors."""


def _most(parts: ErrorParts) -> str:
    name, share = max(parts._asdict().items(), key=lambda part: part[1])
    return f"{WORDS[name]} ({100.0 * share:.0f}\u00a0%)"
