"""Store the results of `propmap fit terms` for the documentation.

Usage: propmap fit terms FLIGHT.csv FLIGHT.csv --vehicle VEHICLE.toml -o FOLDER
       python -m tools.flight_steps FOLDER

The tool reads the CSV files of FOLDER and writes benchmarks/results/flight_steps.json.
"""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path
from typing import Any

from propmap.io.csv import replacing

RESULTS = Path(__file__).resolve().parent.parent / "benchmarks" / "results" / "flight_steps.json"
SHEETS = {"errors": "fit-terms", "worth": "fit-terms-worth", "values": "fit-terms-values"}


def main(folder: str) -> None:
    """Collect the rows of all sheets and write them."""
    found = {name: rows(Path(folder) / f"{sheet}.csv") for name, sheet in SHEETS.items()}
    with replacing(RESULTS) as place:
        place.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    print(RESULTS)


def rows(path: Path) -> list[dict[str, Any]]:
    """Rows of a CSV file by head; what is a number as a number."""
    with path.open(encoding="utf-8", newline="") as lines:
        return [{k: _value(v) for k, v in row.items()} for row in csv.DictReader(lines)]


def _value(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


if __name__ == "__main__":
    main(*sys.argv[1:])
