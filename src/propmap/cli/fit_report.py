"""What ``propmap fit`` prints: parameters with their verdicts, residuals, remarks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from propmap.cli.output import grid
from propmap.fit.fit import Fitted
from propmap.fit.least_squares import FlightErrors, errors
from propmap.fit.parameters import described
from propmap.model.corrections import in_words


def told(
    fitted: Fitted,
    corrections: Sequence[str],
    remarks: Sequence[str],
    flights: Mapping[str, Mapping[str, FlightErrors]],
) -> Iterator[object]:
    """Texts and tables on a fit that was made with these corrections, by load and flight too."""
    sure, rows = fitted.uncertainty, fitted.rows
    heads = "<|value|<95 % interval|<unit|<verdict"
    yield grid(heads, [_parameter(fitted, k) for k in range(len(fitted.choice.free))], "Parameters")
    values = ", ".join(f"{v:.2g}" for v in sure.singular_values)
    yield f"sensitivities (singular values per spread, relative): {values}"
    heads = "<load|rows|rms|relative|bias|worst|cross-validated|<unit"
    residuals = [_residuals(fitted, k) for k in range(len(rows.names))]
    yield grid(heads, residuals, "Residuals, model minus measurement")
    if flights:
        heads = "<load|<flight|rows|rms|bias|cross-validated|<unit"
        yield grid(heads, _by_flight(fitted, flights), "Residuals of each flight")
    ends = fitted.minimum.ends
    best = sum(end.minimum == 1 for end in ends)
    many = f"{len(ends)} starts, {best} of them to the best minimum" if len(ends) > 1 else "1 start"
    yield f"{many}; {fitted.seconds:.1f} s"
    yield f"with {in_words(corrections)}, which comes along wherever the fit is used"
    yield from (f"note: {remark}" for remark in remarks)


def _parameter(fitted: Fitted, k: int) -> tuple[str, ...]:
    name, sure = fitted.choice.free[k], fitted.uncertainty
    interval = f"{sure.low[k]:.4g} to {sure.high[k]:.4g}"
    if fitted.bootstrapped.size:
        low, high = np.percentile(fitted.bootstrapped[:, k], [2.5, 97.5])
        interval += f" (bootstrap {low:.4g} to {high:.4g})"
    return name, f"{fitted.x[k]:.5g}", interval, described(name).unit, sure.verdicts[k]


def _by_flight(
    fitted: Fitted, flights: Mapping[str, Mapping[str, FlightErrors]]
) -> list[tuple[str, ...]]:
    return [
        (
            load if first else "",
            flight,
            str(e.rows),
            f"{e.rms:.4g}",
            f"{e.bias:+.3g}",
            f"{e.cross_validated_rms:.4g}" if np.isfinite(e.cross_validated_rms) else "-",
            unit,
        )
        for load, unit in zip(fitted.rows.names, fitted.rows.units, strict=True)
        for first, (flight, e) in zip(
            (True, *(len(flights[load]) * (False,))), flights[load].items(), strict=False
        )
    ]


def _residuals(fitted: Fitted, k: int) -> tuple[str, ...]:
    e, crossed = errors(*fitted.compared(k)), fitted.cross_validated[k]
    return (
        fitted.rows.names[k],
        str(e.rows),
        f"{e.rms:.4g}",
        f"{100.0 * e.relative_rms:.2f} %",
        f"{e.bias:+.3g}",
        f"{e.worst:+.3g}",
        f"{crossed:.4g}" if np.isfinite(crossed) else "-",
        fitted.rows.units[k],
    )
