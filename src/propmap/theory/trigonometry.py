"""Trigonometric functions that a processor's vector units evaluate.

XLA calls the mathematics library once per element for the sine, cosine and arctangent of float64
on a CPU: 18 ns for sine and cosine, and often again for each user of the result.
"""

from __future__ import annotations

import math

from propmap.theory.arrays import DerivativeByRule, xp
from propmap.theory.parameters import Array

_ARCTAN_ABOVE = (
    0.9999999999999999,
    2.2778549627173237,
    1.82145571578703,
    0.6078190287635806,
    0.07759280490509678,
    0.0025331139197620122,
)
_ARCTAN_BELOW = (
    1.0,
    2.6111882960506074,
    2.4918518144739266,
    1.059055783813189,
    0.19415682616035726,
    0.012196777693031713,
    0.00011322044128524324,
)
"""arctan(t)/t as a ratio of polynomials in t^2, lowest power first: good to 4e-16 for |t| <= 1.

Fitted to it on [0, 1] at Chebyshev points, weighted towards the smallest largest error."""


@DerivativeByRule
def arctangent(t: Array) -> Array:
    """arctan(t) [rad] for |t| <= 1."""
    z = t * t
    return t * _polynomial(_ARCTAN_ABOVE, z) / _polynomial(_ARCTAN_BELOW, z)


def _polynomial(coefficients: tuple[float, ...], z: Array) -> Array:
    total = xp.full_like(z, coefficients[-1])
    for c in coefficients[-2::-1]:
        total = total * z + c
    return total


@arctangent.defjvp
def _arctangent_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    (t,), (t_dot,) = primals, tangents
    return arctangent(t), t_dot / (1.0 + t * t)


_SINE = tuple((-1.0) ** k / math.factorial(2 * k + 1) for k in range(10))
_COSINE = tuple((-1.0) ** k / math.factorial(2 * k) for k in range(11))
"""Taylor's series in x^2: up to x = pi/2 what is left out is below 3e-16."""


@DerivativeByRule
def sine_and_cosine(angle: Array) -> tuple[Array, Array]:
    """sin and cos of ``angle`` [rad], any shape, for |angle| <= pi, to 2e-15.

    By the series of half the angle, in a third of the time of the library's.
    """
    half = 0.5 * angle
    z = half * half
    sine, cosine = half * _polynomial(_SINE, z), _polynomial(_COSINE, z)
    return 2.0 * sine * cosine, 1.0 - 2.0 * sine * sine


@sine_and_cosine.defjvp
def _sine_and_cosine_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    (angle,), (change,) = primals, tangents
    sine, cosine = sine_and_cosine(angle)
    return (sine, cosine), (cosine * change, -sine * change)
