"""The page on a fit and the files beside it."""

from __future__ import annotations

from propmap.fit.result_file import FitFile
from propmap.report.fit_page.curve_figure import curve_figure
from propmap.report.fit_page.curves import curve_sheet, load_curves, seen_loads
from propmap.report.fit_page.data import (
    angles_without_data,
    coverage_figure,
    coverage_sheet,
    range_rows,
)
from propmap.report.fit_page.errors import band_figure, band_rows, band_sheet, whole_rows
from propmap.report.fit_page.given_data import (
    GivenData,
    check_verdict,
    measured_figure,
    measured_sheet,
)
from propmap.report.fit_page.judgement import CARE, GOOD, WORDS, judge
from propmap.report.fit_page.parameter_draws import held
from propmap.report.fit_page.parameters import (
    correlation_rows,
    correlation_sheet,
    interval_figure,
    parameter_rows,
    parameter_sheet,
    strong_pairs,
)
from propmap.report.page import report_files


def fit_pages(
    file: FitFile, where: str, sha256: str, given: GivenData | None
) -> dict[str, str | bytes]:
    """All files of the page on a fit by name.

    Parameters
    ----------
    file : FitFile
        The fit.
    where, sha256 : str
        Its path and its SHA-256.
    given : GivenData or None
        Further data.
    """
    fit, curves = file.record, load_curves(file, file.record)
    bands = {(one.name, one.unit): one.by_speed for one in fit.loads}
    measured = given.tunnel if given else None
    figures = {
        "fit-coverage": coverage_figure(fit),
        "fit-errors": band_figure(bands),
        "fit-loads": curve_figure(curves, seen_loads(fit), measured),
        "fit-parameters": interval_figure(fit),
    }
    sheets = {
        "fit-coverage": coverage_sheet(fit),
        "fit-errors": band_sheet(bands),
        "fit-loads": curve_sheet(curves),
        "fit-parameters": parameter_sheet(fit),
        "fit-correlations": correlation_sheet(fit),
    }
    values = {}
    if given:
        figures["fit-check"], sheets["fit-check"] = (
            band_figure(given.bands),
            band_sheet(given.bands),
        )
        shown, sheet = measured_figure(file, given), measured_sheet(file, given)
        if shown is not None and sheet is not None:
            figures["fit-measured"], sheets["fit-measured"] = shown, sheet
        seen = {one.sha256 or one.name for one in fit.data}
        known, new = (
            [one.name for one in given.sources if ((one.sha256 or one.name) in seen) == wanted]
            for wanted in (True, False)
        )
        values = {
            "check": check_verdict(given),
            "check_rows": band_rows(given.bands),
            "known": known,
            "new": new,
        }
    judgement = judge(fit)
    return report_files(
        "report/fit_page/page.html.j2",
        figures,
        sheets,
        file=file,
        fit=fit,
        where=where,
        sha256=sha256,
        given=given,
        judgement=judgement,
        words=WORDS,
        limits=(GOOD, CARE),
        ranges=range_rows(fit),
        far=angles_without_data(fit),
        whole=whole_rows(judgement.loads),
        bands=band_rows(bands),
        curves=curves,
        held=held(fit),
        files=[(one.name, one.sha256 or "part of propmap") for one in fit.data],
        fixed=", ".join(f"{name} {value:g}" for name, value in fit.fixed.items()),
        weak=[p.name for p in fit.parameters if not p.identified],
        parameters=parameter_rows(fit),
        correlations=correlation_rows(fit),
        pairs=strong_pairs(fit),
        **values,
    )
