"""What does not agree, first: camber."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from propmap.fit.residuals import rms
from propmap.papers.gill_dandrea_2017.identified import AXIAL
from propmap.papers.gill_dandrea_2017.numbers import Numbers
from propmap.papers.gill_dandrea_2017.tunnel import Compared
from propmap.papers.gill_dandrea_2017.tunnel_curves import AxialCurve, coefficients
from propmap.report.page import Section, Text, Verdict, number
from propmap.report.part import Part, files_of, picture
from propmap.report.sheet import csv_of_rows
from propmap.report.style import COLOURS, MARKERS, new_figure, style

PARTS = (("thrust_coefficient", "C_T"), ("power_coefficient", "C_P"))


def camber(numbers: Numbers) -> Part:
    """The printed law, the best of its form, and the best with a zero-lift angle."""
    one, curves = numbers.tunnel[AXIAL], numbers.axial_curves
    shown = picture(
        camber_figure(one, curves),
        "camber",
        "APC 8x6E in axial flow: model at 5000 rpm less measured (UIUC, all rotational speeds), "
        "for Table I as printed, for the best that its four parameters can do, and with a "
        "zero-lift angle as a fifth. A perfect model lies on zero.",
        "Errors of thrust and power coefficient against advance ratio.",
    )
    four, five = ([_rms(one, c, f) for f, _ in PARTS] for c in curves[1:])
    angle = np.degrees(numbers.fits.axial.law.zero_lift_angle)
    other = np.degrees(numbers.fits.oblique.law.zero_lift_angle)
    section = Section(
        "camber",
        "What does not agree: camber",
        (
            Verdict(
                "bad",
                "The printed law does not fit",
                "The paper's section has no lift at zero angle of attack. Real blades are "
                "cambered, and published twist is that of the chord line. No choice of the four "
                f"parameters fits the 8x6E: the best leaves {four[0]:.3f} rms in C_T and "
                f"{four[1]:.3f} in C_P. One zero-lift angle more leaves {five[0]:.3f} and "
                f"{five[1]:.3f}.",
            ),
            shown,
            Text(
                f"The fits put the zero-lift angle at {number(angle, 2)}° (UIUC) and "
                f"{number(other, 2)}° (2019), "
                "ordinary values for thin cambered sections. It is this package's one addition "
                "to the paper's law. If your twist is already taken from the zero-lift line, hold "
                "it at zero; otherwise fit it together with the other four. Whether Table I goes "
                "with a twist from another line is not known here."
            ),
        ),
    )
    return Part(section, files_of(shown) | {"camber.csv": _csv(one, curves)})


def camber_figure(one: Compared, curves: list[AxialCurve]) -> Figure:
    """Model less measured over J."""
    advance = coefficients(one.data)[0]
    with style():
        figure = new_figure(9.2, 4.0)
        axes = figure.subplots(1, 2)
        for ax, (field, symbol) in zip(axes, PARTS, strict=True):
            ax.axhline(0.0, color="0.4", linewidth=0.8)
            for k, curve in enumerate(curves):
                ax.plot(
                    advance, _errors(one, curve, field), color=COLOURS[k], marker=MARKERS[k],
                    linestyle="none", markersize=3.5, label=curve.label, clip_on=False,
                )  # fmt: skip
            ax.set_xlabel("advance ratio J = V/(nD) [-]")
            ax.set_ylabel(f"model less measured ${symbol}$ [-]")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def _errors(one: Compared, curve: AxialCurve, field: str) -> np.ndarray:
    advance, thrust, power = coefficients(one.data)
    measured = thrust if field == "thrust_coefficient" else power
    return np.asarray(np.interp(advance, curve.advance, getattr(curve, field)) - measured)


def _rms(one: Compared, curve: AxialCurve, field: str) -> float:
    return rms(_errors(one, curve, field))


def _csv(one: Compared, curves: list[AxialCurve]) -> str:
    advance, thrust, power = coefficients(one.data)
    columns = {"advance_ratio": advance, "measured_C_T": thrust, "measured_C_P": power}
    for curve in curves:
        slug = curve.label.lower().replace(",", "").replace(" ", "_")
        for field, symbol in PARTS:
            columns[f"{slug}_{symbol}_error"] = _errors(one, curve, field)
    return csv_of_rows(list(columns), np.stack(list(columns.values()), axis=1).tolist())
