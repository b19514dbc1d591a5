"""The page on a fit and the files beside it."""

from __future__ import annotations

from collections.abc import Mapping

import propmap
from propmap.fit.fit_record import FitRecord
from propmap.fit.result_file import FitFile
from propmap.report.fit_page.curve_section import curve_section
from propmap.report.fit_page.curves import load_curves
from propmap.report.fit_page.data import data_section
from propmap.report.fit_page.errors import error_section
from propmap.report.fit_page.given_data import GivenData, data_check
from propmap.report.fit_page.judgement import lead
from propmap.report.fit_page.parameters import parameter_section
from propmap.report.page import Page, page_html
from propmap.report.report_files import PAGE

KINDS = {
    "tunnel": "tunnel or bench data",
    "level flight": "steady level flights",
    "flight": "forces in flight",
}


def fit_pages(
    file: FitFile, where: str, sha256: str, given: GivenData | None
) -> Mapping[str, str | bytes]:
    """All files by name: the page, and a CSV and an SVG for what it shows.

    file : the fit.  where : its path.  sha256 : of the file.  given : further data.
    """
    fit = file.record
    measured = given.tunnel if given else None
    parts = [
        data_section(fit),
        error_section(fit),
        *([data_check(file, fit, given)] if given else []),
        curve_section(fit, load_curves(file, fit), measured),
        parameter_section(fit),
    ]
    page = Page(
        title=f"{file.airfoil.name}: can I trust this propeller model?",
        subtitle=f"Fit of {fit.propeller.name} to {KINDS.get(fit.kind, fit.kind)}. Report by "
        f"propmap {propmap.__version__}",
        lead=lead(fit),
        sections=[part.section for part in parts],
        facts=_facts(file, fit, where, sha256),
    )
    files: dict[str, str | bytes] = {PAGE: page_html(page)}
    for part in parts:
        files |= part.files
    return files


def _facts(file: FitFile, fit: FitRecord, where: str, sha256: str) -> tuple[tuple[str, str], ...]:
    blade, air = file.model.propeller, file.model.air
    law = file.airfoil
    held = ", ".join(f"{name} {value:g}" for name, value in fit.fixed.items())
    further = [("Held by the user", held)] if held else []
    return (
        ("Fit file", f"{where}, SHA-256 {sha256}"),
        ("Written by", f"propmap {fit.version}"),
        (
            "Propeller",
            f"{blade.name}, {blade.blades} blades, radius {1e3 * blade.radius:.4g} mm, loaded from "
            f"{1e3 * blade.root:.4g} mm",
        ),
        ("Air", f"{air.density:.5g} kg/m³, viscosity {air.viscosity:.4g} Pa s"),
        (
            "Section law",
            f"c_l1 {law.c_l1:.4g} 1/rad, c_l2 {law.c_l2:.4g}, c_d {law.c_d:.4g}, c_d0 "
            f"{law.c_d0:.4g}, alpha_0 {law.alpha_0:.4g} rad, zero_lift_angle "
            f"{law.zero_lift_angle:.4g} rad, drag_factor {law.drag_factor:.4g}",
        ),
        ("Corrections", ", ".join(law.corrections) or "none"),
        *further,
    )
