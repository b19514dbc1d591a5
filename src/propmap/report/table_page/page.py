"""The page on a table and the files beside it."""

from __future__ import annotations

from collections.abc import Mapping

import propmap
from propmap.export.provenance import map_sha256
from propmap.report.page import Page, Verdict, page_html, percent
from propmap.report.report_files import PAGE
from propmap.report.table_page.certificate import certificate_section
from propmap.report.table_page.envelope import envelope_section
from propmap.report.table_page.hover import hover_section
from propmap.report.table_page.loads import load_section
from propmap.report.table_page.samples import RPM, TableSamples, sample
from propmap.table.query import LoadTable

UNSURE = 0.05
"""Median uncertainty by the parameters, as a share of static loads, from which care is due."""


def table_pages(table: LoadTable, where: str) -> Mapping[str, str | bytes]:
    """All files by name: the page, and a CSV and an SVG for what it shows.

    table : to report on.  where : its file, for the page.
    """
    samples = sample(table)
    parts = [
        envelope_section(table, samples),
        certificate_section(table),
        load_section(samples),
        hover_section(samples),
    ]
    name = table.info["propeller"].get("name") or "a propeller"
    page = Page(
        title=f"Table of {name}: can I trust it?",
        subtitle=f"{where}. Report by propmap {propmap.__version__}",
        lead=lead(table, samples),
        sections=[part.section for part in parts],
        facts=_facts(table),
    )
    files: dict[str, str | bytes] = {PAGE: page_html(page)}
    for part in parts:
        files |= part.files
    return files


def lead(table: LoadTable, samples: TableSamples) -> tuple[Verdict, ...]:
    """Two questions: is the table a good copy of the model, and is the model good."""
    return (_copy(table, samples), _model(table))


def _copy(table: LoadTable, samples: TableSamples) -> Verdict:
    found = table.certificate
    (w0, w1), (v0, v1), (b0, b1) = table.envelope.values()
    box = (
        f"from {w0 * RPM:.0f} to {w1 * RPM:.0f} rpm, {v0:.3g} to {v1:.3g} m/s and β "
        f"{57.29577951308232 * b0:.0f}° to {57.29577951308232 * b1:.0f}°"
    )
    if not found:
        return Verdict(
            "bad",
            "As a copy of the model: not known",
            f"{box[:1].upper()}{box[1:]}, but it was never certified.",
        )
    if not found.get("holds", max(found["max_error"].values()) <= found["tolerance"]):
        return Verdict(
            "bad", "As a copy of the model: no", "The certificate says its tolerance does not hold."
        )
    worst = max(found["max_error"].values())
    text = f"{box[:1].upper()}{box[1:]} its loads are within {percent(worst)} of the static loads."
    marked = samples.shares["vortex_ring"] + samples.shares["unresolved"]
    marked += samples.shares["no_value"]
    if samples.shares["unresolved"]:
        loose = max(found["unresolved_max_error"].values())
        text = text[:-1] + (
            f", apart from {percent(found['unresolved_volume'])} of the envelope where the model's "
            f"loads jump: there errors reach {percent(loose)}."
        )
    if marked < 5e-4:
        return Verdict("good", "As a copy of the model: yes", text)
    if samples.shares["vortex_ring"]:
        text += (
            f" In {percent(samples.shares['vortex_ring'])} of it, the vortex ring state, the model "
            "itself is no guide."
        )
    word = "As a copy of the model: yes, and marked where not"
    return Verdict("good" if marked < UNSURE else "caution", word, text)


def _model(table: LoadTable) -> Verdict:
    section = table.info.get("airfoil") or {}
    law = section.get("name", "of unknown name")
    source = section.get("source")
    origin = f"Its section law is {law}" + (f" ({source})." if source else ".")
    found = table.info.get("parameter_uncertainty")
    word = "As a model of the propeller: see its fit"
    if not found:
        return Verdict(
            "caution",
            "As a model of the propeller: not known from this file",
            f"{origin} The table carries no uncertainty of its parameters, as one built with "
            "--airfoil FIT does. Compare the law with measurements of your propeller by propmap "
            "check, or fit them and read propmap report FIT.",
        )
    thrust, torque = (found["median"][load] for load in ("thrust", "torque"))
    most = (found["percentile_95"][load] for load in ("thrust", "torque"))
    text = (
        f"{origin} The scatter of the data behind it leaves thrust open by {percent(thrust)} and "
        f"torque by {percent(torque)} of the static loads (one standard deviation, median over the "
        f"envelope), in one place of twenty by more than {' and '.join(map(percent, most))}. "
        "Errors of the theory, and speeds and angles that the fit had no data for, are told by "
        "propmap report on the fit."
    )
    level = "caution" if max(thrust, torque) <= UNSURE else "bad"
    return Verdict(level, word, text)


def _facts(table: LoadTable) -> tuple[tuple[str, str], ...]:
    info, content = table.info, table.content
    blade, section = info["propeller"], info.get("airfoil") or {}
    numbers = ", ".join(
        f"{name} {value:.4g}" for name, value in section.items() if isinstance(value, float)
    )
    told = (
        ("Propeller", f"{blade.get('name')}, {blade.get('blades', '?')} blades, radius "
                      f"{1e3 * content.radius:.4g} mm"),
        ("Geometry", str(blade.get("source") or "")),
        ("Geometry by", str(blade.get("citation") or "")),
        ("Geometry's SHA-256", str(blade.get("geometry_sha256") or "")),
        ("Section law", f"{section.get('name', '')}: {numbers}" if section else ""),
        ("Corrections", ", ".join(info.get("corrections") or ["none"])),
        ("Air", f"{content.density:.5g} kg/m³"),
        ("Knots", f"{content.advance.size} advance ratios, {content.beta.size} angles"),
        ("Interpolation", str(info.get("interpolation") or "")),
        ("Accuracy of the model", str(info.get("accuracy") or "")),
        ("Command", str(info.get("command") or "")),
        ("Built", f"{info.get('created', '')}, propmap {info.get('propmap_version', '')}"),
        ("Table's SHA-256", map_sha256(table)),
    )  # fmt: skip
    return tuple((name, text) for name, text in told if text.strip(", "))
