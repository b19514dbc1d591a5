"""Compute the paper's tables and figures from public data, and what does not agree: one page.

Takes about two minutes on two cores.  FOLDER gets index.html with all figures inside, and every
figure and table as SVG and CSV; the files are there all at once or not at all.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from papers.gill_dandrea_2017.page import FILES, compute, pages
from propmap.errors import InputError
from propmap.report.html import PAGE, check_folder, write_folder


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser("python -m papers.gill_dandrea_2017", description=__doc__)
    parser.add_argument(
        "-o", "--output", type=Path, default="propmap-reproduce", metavar="FOLDER",
        help="new, empty, or written by this command",
    )  # fmt: skip
    folder = parser.parse_args(arguments).output
    try:
        check_folder(folder, FILES)
        print("computing: about two minutes, less from the second time on", file=sys.stderr)
        files = pages(compute())
        write_folder(folder, files)
    except InputError as error:
        parser.error(str(error))
    print(f"wrote {folder / PAGE} and {len(files) - 1} files beside it")


if __name__ == "__main__":
    main()
