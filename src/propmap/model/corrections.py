"""The corrections that a model can have, by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

from propmap.errors import InputError

if TYPE_CHECKING:
    from propmap.physics.rotor import RotorArrays

CORRECTIONS = {
    "blade-to-hub": "propmap.physics.blade_to_hub.BladeToHub",
    "tip-loss": "propmap.physics.tip_loss.TipLoss",
    "hub-loss": "propmap.physics.tip_loss.HubLoss",
    "pitt-peters": "propmap.physics.inflow_harmonics.PittPeters",
    "pitt-peters-gradient": "propmap.physics.inflow_harmonics.PittPetersGradient",
    "coleman": "propmap.physics.inflow_harmonics.Coleman",
    "drees": "propmap.physics.inflow_harmonics.Drees",
    "white-blake": "propmap.physics.inflow_harmonics.WhiteBlake",
    "stall-delay": "propmap.physics.sections.stall_delay.StallDelay",
    "prandtl-glauert": "propmap.physics.sections.compressible.PrandtlGlauert",
    "radial-friction": "propmap.physics.radial_friction.RadialFriction",
}
"""Where each is; a new correction is one file of physics and one line here.  A model applies its
corrections in this order, whichever way they are given: the blade's shape comes first."""


class Correction(Protocol):
    """A change to the physics, as a validated value: a frozen dataclass of numbers."""

    def applied(self, rotor: RotorArrays) -> RotorArrays:
        """The ``rotor`` with this change."""
        ...


def correction(text: str) -> Correction:
    """A correction from its name and numbers, as in ``hub-loss:radius_m=0.012``.

    Parameters
    ----------
    text : str
        A name of ``CORRECTIONS``; behind a colon its fields, separated by commas.

    Raises
    ------
    InputError
        For an unknown name or field, or a value that is no number.
    """
    name, colon, given = text.partition(":")
    if name not in CORRECTIONS:
        raise InputError(
            f"correction {name!r} is not known", f"give one of {', '.join(CORRECTIONS)}"
        )
    fields: dict[str, float] = {}
    for part in given.split(",") if colon else ():
        field, _, value = part.partition("=")
        field = field.strip()
        if field in fields:
            raise InputError(f"correction {text!r}: {field} is given twice", "give it once")
        try:
            fields[field] = float(value)
        except ValueError:
            raise InputError(
                f"correction {text!r}: {part!r} is no field with a number",
                f"write {name}:field=number",
            ) from None
    return from_fields(name, fields)


def from_fields(name: str, fields: dict[str, Any]) -> Correction:
    """A correction from its name and fields, as they are kept in files."""
    import importlib

    if name not in CORRECTIONS:
        raise InputError(
            f"correction {name!r} is not known", f"this version has {', '.join(CORRECTIONS)}"
        )
    module, _, kind = CORRECTIONS[name].rpartition(".")
    made = getattr(importlib.import_module(module), kind)
    known = [field.name for field in dataclasses.fields(made)]
    extra = sorted(set(fields) - set(known))
    if extra:
        raise InputError(
            f"correction {name}: unknown field {extra[0]!r}",
            f"it has {', '.join(known) or 'no fields'}",
        )
    value: Correction = made(**fields)
    return value


def as_texts(texts: Any) -> tuple[str, ...]:
    """Checked texts of corrections, as they stand in a file; ``InputError`` for anything else."""
    if not isinstance(texts, (list, tuple)) or not all(isinstance(text, str) for text in texts):
        raise InputError(f'corrections is {texts!r}: write a list such as ["tip-loss"]')
    return tuple(as_text(correction(text)) for text in texts)


def agreed(section: str, own: Sequence[str], given: Sequence[str]) -> tuple[str, ...]:
    """The corrections to use with a section law that was found with ``own``.

    Raises
    ------
    InputError
        Where others than its own are ``given``; ``section`` is its name.
    """
    wanted = as_texts(given)
    if own and wanted and sorted(own) != sorted(wanted):
        raise InputError(
            f"{section} was found with {', '.join(own)}, not with {', '.join(wanted)}",
            "leave the corrections out, which takes those it was found with, or fit again",
        )
    return wanted or tuple(own)


def name_of(value: Correction) -> str:
    """The name by which ``correction`` knows it.

    Raises
    ------
    InputError
        For a value that is no correction.
    """
    path = f"{type(value).__module__}.{type(value).__qualname__}"
    for name, place in CORRECTIONS.items():
        if place == path:
            return name
    raise InputError(
        f"{value!r} is no correction",
        f"give one of {', '.join(CORRECTIONS)}, see propmap.correction",
    )


def as_text(value: Correction) -> str:
    """The text from which ``correction`` makes it again."""
    fields = dataclasses.asdict(value)  # type: ignore[call-overload]
    told = ",".join(f"{field}={number!r}" for field, number in fields.items() if number is not None)
    return f"{name_of(value)}:{told}" if told else name_of(value)
