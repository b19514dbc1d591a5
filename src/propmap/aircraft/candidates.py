"""Propellers that an aircraft might fly with, and the constants of their blades."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from propmap.catalogue.identified import all_identified
from propmap.catalogue.known import constants_to_expect, own_constants
from propmap.catalogue.lookup import meant_by, propeller
from propmap.errors import InputError
from propmap.model.airfoil import Airfoil
from propmap.model.model import Section
from propmap.model.propeller import Propeller
from propmap.model.section_covariance import SectionCovariance


@dataclass(frozen=True, eq=False)
class Candidate:
    """A propeller to choose.

    Attributes
    ----------
    name : str
        In the catalogue, or of its file.
    propeller : Propeller
        Geometry.
    airfoil : Section
        Constants of its blades.
    covariance : SectionCovariance or None
        Of these constants; None where they were not identified for this propeller.
    verdict : str
        "good", or what is wrong with the constants.
    """

    name: str
    propeller: Propeller
    airfoil: Section
    covariance: SectionCovariance | None = None
    verdict: str = "good"

    def varied(self) -> list[Candidate]:
        """The same with constants off by one standard deviation along each principal axis of their
        covariance; where a constant would leave its bounds, to the other side, or not at all."""
        if self.covariance is None or not isinstance(self.airfoil, Airfoil):
            return []
        known = self.covariance.determined
        variances, axes = np.linalg.eigh(known.matrix)
        found = []
        for variance, axis in zip(variances, axes.T, strict=True):
            for size in (math.sqrt(max(variance, 0.0)), -math.sqrt(max(variance, 0.0))):
                change: Any = {
                    name: getattr(self.airfoil, name) + size * float(part)
                    for name, part in zip(known.names, axis, strict=True)
                }
                try:
                    found.append(replace(self, airfoil=self.airfoil.with_parameters(**change)))
                except InputError:
                    continue
                break
        return found


def catalogue_candidates(
    diameter: tuple[float, float] = (0.0, math.inf), blades: int | None = None
) -> list[Candidate]:
    """Every propeller whose constants were identified.

    Parameters
    ----------
    diameter : tuple of 2 float
        Least and largest [m].
    blades : int, optional
        How many; by default any.

    Raises
    ------
    InputError
        Where there is none.
    """
    low, high = diameter
    found = []
    for one in all_identified():
        if blades not in (None, one.blades):
            continue
        blade = propeller(one.propeller, one.blades)
        # 10 in are 0.254 m but for rounding in the catalogue.
        if low - 1e-6 <= blade.diameter <= high + 1e-6:
            name = one.propeller if one.blades == 2 else f"{one.propeller}, {one.blades} blades"
            found.append(Candidate(name, blade, one.airfoil, one.section_covariance, one.verdict))
    if not found:
        raise InputError(
            f"no propeller of the catalogue has {low / 0.0254:.3g} to {high / 0.0254:.3g} in"
            + (f" and {blades} blades" if blades else ""),
            "ask for other diameters, see `propmap props`",
        )
    return found


def file_candidate(path: str | os.PathLike[str], section: Section | None = None) -> Candidate:
    """A propeller from a file, or by its name, with constants of its own or to be expected.

    Parameters
    ----------
    path : path or str
        As for ``propmap.propeller``.
    section : Section, optional
        Its section law; by default the best constants that are known of it, see
        ``propmap.known_model``.
    """
    blade = propeller(path)
    law, verdict = section, "section law as given"
    if law is None:
        meant = meant_by(path)
        own = own_constants(meant, blade.blades)
        law = own.airfoil if own else constants_to_expect(meant, blade).airfoil
        verdict = own.verdict if own else "constants to be expected, not identified"
    known = getattr(law, "uncertainty", None)
    return Candidate(os.fspath(path), blade, law, known and known.covariance, verdict)
