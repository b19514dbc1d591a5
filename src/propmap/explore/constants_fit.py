"""Constants that are set by hand, and their fit to measured loads while the page goes on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from propmap.catalogue.identified import PARAMETERS
from propmap.errors import InputError
from propmap.explore.controls import Values
from propmap.explore.jobs import Job
from propmap.explore.session import Session
from propmap.fit.least_squares import Rows
from propmap.fit.parameters import SECTION
from propmap.fit.parameters import Choice as FitChoice
from propmap.fit.tunnel import TunnelData
from propmap.model.airfoil import LIMITS, Airfoil
from propmap.model.model import Model
from propmap.typing import Floats

CONSTANTS = ("c_l1", "c_l2", *(name for name in PARAMETERS if name != "c_l1"))


def law_at_first(session: Session) -> Airfoil:
    """The constants that the ``session`` begins with; ``InputError`` where there are none."""
    law = session.model.airfoil
    if not isinstance(law, Airfoil):
        raise InputError("a section table has no constants", "choose a set of constants")
    return law


def law_of(session: Session, values: Values) -> Airfoil:
    """The constants that are set."""
    law = law_at_first(session)
    changes = {
        name: float(np.clip(values[name], *LIMITS[name][:2]))
        for name in CONSTANTS
        if values[name] != getattr(law, name)
    }
    if not changes:
        return law
    own = tuple(session.model.correction_texts)
    told = {"name": f"{law.name} changed"[:80], "source": "changed in propmap explore"}
    return law.with_parameters(**changes, **told, corrections=own)


def model_of(session: Session, values: Values) -> Model:
    """The model with the constants that are set."""
    law = law_of(session, values)
    return session.model if law is session.model.airfoil else session.model.with_airfoil(law)


@dataclass(frozen=True)
class Fit:
    """A fit of a session's data from the constants that are set."""

    model: Model
    data: TunnelData
    choice: FitChoice

    @classmethod
    def of(cls, session: Session, values: Values) -> Fit:
        """The fit that the page asks for; ``InputError`` where there is nothing to fit."""
        data = session.measured(values["data"])
        if data is None:
            raise InputError("there are no measured loads to fit", "choose or drop some")
        if not values["free"]:
            raise InputError("no constant is free", "choose some")
        law, free = law_of(session, values), tuple(values["free"])
        given = {name: float(getattr(law, name)) for name in SECTION}
        fixed = {name: value for name, value in given.items() if name not in free}
        start = {name: value for name, value in given.items() if name in free}
        return cls(model_of(session, values), data, FitChoice(free, fixed, {}, start))

    def run(self, job: Job) -> Mapping[str, float]:
        """Fit, and tell how far it is."""
        from propmap.fit.fit import Settings, fit
        from propmap.fit.tunnel import tunnel_rows

        rows = tunnel_rows(self.model, self.data, self.choice)
        fitted = fit(_telling(rows, job), self.choice, Settings(starts=1, folds=0))
        errors = []
        for k, name in enumerate(fitted.rows.names):
            modelled, measured = fitted.compared(k)
            off = np.sqrt(np.nanmean((modelled - measured) ** 2) / np.nanmean(measured**2))
            errors.append(f"{name} {100.0 * off:.1f} %")
        half = 1.96 * np.sqrt(np.diag(fitted.uncertainty.covariance))
        told = [
            f"{name} = {value:.4g} ± {one:.2g}"
            for name, value, one in zip(self.choice.free, fitted.x, half, strict=True)
        ]
        job.told = f"Fitted: {'; '.join(told)}. Errors, rms: {', '.join(errors)}."
        return dict(zip(self.choice.free, map(float, fitted.x), strict=True))


def _telling(rows: Rows, job: Job) -> Rows:
    """The rows, which tell how often they were evaluated and with what error."""
    count = 0
    own = rows.model

    def model(values: Mapping[str, float], free: tuple[str, ...]) -> tuple[Floats, Floats]:
        nonlocal count
        found = own(values, free)
        count += 1
        off = (found[0] - rows.measured) / rows.scale
        job.told = (
            f"fitting: {count} evaluations, error {100.0 * np.sqrt(np.nanmean(off**2)):.2f} %"
        )
        return found

    return replace(rows, model=model)
