"""What ``propmap fit`` prints: parameters with their verdicts, residuals, remarks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from propmap.fit.fitted import Fitted
from propmap.fit.parameters import EVERY
from propmap.fit.residuals import errors

if TYPE_CHECKING:
    from rich.console import Console


def draw_fit(
    console: Console, fitted: Fitted, corrections: Sequence[str], remarks: Sequence[str]
) -> None:
    """Print a fit that was made with these corrections."""
    from rich.table import Table

    sure, choice = fitted.uncertainty, fitted.choice
    table = Table(title="Parameters")
    for heading in ("", "value", "95 % interval", "unit", "verdict"):
        table.add_column(heading, justify="right" if heading in ("value",) else "left")
    for k, name in enumerate(choice.free):
        interval = f"{sure.low[k]:.4g} to {sure.high[k]:.4g}"
        if fitted.bootstrapped.size:
            low, high = np.percentile(fitted.bootstrapped[:, k], [2.5, 97.5])
            interval += f" (bootstrap {low:.4g} to {high:.4g})"
        table.add_row(name, f"{fitted.x[k]:.5g}", interval, EVERY[name].unit, sure.verdicts[k])
    console.print(table)
    values = ", ".join(f"{v:.2g}" for v in sure.singular_values)
    console.print(f"sensitivities (singular values per spread, relative): {values}")
    table = Table(title="Residuals, model minus measurement")
    for heading in ("load", "rows", "rms", "relative", "bias", "worst", "cross-validated", "unit"):
        table.add_column(heading, justify="left" if heading in ("load", "unit") else "right")
    rows = fitted.rows
    for k, name in enumerate(rows.names):
        e = errors(*fitted.compared(k))
        crossed = fitted.cross_validated[k]
        table.add_row(
            name,
            str(e.rows),
            f"{e.rms:.4g}",
            f"{100.0 * e.relative_rms:.2f} %",
            f"{e.bias:+.3g}",
            f"{e.worst:+.3g}",
            f"{crossed:.4g}" if np.isfinite(crossed) else "-",
            rows.units[k],
        )
    console.print(table)
    ends = fitted.minimum.ends
    best = sum(end.minimum == 1 for end in ends)
    console.print(f"{len(ends)} starts, {best} of them to the best minimum; {fitted.seconds:.1f} s")
    if corrections:
        console.print(f"with {', '.join(corrections)}, which come along wherever the fit is used")
    for remark in remarks:
        console.print(f"note: {remark}")
