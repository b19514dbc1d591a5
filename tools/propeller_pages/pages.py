"""Write the pages on propellers.

Usage: python -m tools.propeller_pages.pages DOCS

DOCS is the folder of the documentation.  Cards go into its folder ``propellers``; the tables and
pictures of propellers.md go into ``generated``.  The build of the documentation calls ``write``,
which takes some twenty seconds.
"""

from __future__ import annotations

import sys
from pathlib import Path

from propmap.catalogue.identified import all_identified
from propmap.io.csv import replacing
from tools import measured_rows
from tools.propeller_pages import listing, population
from tools.propeller_pages.card import card, raw
from tools.propeller_pages.words import page_name


def write(docs: Path) -> None:
    """Write all pages, and delete the cards of removed propellers."""
    entries, rows = all_identified(), measured_rows.read()
    folder = docs / listing.FOLDER
    folder.mkdir(exist_ok=True)
    cards = {f"{page_name(one)}.md": card(one, rows.get(one.tested)) for one in entries}
    for name, text in cards.items():
        _write(folder / name, text)
    for old in folder.glob("*.md"):
        if old.name not in cards:
            old.unlink()
    parts = {
        "counts": listing.counts(entries),
        "list": listing.listing(entries),
        "makers": listing.makers(entries),
        "worst": listing.worst(entries, rows),
        "population": raw('<div class="wide">', population.picture(entries), "</div>"),
        "population-table": population.table(),
    }
    for name, text in parts.items():
        _write(docs / "generated" / f"propellers-{name}.md", text + "\n")


def _write(path: Path, text: str) -> None:
    """Write ``text`` only if it changed, because Sphinx reads every file with a new date."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        with replacing(path) as part:
            part.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    write(Path(sys.argv[1]))
