"""The vortex ring: where in descent a measured inflow, based on (12), replaces momentum theory.

The paper uses the static inflow (12) wherever V cos(beta) < 0 < V cos(beta) + v_i.  Then loads
would jump at beta = 90 deg, since in fast forward flight with slight descent the in-plane flow
carries the wake away and (10) still holds.  Here (12) is used only within a region of
V cos(beta)/v_h and V sin(beta)/v_h, and blended with (10) at its edges; v_h is the static inflow at
the same Omega.  The region is that of W. Johnson, "Model for Vortex Ring State Influence on
Rotorcraft Flight Dynamics", NASA/TP-2005-213477, table 4.

Within it the inflow of rotors in vertical descent was measured to be up to twice the static one.
So (12) is multiplied by J. G. Leishman's fit of v_i/v_h (Principles of Helicopter Aerodynamics,
2nd ed., Cambridge 2006, section 2.13), which is 1 in hover.  With (12) alone, thrust in the steep
descents of the NeuroBEM flights is a third too high.
"""

from __future__ import annotations

from propmap.arrays.namespace import Array, custom_jvp, xp

ONSET, FULL_FROM = -0.2, -0.45
"""V cos(beta)/v_h where the vortex ring begins to act (Johnson's point D) and where its
stability boundary is entered in vertical descent (point N)."""

FULL_TO, EXIT = -1.5, -2.0
"""V cos(beta)/v_h where that boundary is left (point X) and where the windmill branch of
momentum theory is joined again (point E)."""

FADE_FROM, NOSE = 0.5, 0.95
"""V sin(beta)/v_h from which (12) is faded out and where the boundary ends (point M)."""

WINDMILL_BELOW = -0.95
"""V cos(beta)/v_h at which the windmill branch takes over from the helicopter branch.

There the vortex ring's inflow has replaced both.  Where that is faded out, V sin(beta) exceeds
|V cos(beta)|/sqrt(8), and the two branches are one."""


@custom_jvp
def _rise(t: Array) -> Array:
    t = xp.clip(t, 0.0, 1.0)
    return t * t * t * (10.0 + t * (6.0 * t - 15.0))


@_rise.defjvp
def _rise_jvp(primals, tangents):  # type: ignore[no-untyped-def]
    (t,), (t_dot,) = primals, tangents
    within = xp.clip(t, 0.0, 1.0)
    slope = within * (1.0 - within)
    return _rise(t), 30.0 * slope * slope * t_dot


def vortex_ring_weight(v_axial: Array, v_inplane: Array, v_hover: Array) -> Array:
    """Share of ``vortex_ring_inflow`` in the inflow used [-], twice differentiable.

    It is zero outside the vortex ring's region.  ``v_axial``, ``v_inplane`` and ``v_hover`` [m/s]
    are of one shape.
    """
    v_h = xp.maximum(v_hover, 1e-9)
    z, x = v_axial / v_h, v_inplane / v_h
    entered = _rise((ONSET - z) / (ONSET - FULL_FROM))
    not_left = _rise((z - EXIT) / (FULL_TO - EXIT))
    not_swept = 1.0 - _rise((x - FADE_FROM) / (NOSE - FADE_FROM))
    return entered * not_left * not_swept


_MEASURED = (-1.125, -1.372, -1.718, -0.655)
"""v_i/v_h - 1 in vertical descent, in powers of V cos(beta)/v_h from the first to the fourth."""


def vortex_ring_inflow(v_axial: Array, v_hover: Array) -> Array:
    """Inflow [m/s] in the vortex ring, (12) times Leishman's fit; shape of v_axial.

    The fit holds for -2 <= V cos(beta)/v_h <= 0.  Outside, where ``vortex_ring_weight`` is zero, it
    keeps its end values.

    Parameters
    ----------
    v_axial, v_hover : Array
        V cos(beta), and static inflow (12) [m/s].
    """
    z = xp.clip(v_axial / xp.maximum(v_hover, 1e-9), EXIT, 0.0)
    k1, k2, k3, k4 = _MEASURED
    return v_hover * (1.0 + z * (k1 + z * (k2 + z * (k3 + z * k4))))


def on_windmill_branch(v_axial: Array, v_hover: Array) -> Array:
    """1.0 in descent faster than ``WINDMILL_BELOW``, else 0.0; shape of v_axial."""
    return xp.where(v_axial < xp.minimum(WINDMILL_BELOW * v_hover, 0.0), 1.0, 0.0)


def blend_vortex_ring(
    v_axial: Array, v_inplane: Array, v_hover: Array, inflow: Array
) -> tuple[Array, Array]:
    """A mean of the root of (11) and the vortex ring's inflow, and the share of the latter [-].

    Parameters
    ----------
    v_axial, v_inplane : Array
        V cos(beta) and V sin(beta) [m/s], (B,).
    v_hover : Array
        Static inflow (12) [m/s], (B,).
    inflow : Array
        The root of (11) [m/s], (S, B).

    Returns
    -------
    tuple of Array
        Inflow [m/s], (S, B), and share [-], (B,).
    """
    ring = vortex_ring_weight(v_axial, v_inplane, v_hover)
    return (1.0 - ring) * inflow + ring * vortex_ring_inflow(v_axial, v_hover), ring
