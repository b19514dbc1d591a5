"""The blade to expect of a propeller that is known by diameter, pitch and blades alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from propmap.catalogue.designation import Designation, same_size, series_named
from propmap.catalogue.identified import Identified, all_identified, identified_without_blade
from propmap.catalogue.mean_blade import MeanBlade, bundled_mean, families_measured
from propmap.model.model import Propeller

ERRORS = {
    "family_blade": ((0.09, 0.08), (0.23, 0.21)),
    "siblings_label": ((0.09, 0.10), (0.18, 0.22)),
    "population_blade": ((0.20, 0.19), (0.40, 0.41)),
}
"""Of C_T and C_P of propellers that were left out, blade and section constants alike, rms over rms,
by ``python -m tools.left_out``: half of them err less than the first two, nine in ten less than the
others; by the group there."""


@dataclass(frozen=True, eq=False)
class ExpectedBlade:
    """What a designation means that no measured propeller has.

    Attributes
    ----------
    text : str
        The designation as it was given.
    wanted : Designation
        What it says.
    families : tuple of str
        Codes of the series that its words name, or of the series of the maker.
    unknown : tuple of str
        Its words that name no series.
    shape : MeanBlade
        Of the measured blades of these series, or of all.
    own : Identified or None
        Constants that were identified with this blade, from the propeller's own loads.
    alike : tuple of str
        Names of other propellers of this size that it may be.
    """

    text: str
    wanted: Designation
    families: tuple[str, ...]
    unknown: tuple[str, ...]
    shape: MeanBlade
    own: Identified | None = None
    alike: tuple[str, ...] = ()

    @property
    def family(self) -> str | None:
        """Code of the series; None where it is not known."""
        return self.families[0] if len(self.families) == 1 else None

    @property
    def geometry(self) -> str:
        """Whose mean the blade is, "family" or "population", as ``expected_constants`` takes it."""
        return "family" if self.shape.families == self.families[:1] else "population"

    @property
    def propeller(self) -> Propeller:
        """The blade; two of them where the designation does not say how many."""
        size = self.wanted
        name = "".join(c for c in " ".join(self.text.split()) if c.isprintable())
        return self.shape.propeller(name, size.diameter, size.pitch, size.blades or 2)

    @property
    def told(self) -> str:
        """In one line: what the blade rests on, and how far loads may err."""
        shape = self.shape
        of = f"{len(shape.families)} families"
        if self.geometry == "family":
            of = f"its family, {self.family}"
        some = f"{shape.propellers} propellers" if shape.propellers > 1 else "one propeller"
        reason = "no measured blade of this size"
        if self.own is not None:
            reason = f"the blade of {self.own.tested!r} was not measured"
        elif not self.wanted.words:
            reason = "no maker is named"
        elif self.unknown:
            reason += f" ({' '.join(self.unknown)} names no series known here)"
        if self.alike:
            reason += f" (known of this size: {', '.join(self.alike)})"
        geometry = f"{reason}: geometry by the means of {some} of {of}"
        if self.own is not None:
            return geometry
        half, most = ERRORS[self._group]
        return (
            f"{geometry}; with section constants expected "
            f"likewise, half of such propellers err in thrust and torque by less than "
            f"{half[0]:.0%} and {half[1]:.0%} (rms) in axial flow, nine in ten by less than "
            f"{most[0]:.0%} and {most[1]:.0%}"
        )

    @property
    def _group(self) -> str:
        # Where none of the family was identified, its constants are as little known as any's.
        if self.geometry == "family" and _identified(all_identified(), self.family):
            return "family_blade"
        if self.geometry != "family" and _identified(identified_without_blade(), self.family):
            return "siblings_label"
        return "population_blade"


def _identified(entries: Sequence[Identified], family: str | None) -> bool:
    return any(one.family == family for one in entries)


def expected_blade(text: str, wanted: Designation, measured: Sequence[str] = ()) -> ExpectedBlade:
    """The blade to expect of ``wanted``, by the series that its words name or by all.

    Parameters
    ----------
    text : str
        The designation.
    wanted : Designation
        What it says.
    measured : sequence of str
        Names of measured propellers of the same size, to be told.
    """
    families, unknown = series_named(wanted.words)
    known = [
        one
        for one in identified_without_blade()
        if one.family in families and same_size((wanted.diameter, wanted.pitch), one.size)
    ]
    if len(known) == 1 and wanted.blades in (None, known[0].blades):
        return blade_of(text, wanted, known[0])
    names = (*measured, *(one.propeller for one in known))
    return ExpectedBlade(
        text, wanted, tuple(families), unknown, _shape_of(families), alike=tuple(names)
    )


def blade_of(text: str, wanted: Designation, own: Identified) -> ExpectedBlade:
    """The blade with which ``own`` was identified, for what is called ``text``."""
    return ExpectedBlade(text, wanted, (own.family,), (), _shape_of([own.family]), own)


def _shape_of(families: Sequence[str]) -> MeanBlade:
    """The mean of those of the ``families`` that were measured, of all where none was."""
    return bundled_mean(tuple(f for f in families if f in families_measured()))
