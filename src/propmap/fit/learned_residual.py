"""A small learned correction of what the physics leaves, linear in non-dimensional features.

The errors of a flight are correlated within a second, so that a stretch of a second counts as one
sample of the regression.  Outside the envelope of the flights it was trained on,
the correction is clipped and fades.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from propmap.errors import InputError
from propmap.fit.flight import CORRELATED
from propmap.results import spin_sign
from propmap.typing import Floats
from propmap.vehicle.log import FlightLog
from propmap.vehicle.vehicle import Vehicle

FOLDS = 5
"""Parts of each flight, one after the other, that are left out in turn."""

LEAST = 20
"""Stretches of a second to learn from; the spread of the weights holds what these leave open."""

FADE = 0.25
"""How far outside the envelope the correction is gone, as a share of the envelope."""

CERTAIN = 3.0
"""Gain of ln evidence over no correction from which it is called sure: odds of 20 to 1."""


def features(vehicle: Vehicle, log: FlightLog) -> dict[str, Floats]:
    """What the correction is linear in, by name (n,), all without dimension."""
    square = np.square(log.rotor_speed)
    omega = np.sqrt(np.mean(square, axis=1))
    radius = vehicle.propeller.radius
    x, y, z = (log.velocity / (omega * radius)[:, None]).T
    roll, pitch, yaw = (log.rates / omega[:, None]).T
    places = np.array([mount.position for mount in vehicle.mounts]) / radius
    spins = np.array([spin_sign(mount.spin) for mount in vehicle.mounts])
    share = square / np.sum(square, axis=1, keepdims=True)
    return {
        "constant": np.ones(len(log)),
        "advance ratio along x": x,
        "advance ratio along y": y,
        "advance ratio along z": z,
        "square along x": x**2,
        "square along y": y**2,
        "square along z": z**2,
        "product of x and z": x * z,
        "product of y and z": y * z,
        "roll rate over rotor speed": roll,
        "pitch rate over rotor speed": pitch,
        "yaw rate over rotor speed": yaw,
        "imbalance of thrust along x": share @ places[:, 0],
        "imbalance of thrust along y": share @ places[:, 1],
        "imbalance of spins": share @ spins,
    }


@dataclass(frozen=True, eq=False)
class AddedForce:
    """Forces that a learned residual adds at n samples."""

    force: Floats  # what it adds [N], (n, 3)
    deviation: Floats  # standard deviation of what is left [N], (n, 3)
    strength: Floats  # 1 within the envelope of its training, falling to 0 outside [-], (n,)

    @property
    def status(self) -> NDArray[np.str_]:
        """ "ok" within the envelope, "faded" near it, "off" further away; (n,)."""
        return np.select([self.strength >= 1.0, self.strength > 0.0], ["ok", "faded"], "off")


class LearnedResidual(msgspec.Struct, frozen=True, eq=False):
    """Weights of F features for each of three axes.

    Attributes
    ----------
    names : tuple of str
        Of the features.
    low, high : ndarray, shape (F,)
        Envelope of the training.
    middle, spread : ndarray, shape (F,)
        By which features are brought to a common size.
    weights : ndarray, shape (3, F)
        Of features of that size, in units of rho A (Omega R)^2 of all rotors.
    covariance : ndarray, shape (3, F, F)
        Of the weights.
    noise : ndarray, shape (3,)
        Standard deviation of what is left, in the same unit.
    evidence : ndarray, shape (3,)
        By how much ln evidence is more than without any correction.
    without, with_it : ndarray, shape (3,)
        Root mean square errors on parts that were left out [N].
    """

    names: tuple[str, ...]
    low: Floats
    high: Floats
    middle: Floats
    spread: Floats
    weights: Floats
    covariance: Floats
    noise: Floats
    evidence: Floats
    without: Floats
    with_it: Floats

    def __post_init__(self) -> None:
        count = len(self.names)
        sound = self.weights.shape == (3, count) and self.low.shape == (count,)
        if not (sound and self.covariance.shape == (3, count, count)):
            raise ValueError("its arrays do not fit together")

    @property
    def pays(self) -> tuple[bool, ...]:
        """Whether it does, along each axis: by the evidence, and on what was left out."""
        sure = (self.evidence > CERTAIN) & (self.with_it < self.without)
        return tuple(bool(one) for one in sure)

    def at(self, vehicle: Vehicle, log: FlightLog) -> AddedForce:
        """What to add to the forces of the physics, along the axes on which it pays.

        Parameters
        ----------
        vehicle, log : Vehicle, FlightLog
            What flew, and n samples of how.
        """
        found = np.stack(list(features(vehicle, log).values()), axis=1)
        inside = np.clip(found, self.low, self.high)
        size = np.where(self.high > self.low, self.high - self.low, 1.0)
        outside = np.max(np.abs(found - inside) / size, axis=1)
        strength = np.clip(1.0 - outside / FADE, 0.0, 1.0)
        design = (inside - self.middle) / self.spread
        scale = _scale(vehicle, log)
        pays = np.array(self.pays)
        force = strength[:, None] * scale[:, None] * (design @ self.weights.T) * pays
        spread = np.einsum("nf,afg,ng->na", design, self.covariance, design) * pays
        return AddedForce(force, scale[:, None] * np.sqrt(self.noise**2 + spread), strength)

    def sentences(self) -> list[str]:
        """Say of each axis whether the residual pays."""
        pairs = zip("xyz", self.pays, self.without, self.with_it, self.evidence, strict=True)
        return [
            f"learned residual along {axis}: {'pays' if pays else 'does not pay, left out'} "
            f"({without:.3g} to {after:.3g} N rms on parts left out, ln evidence {sure:+.3g})"
            for axis, pays, without, after, sure in pairs
        ]

    def table(self) -> dict[str, Any]:
        """Plain data for a TOML file."""
        plain: dict[str, Any] = msgspec.to_builtins(self, enc_hook=lambda array: array.tolist())
        return plain

    @classmethod
    def of_table(cls, table: Mapping[str, Any]) -> LearnedResidual:
        """From a ``table`` of a TOML file; ``InputError`` where it is damaged."""
        try:
            return msgspec.convert(table, cls, dec_hook=lambda _, v: np.array(v, np.float64))
        except msgspec.ValidationError as error:
            raise InputError(
                f"the learned residual is damaged: {error}", "write it again with propmap fit"
            ) from None


def learn(vehicle: Vehicle, log: FlightLog, left: Floats) -> LearnedResidual:
    """Learn what a model leaves over.

    Parameters
    ----------
    vehicle, log : Vehicle, FlightLog
        What flew, and n samples of how.
    left : ndarray, shape (n, 3)
        Measured less modelled forces [N]; NaN where there is none.

    Raises
    ------
    InputError
        Where there are fewer than ``LEAST`` stretches.
    """
    by_name = features(vehicle, log)
    names = tuple(by_name)
    found, scale = np.stack(list(by_name.values()), axis=1), _scale(vehicle, log)
    known = np.isfinite(left).all(axis=1)
    found, scale, left = found[known], scale[known], left[known]
    blocks = log.stretches(CORRELATED)[known]
    count = np.unique(blocks).size
    if count < LEAST:
        raise InputError(
            f"the flights have {count} stretches of {CORRELATED:g} s",
            f"learn a residual from {LEAST} or more, or leave --residual out",
            log.source,
        )
    middle, spread = _sizes(found, scale)
    design = (found - middle) / spread
    target = left / scale[:, None]
    share = count / len(target)
    fits = [regression(design, target[:, axis], share) for axis in range(3)]
    folds = _folds(log.picked(known))
    held_out = np.zeros_like(left)
    for fold in range(FOLDS):
        train, test = folds != fold, folds == fold
        for axis in range(3):
            weights, *_ = regression(design[train], target[train, axis], share)
            held_out[test, axis] = left[test, axis] - scale[test] * (design[test] @ weights)
    return LearnedResidual(
        names=names,
        low=found.min(axis=0),
        high=found.max(axis=0),
        middle=middle,
        spread=spread,
        weights=np.stack([one[0] for one in fits]),
        covariance=np.stack([one[1] for one in fits]),
        noise=np.array([one[2] for one in fits]),
        evidence=np.array([one[3] for one in fits]),
        without=np.sqrt(np.mean(left**2, axis=0)),
        with_it=np.sqrt(np.mean(held_out**2, axis=0)),
    )


def _scale(vehicle: Vehicle, log: FlightLog) -> Floats:
    """rho A (Omega R)^2, summed over the rotors [N], (n,)."""
    radius = vehicle.propeller.radius
    disk = vehicle.air.density * np.pi * radius**2
    total: Floats = disk * radius**2 * np.sum(np.square(log.rotor_speed), axis=1)
    return total


def _sizes(found: Floats, scale: Floats) -> tuple[Floats, Floats]:
    """Mean and deviation of each feature; 0 and 1 of one that never changes."""
    weight = scale / scale.sum()
    middle = weight @ found
    spread = np.sqrt(weight @ np.square(found - middle))
    still = spread < 1e-9
    return np.where(still, 0.0, middle), np.where(still, 1.0, spread)


def _folds(log: FlightLog) -> NDArray[np.intp]:
    """Which part of its flight each sample is in, of ``FOLDS``; (n,)."""
    place = np.empty(len(log), np.intp)
    for number in np.unique(log.flight):
        mine = log.flight == number
        since = log.since_start[mine]
        place[mine] = np.minimum((since / (since.max() + 1e-9) * FOLDS).astype(int), FOLDS - 1)
    return place


# -------------------------------------------------------------------------------------------------
# Linear regression with a spread of the weights and a noise that maximise the evidence.
#
# C. M. Bishop, Pattern Recognition and Machine Learning, 2006, sections 3.3 and 3.5: weights are
# normal about zero.

STEPS = 200
"""Steps of the evidence's fixed-point iteration."""


def regression(design: Floats, target: Floats, share: float) -> tuple[Floats, Floats, float, float]:
    """Weights, their covariance, the noise's deviation, and the gain of ln evidence.

    Every sample counts ``share`` of one, since neighbours have correlated errors.
    """
    count, number = share * len(target), design.shape[1]
    values, vectors = np.linalg.eigh(share * design.T @ design)
    values = np.maximum(values, 0.0)
    turned = vectors.T @ (share * design.T @ target)
    square = share * float(target @ target)
    null = count / max(square, 1e-300)
    precision, noise = 10.0 * null, null  # of the weights, and of a sample
    for _ in range(STEPS):
        mean = noise * turned / (precision + noise * values)
        used = float(np.sum(noise * values / (precision + noise * values)))
        left = square - 2.0 * float(mean @ turned) + float(values @ mean**2)
        precision = max(used, 1e-9) / max(float(mean @ mean), 1e-300)
        noise = max(count - used, 1e-9) / max(left, 1e-300)
    mean = noise * turned / (precision + noise * values)
    left = square - 2.0 * float(mean @ turned) + float(values @ mean**2)
    evidence = 0.5 * (
        number * np.log(precision)
        + count * np.log(noise)
        - noise * left
        - precision * float(mean @ mean)
        - float(np.sum(np.log(precision + noise * values)))
    )
    nothing = 0.5 * (count * np.log(null) - count)
    covariance = (vectors / (precision + noise * values)) @ vectors.T
    return vectors @ mean, covariance, float(noise**-0.5), float(evidence - nothing)
