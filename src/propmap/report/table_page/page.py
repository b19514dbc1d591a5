"""The page on a table and the files beside it."""

from __future__ import annotations

import numpy as np

from propmap.export.files import map_sha256
from propmap.report.certificate_text import (
    PLACE,
    TITLES,
    claims,
    largest_at,
    parameter_claims,
)
from propmap.report.page import csv_of_rows, number, report_files
from propmap.report.style import RPM
from propmap.report.table_page import hover, loads
from propmap.report.table_page.envelope import cell_figure, cell_sheet
from propmap.report.table_page.samples import sample
from propmap.table.query import LoadTable

PLACE_COLUMNS = ("at_rpm", "at_speed_mps", "at_beta_deg")


def table_pages(table: LoadTable, where: str) -> dict[str, str | bytes]:
    """All files of the page on a table by name; ``where`` names its file."""
    samples, found, info, content = sample(table), table.certificate, table.info, table.content
    parameters, law = info.get("parameter_uncertainty") or {}, info.get("airfoil") or {}
    figures = {
        "table-cells": cell_figure(table),
        "table-loads": loads.curve_figure(samples),
        "table-maps": loads.map_figure(samples),
    }
    sheets = {
        "table-cells": cell_sheet(table),
        "table-loads": loads.curve_sheet(samples),
        "table-maps": loads.map_sheet(samples),
    }
    values = {}
    if samples.hover:
        figures["table-hover"] = hover.hover_figure(samples)
        sheets["table-hover"] = hover.hover_sheet(samples)
    if found:
        columns = {"largest": found["max_error"], "rms": found["rms_error"]}
        if found["unresolved_cells"]:
            columns["largest, unresolved"] = found["unresolved_max_error"]
        if parameters:
            columns["by the parameters, median"] = parameters["median"]
            columns["by the parameters, 95 %"] = parameters["percentile_95"]
        places = largest_at(found)
        nowhere = len(PLACE) * [None] if places else []
        slugs = (name.replace(" ", "_").replace(",", "") + "_share" for name in columns)
        sheets["table-certificate"] = csv_of_rows(
            " ".join(("load", *slugs, *(PLACE_COLUMNS if places else ()))),
            [
                (
                    load,
                    *(float(by_load[load]) for by_load in columns.values()),
                    *(places.get(load) or nowhere),
                )
                for load in TITLES
            ],
        )
        values = {
            "holds": found.get("holds", max(found["max_error"].values()) <= found["tolerance"]),
            "claims": [*claims(found), *(parameter_claims(parameters) if parameters else ())],
            "error_heads": "|".join(
                (
                    "error, as a share of",
                    *(f"{name} [%]" for name in columns),
                    *(f"largest at [{unit}]" for unit in PLACE.values() if places),
                )
            ),
            "errors": [
                (
                    title,
                    *(number(100.0 * by_load[load], 2) for by_load in columns.values()),
                    *(number(value, 4) for value in places.get(load) or nowhere),
                )
                for load, title in TITLES.items()
            ],
        }
    constants = (f"{name} {value:.4g}" for name, value in law.items() if isinstance(value, float))
    (w0, w1), speeds, betas = table.envelope.values()
    return report_files(
        "report/table_page/page.html.j2",
        figures,
        sheets,
        name=info["propeller"].get("name") or "a propeller",
        where=where,
        info=info,
        airfoil=law,
        constants=", ".join(constants),
        content=content,
        sha256=map_sha256(table),
        samples=samples,
        certificate=found,
        parameters=parameters,
        envelope=(w0 * RPM, w1 * RPM, *speeds, *np.degrees(betas)),
        hover=hover,
        **values,
    )
