"""The page on a fit and the files beside it."""

from __future__ import annotations

from propmap.fit.result_file import FitFile
from propmap.report.fit_page import (
    curves,
    data,
    errors,
    given_data,
    judgement,
    parameters,
    residuals,
)
from propmap.report.fit_page.parameter_draws import held
from propmap.report.page import report_files


def fit_pages(
    file: FitFile, where: str, sha256: str, given: given_data.GivenData | None
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
    fit, lines = file.record, curves.load_curves(file)
    bands = {(one.name, one.unit): one.by_speed for one in fit.loads}
    figures = {
        "fit-coverage": data.coverage_figure(fit),
        "fit-errors": errors.band_figure(bands),
        "fit-loads": curves.curve_figure(lines, given.tunnel if given else None),
        "fit-parameters": parameters.interval_figure(fit),
    }
    sheets = {
        "fit-coverage": data.coverage_sheet(fit),
        "fit-errors": errors.band_sheet(bands),
        "fit-loads": curves.curve_sheet(lines),
        "fit-parameters": parameters.parameter_sheet(fit),
        "fit-correlations": parameters.correlation_sheet(fit),
    }
    if given:
        figures["fit-check"] = errors.band_figure(given.bands)
        sheets["fit-check"] = errors.band_sheet(given.bands)
        shown, sheet = given.figure(file), given.sheet(file)
        if shown is not None and sheet is not None:
            figures["fit-measured"], sheets["fit-measured"] = shown, sheet
        for k, trends in enumerate(given.residuals, start=1):
            figures[f"fit-residuals-{k}"] = residuals.residual_figure(trends)
            sheets[f"fit-residuals-{k}"] = residuals.residual_sheet(trends)
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
        data=data,
        errors=errors,
        bands=bands,
        curves=lines,
        held=held(fit),
        parameters=parameters,
        residuals=residuals,
    )
