"""How makers of propellers for multirotors designate them: one table of their rules."""

from __future__ import annotations

import re
from typing import NamedTuple


class Rule(NamedTuple):
    """What a form of designation means with one maker."""

    form: str  # pattern of what is printed, in lower case
    blades: int
    means: str
    size: tuple[float, float] | None = None  # diameter and pitch [in] that the form stands for


class Maker(NamedTuple):
    """A maker of propellers for multirotors; without rules, its designations say all they mean."""

    name: str
    words: str  # pattern of what it and its series are called, in lower case
    rules: tuple[Rule, ...] = ()


_THREE_BY_T = r"t[2-7]\d{3}"  # T1045 of T-Motor has two

MAKERS = (
    Maker(
        "DALPROP",
        "dal|dalprop|cyclone",
        (
            Rule(_THREE_BY_T, 3, "T is its mark of three"),
            Rule(r"q\d{4}", 4, "Q is its mark of four"),
        ),
    ),
    Maker("T-Motor", "t[- ]?motor", (Rule(_THREE_BY_T, 3, "its T below eight inches have three"),)),
    Maker(
        "Gemfan",
        "gemfan|gf|hurricane",
        (Rule(r"\d{5}", 3, "its sizes in five digits have three"),),
    ),
    Maker(
        "Ethix",
        "ethix",
        tuple(
            Rule(name, 3, f"{name.upper()} is its 5x{pitch:g}x3", (5.0, pitch))
            for name, pitch in (("s3", 3.1), ("s4", 3.7), ("s5", 4.0))
        ),
    ),
    Maker("HQProp", "hq|hqprop"),
    Maker("DJI", "dji"),
    Maker("Lumenier", "lumenier"),
    Maker("EMAX", "emax|avan"),
    Maker("Azure Power", "azure"),
)
"""Makers with the rules that are known of them; shops' and makers' pages agree on these."""

_NAMES = {maker: rf"(?<![a-z])(?:{maker.words})(?![a-z])" for maker in MAKERS}


def spaced(text: str) -> str:
    """Part a maker's name from the figure behind it, as in "gf51466"; ``text`` in lower case."""
    for name in _NAMES.values():
        text = re.sub(rf"({name})(?=\d)", r"\1 ", text)
    return text


def maker_of(text: str) -> str:
    """Name the maker that a designation in lower case names; "" where it is none of these."""
    return next((maker.name for maker, name in _NAMES.items() if re.search(name, text)), "")


def ruled(text: str) -> tuple[str, Rule] | None:
    """Find the rule that a designation in lower case follows, and whose it is.

    Where it names none of these makers the rule may be anybody's, but for names that stand for a
    size.
    """
    named = [maker for maker, name in _NAMES.items() if re.search(name, text)]
    for maker in named or MAKERS:
        for rule in maker.rules:
            found = re.search(rf"(?<![\w.]){rule.form}(?!\d)", text)
            if found and (named or rule.size is None):
                return maker.name, rule
    return None
