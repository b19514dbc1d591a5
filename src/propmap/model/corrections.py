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
    "blade-untwist": "propmap.physics.blade_untwist.BladeUntwist",
    "tip-loss": "propmap.physics.tip_loss.TipLoss",
    "hub-loss": "propmap.physics.tip_loss.HubLoss",
    "pitt-peters": "propmap.physics.inflow_harmonics.PittPeters",
    "pitt-peters-gradient": "propmap.physics.inflow_harmonics.PittPetersGradient",
    "coleman": "propmap.physics.inflow_harmonics.Coleman",
    "drees": "propmap.physics.inflow_harmonics.Drees",
    "white-blake": "propmap.physics.inflow_harmonics.WhiteBlake",
    "mount-drag": "propmap.physics.mount_drag.MountDrag",
    "stall-delay": "propmap.physics.sections.stall_delay.StallDelay",
    "prandtl-glauert": "propmap.physics.sections.compressible.PrandtlGlauert",
    "radial-friction": "propmap.physics.radial_friction.RadialFriction",
}
"""Where each is; a new correction is one file of physics and one line here.  A model applies its
corrections in this order, whichever way they are given: the blade's shape comes first."""

MODELS = {"recommended": ("pitt-peters",), "paper": ()}
"""Corrections by the model's name.  The commands take "recommended" where nothing else is said;
"paper" is Gill & D'Andrea, CCTA 2017, doi 10.1109/CCTA.2017.8062533, to the letter."""


MOUNT_DRAG = "mount-drag"
"""The one that tells of the surroundings of a rotor: no section constant depends on it, so that it
may be another than in the test that the constants are from."""


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


def corrections_of(model: str = "recommended", added: Sequence[str] = ()) -> tuple[Correction, ...]:
    """The corrections of a model by its name, for ``propmap.Model``.

    Parameters
    ----------
    model : str
        "recommended" or "paper", see ``MODELS``.
    added : sequence of str
        More of them, as ``correction`` reads them.  One that sets how the inflow varies around the
        disk, and one with other fields, takes the place of the model's own.

    Raises
    ------
    InputError
        For an unknown model or correction.
    """
    if model not in MODELS:
        raise InputError(f"model {model!r} is not known", f"give one of {', '.join(MODELS)}")
    more = tuple(correction(text) for text in added)
    own = (correction(text) for text in MODELS[model])
    return *(value for value in own if not any(_replaces(one, value) for one in more)), *more


def _replaces(one: Correction, other: Correction) -> bool:
    return type(one) is type(other) or (sets_inflow_shape(one) and sets_inflow_shape(other))


def sets_inflow_shape(value: Correction) -> bool:
    """Whether a correction sets how the inflow varies around the disk."""
    return hasattr(value, "response")


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
    needed = [one.name for one in dataclasses.fields(made) if one.default is dataclasses.MISSING]
    left_out = [field for field in needed if field not in fields]
    if left_out:
        raise InputError(
            f"correction {name}: no {left_out[0]}", f"write {name}:{left_out[0]}=number"
        )
    value: Correction = made(**fields)
    return value


def as_texts(texts: Any) -> tuple[str, ...] | None:
    """Checked texts of corrections, as they stand in a file; ``InputError`` for anything else.

    None stays None: nothing is said of them.
    """
    if texts is None:
        return None
    if not isinstance(texts, (list, tuple)) or not all(isinstance(text, str) for text in texts):
        raise InputError(f'corrections is {texts!r}: write a list such as ["tip-loss"]')
    return tuple(as_text(correction(text)) for text in texts)


def agreed(section: str, own: Sequence[str] | None, given: Sequence[str]) -> tuple[str, ...]:
    """The corrections ``given`` to a section law that was found with ``own``, None if unknown.

    What is mounted may be another than where the constants were found: ``given``, it takes the
    place of its own.

    Raises
    ------
    InputError
        Where others than its own are given; ``section`` is its name.
    """
    wanted, mount = apart(as_texts(given) or ())
    if own is None:
        return *wanted, *mount
    found, own_mount = apart(own)
    if sorted(found) != sorted(wanted):
        raise InputError(
            f"{section} was found with {in_words(found)}, not with {in_words(wanted)}",
            "leave --model and --correction out, which takes what it was found with, or fit again",
        )
    return *found, *(mount or own_mount)


def apart(texts: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The corrections of the physics, and those that tell what is mounted."""
    mount = tuple(text for text in texts if text.partition(":")[0] == MOUNT_DRAG)
    return tuple(text for text in texts if text not in mount), mount


def in_words(texts: Sequence[str]) -> str:
    """Corrections in words: "tip-loss, pitt-peters", or that there are none."""
    return ", ".join(texts) or "the paper's model"


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
