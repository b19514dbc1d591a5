"""Compute the paper's tables, figures and disagreements from public data, and write one page.

The command takes about two minutes on two cores.  It writes to FOLDER index.html with all figures,
and each figure and table as SVG and CSV.  It writes all files or none.
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
        help="a new or empty folder, or one that this command wrote (default: %(default)s)",
    )  # fmt: skip
    folder = parser.parse_args(arguments).output
    try:
        check_folder(folder, FILES)
        print("computing; this takes about two minutes", file=sys.stderr)
        files = pages(compute())
        write_folder(folder, files)
    except InputError as error:
        parser.error(str(error))
    print(f"wrote {folder / PAGE} and {len(files) - 1} more files")


if __name__ == "__main__":
    main()
