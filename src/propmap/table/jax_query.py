"""Queries of a table in JAX, for differentiable simulators: jit, vmap, jvp and grad.

The loads agree with ``LoadTable``, in the precision of the JAX settings.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from propmap.errors import require
from propmap.jax import real_arrays
from propmap.table.interpolation import NO_VALUE, OUTSIDE, cell_codes, interval_polynomials
from propmap.table.query import SLACK, TORQUE, JaxLoads, LoadTable, cartesian_slopes, chain_rule

require("jax")
import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402


class JaxTable(NamedTuple):
    """A table as JAX arrays; a pytree, so that compiled functions accept it as an argument.

    Create one with ``JaxTable.from_table(table)``.
    """

    padded: Any
    advance: Any
    beta: Any
    advance_weights: Any
    beta_weights: Any
    lows: Any
    highs: Any
    radius: Any
    codes: Any

    @classmethod
    def from_table(cls, table: LoadTable) -> JaxTable:
        """Convert a ``table`` to JAX arrays: float32, or float64 if JAX has x64 enabled."""
        content = table.content
        lows, highs = zip(*table.envelope.values(), strict=True)
        return cls(
            padded=jnp.asarray(content.padded()),
            advance=jnp.asarray(content.advance),
            beta=jnp.asarray(content.beta),
            advance_weights=jnp.asarray(interval_polynomials(content.advance)),
            beta_weights=jnp.asarray(interval_polynomials(content.beta)),
            lows=jnp.asarray(lows),
            highs=jnp.asarray(highs),
            radius=jnp.asarray(content.radius),
            codes=jnp.asarray(cell_codes(content)),
        )

    def loads(self, omega: Any, speed: Any, beta: Any, *, clamp: bool = False) -> JaxLoads:
        """Interpolate the loads at operating points.

        Parameters
        ----------
        omega, speed, beta : array
            Omega [rad/s], V [m/s] and beta [rad] in 0...pi; broadcast.
        clamp : bool
            Whether points outside the envelope have the loads of the nearest point of the envelope
            instead of NaN.  Their derivatives normal to the boundary of the envelope are zero.
        """
        w, v, b, inside = self._bounded(omega, speed, beta)
        values = _at(self, w, v * jnp.cos(b), v * jnp.sin(b))
        return _finish(values, w, inside | clamp)

    def loads_at_velocity(self, omega: Any, velocity: Any, *, clamp: bool = False) -> JaxLoads:
        """Interpolate the loads for a velocity in the rotor frame.

        Derivatives are finite everywhere in the envelope, also at rest.  Without in-plane velocity
        they are the one-sided derivatives for an in-plane velocity along x.

        Parameters
        ----------
        omega : array, shape (...)
            Omega [rad/s].
        velocity : array, shape (..., 3)
            Velocity of the hub through the air [m/s], z along the thrust.
        clamp : bool
            As in ``loads``; outside, the derivatives with respect to the velocity are zero.
        """
        (velocity,) = real_arrays(self.lows.dtype, velocity=(velocity, 3))
        x, y, axial = velocity[..., 0], velocity[..., 1], velocity[..., 2]
        inplane = _length(x, y)
        w, v, b, inside = self._bounded(
            omega, jnp.hypot(inplane, axial), jnp.arctan2(inplane, axial)
        )
        held = jax.lax.stop_gradient((v * jnp.cos(b), v * jnp.sin(b)))
        # Inside, the velocity itself is used, since its polar form has no derivatives at rest.
        axial, inplane = jnp.where(inside, axial, held[0]), jnp.where(inside, inplane, held[1])
        return _finish(_at(self, w, axial, inplane), w, inside | clamp)

    def code(self, omega: Any, speed: Any, beta: Any, thrust: Any) -> Any:
        """Return the index into ``propmap.table.STATUSES``, as in ``LoadTable.loads`` unclamped.

        ``thrust`` is the result of ``loads`` for the same ``omega``, ``speed`` and ``beta``.
        """
        w, v, b, inside = self._bounded(omega, speed, beta)
        i = jnp.searchsorted(self.advance[1:-1], v / (jnp.abs(w) * self.radius), side="right")
        j = jnp.searchsorted(self.beta[1:-1], b, side="right")
        known = jnp.where(jnp.isnan(thrust), NO_VALUE, self.codes[i, j])
        return jnp.where(inside, known, OUTSIDE)

    def _bounded(self, omega: Any, speed: Any, beta: Any) -> tuple[Any, Any, Any, Any]:
        points = {"omega": (omega, 0), "speed": (speed, 0), "beta": (beta, 0)}
        given = jnp.broadcast_arrays(*real_arrays(self.lows.dtype, **points))
        held = [jnp.clip(x, self.lows[k], self.highs[k]) for k, x in enumerate(given)]
        slack = max(SLACK, 4.0 * float(np.finfo(self.lows.dtype).eps))
        near = [
            jnp.abs(x - y) <= slack * jnp.maximum(self.highs[k], -self.lows[k])
            for k, (x, y) in enumerate(zip(given, held, strict=True))
        ]
        return held[0], held[1], held[2], near[0] & near[1] & near[2]


@jax.custom_jvp
def _length(x: Any, y: Any) -> Any:
    return jnp.hypot(x, y)


@_length.defjvp
def _length_jvp(primals: Any, tangents: Any) -> Any:
    x, y = primals
    length = jnp.hypot(x, y)
    moves = length > 0.0
    divisor = jnp.where(moves, length, 1.0)
    along = jnp.where(moves, x / divisor, 1.0) * tangents[0] + y / divisor * tangents[1]
    return length, along


@jax.custom_jvp
def _at(table: JaxTable, omega: Any, axial: Any, inplane: Any) -> Any:
    """Return loads (..., L) for omega, axial and inplane of one shape, inside the envelope."""
    return _expanded(table, omega, axial, inplane)[0]


@_at.defjvp
def _at_jvp(primals: Any, tangents: Any) -> Any:
    value, *slopes = _expanded(*primals)
    pairs = zip(slopes, tangents[1:], strict=True)
    return value, sum(slope * tangent[..., None] for slope, tangent in pairs)


def _expanded(table: JaxTable, omega: Any, axial: Any, inplane: Any) -> tuple[Any, Any, Any, Any]:
    """Return loads (..., L) and derivatives with respect to omega, axial and in-plane velocity."""
    speed = jnp.hypot(axial, inplane)
    tip_speed = jnp.abs(omega) * table.radius
    advance = speed / tip_speed
    beta = jnp.arctan2(inplane, axial)
    i, across = _weights(table.advance, table.advance_weights, advance)
    j, along = _weights(table.beta, table.beta_weights, beta)
    k = jnp.arange(4)
    block = table.padded[(i[..., None] + k)[..., :, None], (j[..., None] + k)[..., None, :]]
    # One einsum for each pair, so that XLA can drop results that are not used.
    pairs = [(across[..., d, :], along[..., e, :]) for d in (0, 1) for e in (0, 1)]
    each = [jnp.einsum("...k,...l,...klc->...c", one, other, block) for one, other in pairs]
    found = jnp.stack(each, axis=-2).reshape(*omega.shape, 2, 2, -1)
    root = jnp.abs(omega) ** -0.5 - jnp.abs(table.lows[0]) ** -0.5
    value, by_omega, by_speed, by_angle = chain_rule(
        found, omega, advance, tip_speed, root, jnp.where
    )
    by_axial, by_inplane = cartesian_slopes(by_speed, by_angle, jnp.cos(beta), jnp.sin(beta))
    return value, by_omega, by_axial, by_inplane


def _weights(knots: Any, polynomials: Any, x: Any) -> tuple[Any, Any]:
    """Return the interval of x, and the weights of its four values and of the slope (..., 2, 4)."""
    i = jnp.searchsorted(knots[1:-1], x, side="right")
    width = (knots[i + 1] - knots[i])[..., None]
    t = (x - knots[i])[..., None] / width
    # Horner's scheme: with products of many small matrices XLA takes ten times as long.
    p = polynomials[i]
    value = p[..., 0] + t * (p[..., 1] + t * (p[..., 2] + t * p[..., 3]))
    slope = (p[..., 1] + t * (2.0 * p[..., 2] + 3.0 * t * p[..., 3])) / width
    return i, jnp.stack([value, slope], axis=-2)


def _finish(values: Any, omega: Any, valid: Any) -> JaxLoads:
    loads = jnp.moveaxis(jnp.where(valid[..., None], values, jnp.nan), -1, 0)
    return JaxLoads(*loads, loads[TORQUE] * omega)
