"""Linear regression with a spread of the weights and a noise that maximise the evidence.

C. M. Bishop, Pattern Recognition and Machine Learning, 2006, sections 3.3 and 3.5: weights are
normal about zero.
"""

from __future__ import annotations

import numpy as np

from propmap.typing import Floats

STEPS = 200
"""Of the evidence's fixed-point iteration."""


def regression(design: Floats, target: Floats, share: float) -> tuple[Floats, Floats, float, float]:
    """Weights, their covariance, the noise's deviation, and the gain of ln evidence.

    Every sample counts ``share`` of one, since neighbours err alike.
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
