"""Rotors for views: on NumPy at once, by compiled programs as soon as these are ready."""

from __future__ import annotations

import functools
import logging
import threading

import numpy as np

from propmap.baselines.hover import HoverModel
from propmap.io.operating_points import RPM
from propmap.model.model import Model
from propmap.rotor import Rotor

TIP_SPEEDS = (20.0, 60.0, 150.0)
"""Of the points by which programs are compiled [m/s]."""

KEPT = 32


@functools.lru_cache(maxsize=KEPT)
def exact(model: Model) -> Rotor:
    """The rotor as commands with few points have it: the numbers that are told come from it."""
    return Rotor(model, compiled=False)


@functools.lru_cache(maxsize=KEPT)
def hover_model(model: Model) -> HoverModel:
    """The hover model with this one's loads at rest."""
    return HoverModel.of(exact(model))


class Preparation:
    """Compiles, in a thread of its own, what live updates need; one set serves all blades."""

    def __init__(self, *, wanted: bool = True) -> None:
        self.wanted = wanted
        self._ready: set[object] = set()
        self._begun: set[object] = set()
        self._lock = threading.Lock()
        self._one_at_a_time = threading.Lock()

    def begin(self, model: Model) -> None:
        """Compile for this model, unless that is done or under way; returns at once."""
        if not self.wanted:
            return
        key = _structure(model)
        with self._lock:
            if key in self._begun:
                return
            self._begun.add(key)
        threading.Thread(target=self._compile, args=(model, key), daemon=True).start()

    def done(self, model: Model) -> bool:
        """Whether programs for this model are ready."""
        return bool(self._ready) and _structure(model) in self._ready

    def quick(self, model: Model) -> Rotor:
        """The fastest rotor that answers now."""
        return _compiled(model) if self.done(model) else exact(model)

    def _compile(self, model: Model, key: object) -> None:
        with self._one_at_a_time:
            rotor = _compiled(model)
            omega = np.array(TIP_SPEEDS)[:, None, None] / model.propeller.radius
            speed = np.linspace(0.0, 40.0, 11)[:, None]
            try:
                for beta in ((0.0, 40.0, 90.0), (0.0, 60.0, 130.0, 180.0)):
                    rotor.loads(omega, speed, np.radians(beta))
                rotor.loads(60.0 / model.propeller.radius, 0.0, 0.0)
            except Exception:
                # Views go on with NumPy; the reason is for whoever looks at the terminal.
                logging.getLogger(__name__).exception("compiling failed")
                return
        self._ready.add(key)


@functools.lru_cache(maxsize=KEPT)
def _compiled(model: Model) -> Rotor:
    return Rotor(model).for_all_blades()


@functools.lru_cache(maxsize=KEPT)
def _structure(model: Model) -> object:
    """What compiled programs depend on, beside the sizes that are the same for all."""
    return _compiled(model)._programs


def fastest(model: Model) -> float:
    """A high rotational speed for sliders [rad/s]: a tip at 200 m/s, as a round figure in rpm."""
    return float(np.ceil(200.0 / model.propeller.radius / RPM / 500.0)) * 500.0 * RPM
