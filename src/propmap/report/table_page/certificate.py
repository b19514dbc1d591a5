"""A table's certificate on the page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from propmap.report.certificate_text import TITLES, claims, parameter_claims
from propmap.report.page import Points, Section, Table, Verdict, number
from propmap.report.part import Part
from propmap.report.sheet import csv_of_rows
from propmap.table.query import LoadTable


def certificate_section(table: LoadTable) -> Part:
    """Errors by load, and what is claimed of them."""
    found = table.certificate
    if not found:
        told = Verdict(
            "bad",
            "Not certified",
            "How far the table is from the model is not known. Build it again with propmap table.",
        )
        return Part(Section("certificate", "Certificate", (told,)))
    parameters = table.info.get("parameter_uncertainty") or {}
    columns = _columns(found, parameters)
    rows = tuple(
        (title, *(number(100.0 * values[load], 2) for _, values in columns))
        for load, title in TITLES.items()
    )
    heads = (("error, as a share of", ""), *((name, "%") for name, _ in columns))
    shown = Table("Errors of the table against the model.", heads, rows)
    sentences = [*claims(found), *(parameter_claims(parameters) if parameters else ())]
    points = Points(tuple(f"{text[:1].upper()}{text[1:]}." for text in sentences))
    sheet = csv_of_rows(
        ("load", *(name.replace(" ", "_").replace(",", "") + "_share" for name, _ in columns)),
        [(load, *(float(values[load]) for _, values in columns)) for load in TITLES],
    )
    section = Section("certificate", "Certificate", (shown, points))
    return Part(section, {"table-certificate.csv": sheet})


def _columns(
    found: Mapping[str, Any], parameters: Mapping[str, Any]
) -> list[tuple[str, Mapping[str, float]]]:
    columns = [("largest", found["max_error"]), ("rms", found["rms_error"])]
    if found["unresolved_cells"]:
        columns.append(("largest, unresolved", found["unresolved_max_error"]))
    if parameters:
        columns.append(("by the parameters, median", parameters["median"]))
        columns.append(("by the parameters, 95 %", parameters["percentile_95"]))
    return columns
