"""A plain CSV file in the dialects in which spreadsheets write it."""

from __future__ import annotations

import csv
import io

DIALECTS = {
    "semicolons": {"separator": ";"},
    "tabs": {"separator": "\t"},
    "semicolons, decimal commas": {"separator": ";", "mark": ","},
    "tabs, decimal commas": {"separator": "\t", "mark": ","},
    "decimal commas, all quoted": {"separator": ";", "mark": ",", "quoted": True},
    "commas, all quoted": {"separator": ",", "quoted": True},
    "commas of a spreadsheet": {"separator": ",", "end": "\r\n", "bom": True, "empty": 2},
    "decimal commas of a spreadsheet": {
        "separator": ";",
        "mark": ",",
        "end": "\r\n",
        "bom": True,
        "empty": 2,
    },
}


def rewritten(plain: str, dialect: str) -> str:
    """A file with commas and decimal points in another dialect; lines with # are comments.

    Numbers alone get another mark.  With ``empty`` columns at the end, the header has one of them
    less than the rows.
    """
    how = DIALECTS[dialect]
    separator, mark = str(how["separator"]), str(how.get("mark", "."))
    text = io.StringIO()
    quoting = csv.QUOTE_ALL if how.get("quoted") else csv.QUOTE_MINIMAL
    end = str(how.get("end", "\n"))
    writer = csv.writer(text, delimiter=separator, lineterminator=end, quoting=quoting)
    empty = [""] * int(how.get("empty", 0))  # type: ignore[call-overload]
    header = True
    for line in plain.splitlines():
        if line.startswith("#"):
            writer.writerow([line, *empty])
            continue
        cells = next(csv.reader([line]), [])
        writer.writerow([*(_with(mark, cell) for cell in cells), *(empty[1:] if header else empty)])
        header = False
    return ("\ufeff" if how.get("bom") else "") + text.getvalue()


def _with(mark: str, cell: str) -> str:
    try:
        float(cell)
    except ValueError:
        return cell
    return cell.replace(".", mark)
