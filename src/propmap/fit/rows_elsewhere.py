"""Rows in other processes: they are made there again, since their models cannot be sent."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from propmap.errors import InputError
from propmap.fit.rows import Rows


class RowsElsewhere:
    """What is sent to a worker without its rows, which the worker makes again.

    Attributes
    ----------
    rows : Rows
        What was measured, with its model.
    remake : callable or None
        Gives the rows again; picklable.  None where no other process works.
    """

    rows: Rows
    remake: Callable[[], Rows] | None

    def __getstate__(self) -> dict[str, Any]:
        if self.remake is None:
            raise InputError(
                "workers in other processes cannot be sent the rows of a fit",
                "give remake, which makes them there",
            )
        return {key: value for key, value in vars(self).items() if key != "rows"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        assert self.remake is not None
        self.rows = self.remake()
