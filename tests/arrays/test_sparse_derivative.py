"""Derivatives that know what does not depend on a number."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np

from propmap.arrays.sparse_derivative import derivative

VALUES = jnp.array([0.5, 2.0])


def test_what_depends_has_its_derivative_and_the_rest_none() -> None:
    def parts(x: Any) -> dict[str, Any]:
        grown = VALUES * (1.0 + x)
        return {"grown": grown, "square": grown * grown, "same": 3.0 * VALUES, "absent": None}

    found = derivative(parts)
    assert found["same"] is None and found["absent"] is None
    np.testing.assert_allclose(found["grown"], VALUES, rtol=1e-6)
    np.testing.assert_allclose(found["square"], 2.0 * VALUES * VALUES, rtol=1e-6)


def test_nothing_depends() -> None:
    assert derivative(lambda x: (VALUES, 2.0)) == (None, None)  # noqa: ARG005


def test_dependence_through_a_comparison_is_counted() -> None:
    """Its derivative is zero, but not known to be before it is computed."""
    found = derivative(lambda x: jnp.where(x > VALUES, 1.0, 0.0))
    np.testing.assert_array_equal(found, [0.0, 0.0])
