"""The list of all propellers, filtered by a script, and the worst fits with reasons."""

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
"""Folder of the cards, next to the page with the list."""

FILTER = """\
<div class="propeller-filter" hidden>
<label for="propeller-filter">Filter</label>
<input type="search" id="propeller-filter" autocomplete="off" spellcheck="false"
 aria-controls="propeller-list" placeholder="apc 10x7, 3 blades, flagged">
<output for="propeller-filter" aria-live="polite"></output>
</div>"""
"""Filter box, hidden until its script has loaded."""

SCRIPT = '<script src="_static/propellers.js"></script>'

REASONS = {
    "gwsdd 5.0x4.3 - 2": "The runs are from three specimens, whose loads differ by a third. The "
    "database does not identify the specimen of a run, so the constants are a compromise.",
    "kpf 96.0x70.0 - 2": "At J = 0.73, C_T falls by a third from the slowest to the fastest run, "
    "while at rest it grows by 3 %. No term of the model has opposite signs at rest and in flight.",
    "mi 3.2x2.2 - 2": "Low Reynolds numbers: C_T at rest grows by a fifth with the rotor speed. "
    "Along J the errors grow in fast runs and fall in slow runs. One shift of the zero-lift "
    "angle cannot do both.",
    "mi 4.0x2.7 - 2": "As the MI 3.2x2.2; in addition, C_P at rest grows by more than half.",
    "mi 5.0x3.5 - 2": "As the MI 3.2x2.2; C_T at rest grows by a third.",
    "mit 4.3x3.5 - 2": "As the MI 3.2x2.2; C_P at rest first falls, then grows with the rotor "
    "speed.",
    "gwssf 9.0x7.0 - 2": "Three runs agree. In the fastest run, C_T is lower from half of its J "
    "upward and vanishes at a J an eighth lower. The Reynolds number does not cause this. A "
    "blade that twists under load, or another specimen, would explain it; the database "
    "mentions neither.",
    "nr640 5x3.16 - 4": "At rest C_T grows by two fifths from the slowest to the fastest row, C_P "
    "hardly at all. The two slowest rows cause half of the squared errors.",
    "pl 57.0x20.0 - 2": "At rest C_P grows by a third with the rotor speed, while C_T is nearly "
    "constant. Friction would reduce C_P. The torque of the slowest rows is below 0.1 N mm.",
    "da4022 5.0x3.75 - 3": "At rest neither coefficient is monotonic in the rotor speed: C_T has "
    "a minimum in the middle of the range, as with sections in transition.",
}
"""Explanations of the worst fits, from their cards, by the name in the database."""


def listing(entries: Sequence[Identified]) -> str:
    """Return the list of all propellers with outlines, by series and size, and its filter."""
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
    # The filter also finds sizes with the mark of the series: 10x7e, 10x4.7sf.
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
    """Return a sentence with the number of propellers and of flagged ones."""
    known = {one.propeller for one in entries}
    return (
        f"The list contains {len(entries)} sets of constants of {len(known)} blades. "
        f"{sum(map(flagged, entries))} of these sets have a remark on the data or the fit; the "
        'filter word "flagged" selects them.'
    )


def makers(entries: Sequence[Identified]) -> str:
    """Tabulate the blades from makers' files without a card, which only ``entries`` have."""
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
    """Tabulate the worst fits, with the largest part of their errors and its explanation."""
    lines = [
        "| propeller | rms C_T | rms C_P | Re at 3/4 R | largest part of the error | explanation |",
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
            REASONS.get(one.tested, "not examined"),
        )
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


WORDS = {
    "rest": "at rest",
    "runs": "means of runs",
    "course": "slope over J in the runs",
    "scatter": "scatter",
}
"""Labels of the parts of the errors."""


def _most(parts: ErrorParts) -> str:
    name, share = max(parts._asdict().items(), key=lambda part: part[1])
    return f"{WORDS[name]} ({100.0 * share:.0f}\u00a0%)"
