"""Chord and twist between the measured stations."""

from __future__ import annotations

from typing import Any, NamedTuple

from propmap.arrays.namespace import Array, xp


class Blade(NamedTuple):
    """Geometry of one propeller, a pytree that can be differentiated.

    Attributes
    ----------
    station : Array
        Radii of the measured stations, rising [m], shape (n,).
    chord, twist : Array
        Chord [m] and angle of the chord line to the disk plane [rad] there, shape (n,).
    cubics : Array
        Coefficients of chord and twist between the stations, a row per interval, (n - 1, 10).
    blades : Array
        Number of blades N_b [-].
    root : Array
        Radius at which integration starts [m]: first station or root cut-out.
    chord_scale : Array or None
        Common relative change of the chord [-], ``chord`` and ``cubics`` being those without it;
        None, like 0, for none.
    twist_offset : Array or None
        Common offset of the twist [rad], likewise.
    untwist : Array or None
        What the twist of the tip loses at a tip speed of 100 m/s [rad], see ``BladeUntwist``;
        None, like 0, for a rigid blade.
    """

    station: Array
    chord: Array
    twist: Array
    cubics: Array
    blades: Array
    root: Array
    chord_scale: Array | None = None
    twist_offset: Array | None = None
    untwist: Array | None = None

    @property
    def tip(self) -> Array:
        """Blade radius R [m], the last station."""
        return self.station[-1]


def make_blade(station: Any, chord: Any, twist: Any, blades: Any, root: Any) -> Blade:
    """A ``Blade`` from its measured stations, with the curves between them.

    Parameters
    ----------
    station, chord, twist, blades, root
        As in ``Blade``.
    """
    # One row per interval, so that a radius takes a single gather, which is slow on a CPU.
    h = xp.diff(station)
    rows = [station[:-1], h]
    for y in (chord, twist):
        slope = pchip_slopes(station, y)
        y0, y1, m0, m1 = y[:-1], y[1:], slope[:-1] * h, slope[1:] * h
        rows += [y0, m0, 3.0 * (y1 - y0) - 2.0 * m0 - m1, 2.0 * (y0 - y1) + m0 + m1]
    return Blade(station, chord, twist, xp.stack(rows, axis=1), blades, root)


def with_stations(blade: Blade, count: int) -> Blade:
    """The same ``blade`` with up to ``count`` stations, the tip repeated.

    The curves are the same to the last digit: intervals beyond the tip are copies of the last.
    """
    more = count - blade.station.shape[0]
    if more <= 0:
        return blade

    def longer(values: Array) -> Array:
        return xp.concatenate([values, *[values[-1:]] * more])

    return blade._replace(
        station=longer(blade.station),
        chord=longer(blade.chord),
        twist=longer(blade.twist),
        cubics=longer(blade.cubics),
    )


def pchip_slopes(x: Any, y: Any) -> Any:
    """Derivatives at the knots of the monotone piecewise cubic (PCHIP) through (x, y).

    Written here because chord and twist are differentiated, and because JAX's interpolation
    packages and SciPy each take more than half a second to import.  Values and end slopes are those
    of SciPy's ``PchipInterpolator``, as a test checks.

    Parameters
    ----------
    x, y
        Knots, x rising, shape (n,) with n >= 3.

    References
    ----------
    Fritsch & Butland, SIAM J. Sci. Stat. Comput. 5(2), 1984, doi 10.1137/0905021.
    """
    h = xp.diff(x)
    d = xp.diff(y) / h
    w1, w2 = 2.0 * h[1:] + h[:-1], h[1:] + 2.0 * h[:-1]
    same = d[:-1] * d[1:] > 0.0
    left, right = xp.where(same, d[:-1], 1.0), xp.where(same, d[1:], 1.0)
    inner = xp.where(same, (w1 + w2) / (w1 / left + w2 / right), 0.0)
    first = _end_slope(h[0], h[1], d[0], d[1])
    last = _end_slope(h[-1], h[-2], d[-1], d[-2])
    return xp.concatenate([first[None], inner, last[None]])


def _end_slope(h0: Any, h1: Any, d0: Any, d1: Any) -> Any:
    slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1)
    slope = xp.where(slope * d0 <= 0.0, 0.0, slope)
    return xp.where((d0 * d1 < 0.0) & (xp.abs(slope) > 3.0 * xp.abs(d0)), 3.0 * d0, slope)


def blade_shape(blade: Blade, radius: Array) -> tuple[Array, Array]:
    """Chord [m] and twist at rest [rad] by PCHIP at ``radius`` [m], any shape, inside the measured
    span."""
    k = xp.sum(radius[..., None] >= blade.station[1:-1], axis=-1)
    row = xp.moveaxis(xp.asarray(blade.cubics)[k], -1, 0)
    t = (radius - row[0]) / row[1]
    chord = row[2] + t * (row[3] + t * (row[4] + t * row[5]))
    twist = row[6] + t * (row[7] + t * (row[8] + t * row[9]))
    if blade.chord_scale is not None:
        chord = chord * (1.0 + blade.chord_scale)
    if blade.twist_offset is not None:
        twist = twist + blade.twist_offset
    return chord, twist
