"""Rotors that views share, made once for each model."""

from __future__ import annotations

import functools

import numpy as np

from propmap.baselines.hover import HoverModel
from propmap.io.operating_points import RPM
from propmap.model.model import Model
from propmap.rotor import Rotor

KEPT = 32


@functools.lru_cache(maxsize=KEPT)
def rotor_of(model: Model) -> Rotor:
    """The rotor of this model."""
    return Rotor(model)


@functools.lru_cache(maxsize=KEPT)
def hover_model(model: Model) -> HoverModel:
    """The hover model with this one's loads at rest."""
    return HoverModel.of(rotor_of(model))


def fastest(model: Model) -> float:
    """A high rotational speed for sliders [rad/s]: a tip at 200 m/s, as a round figure in rpm."""
    return float(np.ceil(200.0 / model.propeller.radius / RPM / 500.0)) * 500.0 * RPM
