"""A slow, literal reference for the loads of one rotor, independent of the package.

Written from the printed equations of R. Gill and R. D'Andrea, "Propeller Thrust and Drag in
Forward Flight", IEEE CCTA 2017 (equation numbers below are the paper's), with NumPy and SciPy
alone: explicit angles, a scan for every root of the hybrid inflow equation (11), and radial
panels split where the inflow jumps. Nothing is clever where plain would do, since its worth
is that it shares no code and no method with what it checks. Descent, losses at tip and hub and
tabulated sections are extensions of the paper's own rotor. SI units and radians throughout.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq, minimize_scalar

from tests.oracle.literal_section import (
    Array,
    Section,
    coefficients,
    drag_coefficient,
    largest_lift,
    lift_coefficient,
    stall_blend,
    wrap,
)
from tests.oracle.literal_wake import WINDMILL_BELOW, LiteralWake, static_inflow, vortex_ring

SCAN_STEP = 0.004  # [rad] of inflow angle; the stall blend is about 1/M = 0.02 rad wide
SCAN_AZIMUTHS = 120  # the scan only brackets roots; they are refined with all azimuth nodes
DETECTION_STATIONS = 60
LOWEST = 1.0  # [rad] of inflow angle from below, where nothing above serves
STEEPEST = 1.5  # [rad] of inflow angle, where no better bound on the inflow is known
JUMP_WIDTH = 1e-7  # [m] to which the radius of a jump is bisected
STEEP_WIDTH = 3e-4  # [m] over which 0.002 rad of inflow angle count as a near-vertical rise
PANEL_ANGLE = 0.03  # [rad] largest change of inflow angle across one radial panel


@dataclass(frozen=True)
class LiteralRotor:
    """One rotor at one operating point; `n_azimuth` equally spaced nodes on [0, 2 pi)."""

    station: Array  # [m]
    chord: Array  # [m]
    twist: Array  # [rad]
    blades: int
    section: Section
    wake: LiteralWake
    ring: tuple[float, float]  # share [-] and size [m/s] of the vortex ring's inflow
    rho: float  # [kg/m^3]
    mu: float  # [Pa s]
    omega: float  # [rad/s]
    v_axial: float  # [m/s], V cos(beta)
    v_inplane: float  # [m/s], V sin(beta)
    zero_lift_angle: float  # [rad], taken off alpha before the section law sees it
    n_azimuth: int
    scan_step: float

    @cached_property
    def shape(self) -> tuple[PchipInterpolator, PchipInterpolator]:
        """Chord [m] and twist [rad] as functions of the radius [m]."""
        chord = PchipInterpolator(self.station, self.chord)
        return chord, PchipInterpolator(self.station, self.twist)

    @cached_property
    def sharper(self) -> float:
        """How much sharper the section stalls than the paper's, 1 at least."""
        return sharper_stall(self.section)

    @cached_property
    def azimuth(self) -> tuple[Array, Array]:
        """Angles [rad] and weights of the nodes that make the loads."""
        return _azimuth_nodes(self.n_azimuth)

    @cached_property
    def scan_azimuth(self) -> tuple[Array, Array]:
        """Angles [rad] and weights of the nodes that bracket the roots."""
        return _azimuth_nodes(min(self.n_azimuth, SCAN_AZIMUTHS))

    @cached_property
    def largest_lift_coefficient(self) -> float:
        """Largest absolute C_L at any angle of attack."""
        return largest_lift(self.section)

    def element(self, y: float, v_i: Array, psi: Array) -> tuple[Array, Array, Array]:
        """phi [rad], dL/dy and dD/dy of one blade [N/m] at radius y [m], shape (v_i, psi)."""
        c, theta = (float(f(y)) for f in self.shape)
        u_t = self.omega * y + self.v_inplane * np.sin(psi)[None, :]  # Eq. (1)
        u_p = self.v_axial + np.asarray(v_i)[:, None]  # Eq. (2)
        u_squared = u_t**2 + u_p**2
        phi = np.arctan2(u_p, u_t)
        from_nominal = theta - phi - self.zero_lift_angle
        alpha = wrap(from_nominal - self.reynolds_camber(y, c))
        reynolds = self.rho * np.sqrt(u_squared) * c / self.mu
        pressure = 0.5 * self.rho * u_squared * c
        if isinstance(self.section, dict):
            ratio, own = self.reynolds_ratio(y, c), self.section
            slope = own.get("c_l1", 0.0) * ratio ** own.get("reynolds_lift", 0.0)
            c_lift = lift_coefficient(alpha, {**own, "c_l1": slope})
            attached = 1.0 - stall_blend(alpha, own.get("alpha_0", 0.0), own.get("M", 50.0))
            attached = attached * own.get("attached", 1.0)
            growth = 1.0 + attached * (ratio ** own.get("reynolds_drag", 0.0) - 1.0)
            least = wrap(from_nominal - own.get("drag_angle", 0.0))
            c_drag = drag_coefficient(least, reynolds, own, growth)
        else:
            c_lift, c_drag = coefficients(alpha, reynolds, self.section)
        return phi, pressure * c_lift, pressure * c_drag

    def reynolds_camber(self, y: float, c: float) -> float:
        """How much larger the zero-lift angle [rad] is at y [m] and chord c [m] than at Re 5e4."""
        if not isinstance(self.section, dict):
            return 0.0
        return self.section.get("reynolds_camber", 0.0) * float(np.log(self.reynolds_ratio(y, c)))

    def reynolds_ratio(self, y: float, c: float) -> float:
        """Reynolds number of the rotation at y [m] and chord c [m], limited, over 5e4."""
        return min(max(self.rho * self.omega * y * c / self.mu, 1e4), 1.2e5) / 5e4

    def blade_thrust(self, y: float, v_i: Array, azimuth: tuple[Array, Array]) -> Array:
        """dT/dy [N/m] by eq. (5) for each v_i [m/s]."""
        psi, weight = azimuth
        phi, lift, drag = self.element(y, v_i, psi)
        return self.blades * ((lift * np.cos(phi) - drag * np.sin(phi)) @ weight)

    def residual(self, y: float, v_i: Array, azimuth: tuple[Array, Array]) -> Array:
        """Eq. (5) minus eq. (10) [N/m]; its roots in v_i solve eq. (11)."""
        return self.blade_thrust(y, v_i, azimuth) - self.wake.thrust(y, v_i)

    def inflow_angle(self, y: float, v_i: float) -> float:
        """Inflow angle [rad] met by the element without the in-plane velocity."""
        return float(np.arctan2(self.v_axial + v_i, self.omega * y))

    def scan_grid(self, y: float) -> Array:
        """Every v_i [m/s] that can be the largest root, in steps of inflow angle.

        In climb those with U_P >= 0; in descent also those below, in which air comes from below.
        """
        # With U_P >= 0 section drag never adds thrust, so (5) <= N_b/2 rho c C_L,max U^2, while
        # (10) >= 4 rho pi y F w^2, F being the least loss and w = v_i in climb, w = U_P in
        # descent; put together they bound w from above.
        chord = float(self.shape[0](y))
        s = self.blades * chord * self.largest_lift_coefficient / (8.0 * np.pi * y)
        least_loss = self.wake.least_loss(y)
        climb = max(self.v_axial, 0.0)
        largest_angle = STEEPEST
        if s < 0.9 * least_loss:
            s = np.sqrt(s / least_loss)
            highest = s / (1.0 - s) * (self.omega * y + self.v_inplane + climb)
            largest_angle = min(np.arctan2(climb + highest, self.omega * y), STEEPEST)
        count = int(np.ceil(largest_angle / self.scan_step)) + 2
        grid = self.omega * y * np.tan(np.linspace(0.0, largest_angle, count)) - self.v_axial
        if self.v_axial < 0.0:
            lowest = 1.1 * self.v_axial - 0.1 * self.omega * y
            angle = np.arctan2(lowest, self.omega * y)
            below = np.linspace(angle, 0.0, int(np.ceil(-angle / self.scan_step)) + 2)
            below = self.omega * y * np.tan(below) - self.v_axial
            evenly = np.linspace(lowest, 0.0, 200) - self.v_axial
            grid = np.unique(np.concatenate([below, evenly, grid]))
        return grid

    def inflow_root(self, y: float) -> tuple[float, int]:
        """Largest root v_i [m/s] of eq. (11) at radius y [m], and the number of roots."""
        grid = self.scan_grid(y)
        g = self.residual(y, grid, self.scan_azimuth)
        inner = g[1:-1]
        peak = (inner < 0.0) & (inner >= g[:-2]) & (inner >= g[2:])
        dip = (inner > 0.0) & (inner <= g[:-2]) & (inner <= g[2:])
        for k in np.flatnonzero(peak | dip) + 1:
            # A close pair of roots may hide between grid points: look at the extremum itself.
            sign = np.sign(g[k])
            found = minimize_scalar(
                lambda v, s=sign: s * self.residual(y, np.array([v]), self.scan_azimuth)[0],
                bounds=(grid[k - 1], grid[k + 1]),
                method="bounded",
                options={"xatol": 1e-9},
            )
            if found.fun < 0.0:
                grid, g = np.append(grid, found.x), np.append(g, sign * found.fun)
        order = np.argsort(grid)
        grid, g = grid[order], g[order]
        crossings = np.flatnonzero((g[:-1] > 0.0) != (g[1:] > 0.0))
        if crossings.size == 0:
            # The annulus pushes: what it needs is air that comes from below.
            angle = np.linspace(-LOWEST, 0.0, int(np.ceil(LOWEST / self.scan_step)))
            grid = self.omega * y * np.tan(angle) - self.v_axial
            g = self.residual(y, grid, self.scan_azimuth)
            crossings = np.flatnonzero((g[:-1] > 0.0) != (g[1:] > 0.0))
        if crossings.size == 0:
            raise ValueError(f"eq. (11) has no root among those looked for at y = {y} m")
        if g[-1] > 0.0:
            raise ValueError(f"at y = {y} m the blade prevails up to the largest inflow looked at")
        last = int(crossings[-1])
        return self._refine(y, float(grid[last]), float(grid[last + 1])), int(crossings.size)

    def _refine(self, y: float, low: float, high: float) -> float:
        def g(v: float) -> float:
            return float(self.residual(y, np.array([v]), self.azimuth)[0])

        # The scan may have used fewer azimuths: widen the bracket until it holds for all.
        width = max(high - low, 1e-9)
        for _ in range(8):
            if g(low) > 0.0 >= g(high):
                return float(brentq(g, low, high, xtol=1e-12, rtol=1e-13))
            low, high, width = low - width, high + width, 2.0 * width
        raise ValueError(f"the bracket of the scan does not hold at y = {y} m")

    def load_densities(self, y: float) -> Array:
        """Thrust, drag, torque, rolling moment per unit span [N/m, N/m, N, N] at y [m]."""
        share, measured = self.ring
        v_i = measured
        if share < 1.0:
            v_i = (1.0 - share) * self.inflow_root(y)[0] + share * measured
        psi, weight = self.azimuth
        phi, lift, drag = (a[0] for a in self.element(y, np.array([v_i]), psi))
        along_axis = lift * np.cos(phi) - drag * np.sin(phi)
        in_plane = lift * np.sin(phi) + drag * np.cos(phi)
        rows = [
            along_axis,  # Eq. (5)
            in_plane * np.sin(psi),  # Eq. (6)
            y * in_plane,  # Eq. (7)
            y * np.sin(psi) * along_axis,  # not in the paper
        ]
        return self.blades * np.array([row @ weight for row in rows])


def _azimuth_nodes(count: int) -> tuple[Array, Array]:
    """Angles [rad] and weights (sum 1) of `count` equally spaced azimuths, count even or 1.

    Every integrand depends on psi through sin(psi) alone, so psi and pi - psi give the same
    number; it is worked out once and counted twice.
    """
    if count == 1:
        return np.zeros(1), np.ones(1)
    psi = np.linspace(-0.5 * np.pi, 0.5 * np.pi, count // 2 + 1)
    weight = np.full(psi.size, 2.0 / count)
    weight[[0, -1]] = 1.0 / count  # -pi/2 and pi/2 have no twin
    return psi, weight


def find_breaks(rotor: LiteralRotor, low: float, high: float) -> tuple[Array, Array]:
    """Radii [m] where the largest root jumps or rises steeply, and the curve followed.

    The curve is every radius [m] looked at with its inflow angle [rad], shape (:, 2).
    """

    def angle(y: float) -> float:
        return rotor.inflow_angle(y, rotor.inflow_root(y)[0])

    radii = np.linspace(low, high, DETECTION_STATIONS)
    angles = np.array([angle(y) for y in radii])
    seen = list(zip(radii, angles, strict=True))
    breaks: list[float] = []
    for a, b, at_a, at_b in zip(radii[:-1], radii[1:], angles[:-1], angles[1:], strict=True):
        while b - a > JUMP_WIDTH and abs(at_b - at_a) > 0.002:
            middle = 0.5 * (a + b)
            at_middle = angle(middle)
            seen.append((middle, at_middle))
            # Follow the half with the larger change: a jump stays in it at full height.
            if abs(at_middle - at_a) >= abs(at_b - at_middle):
                b, at_b = middle, at_middle
            else:
                a, at_a = middle, at_middle
        # Narrow without a jump is one about to be born: a cube root, continuous.
        if abs(at_b - at_a) > 0.002 or b - a < STEEP_WIDTH:
            breaks.append(0.5 * (a + b))
    return np.array(breaks), np.array(sorted(seen))


def radial_nodes(rotor: LiteralRotor, low: float, high: float) -> tuple[Array, Array]:
    """Radii [m] and weights [m] of the composite Gauss-Legendre rule."""
    breaks, seen = find_breaks(rotor, low, high)
    # Chord and twist are cubic between stations, so panels end there; but not right beside a
    # break, where a panel has to hold the whole neighborhood of the root-like rise.
    ends = [y for y in rotor.station if low < y < high and np.all(np.abs(y - breaks) > 1e-3)]
    edges = np.unique(np.concatenate([[low], ends, breaks, [high]]))
    breaks = np.append(breaks, high)  # the chord falls to nothing at the tip
    nodes, weights = [], []
    for a, b in pairwise(edges):
        inside = seen[(seen[:, 0] > a) & (seen[:, 0] < b), 1]
        change = np.ptp(inside) if inside.size else 0.0
        pieces = max(1, int(np.ceil(change * rotor.sharper / PANEL_ANGLE)))
        clustered = bool(np.any((a == breaks) | (b == breaks)))
        x, w = np.polynomial.legendre.leggauss(4)
        cuts = np.linspace(0.0, 1.0, (4 if clustered else 1) * pieces + 1)
        half = 0.5 * np.diff(cuts)[:, None]
        t = (0.5 * (cuts[:-1] + cuts[1:])[:, None] + half * x).ravel()
        w = (half * w).ravel()
        if clustered:  # t^2 (3 - 2 t) turns a square root at either end into a smooth function
            t, w = t**2 * (3.0 - 2.0 * t), w * 6.0 * t * (1.0 - t)
        nodes.append(a + (b - a) * t)
        weights.append((b - a) * w)
    return np.concatenate(nodes), np.concatenate(weights)


def sharper_stall(section: Section) -> float:
    """M of the section over the paper's 50, 1 at least; 1 for a table."""
    return max(1.0, section.get("M", 50.0) / 50.0) if isinstance(section, dict) else 1.0


def azimuth_count(omega: float, radius: float, v_inplane: float, sharper: float = 1.0) -> int:
    """How many azimuth nodes make the loads converge (even, or 1 in axial flow)."""
    if v_inplane == 0.0:
        return 1
    count = 128 if v_inplane < 0.25 * omega * radius else 360
    return 2 * int(np.ceil(0.5 * count * sharper))


def literal_rotor(
    station: ArrayLike,
    chord: ArrayLike,
    twist: ArrayLike,
    blades: int,
    section: Section,
    rho: float,
    mu: float,
    omega: float,
    v_axial: float,
    v_inplane: float,
    zero_lift_angle: float = 0.0,
    *,
    tip_loss: bool = False,
    hub_radius: float | None = None,
    v_hover: float | None = None,
) -> LiteralRotor:
    """A rotor at one operating point.

    `station`, `chord` [m] and `twist` [rad] run from the first measured station to the tip.
    `section` holds c_l1, c_l2, c_d, alpha_0 [rad] and, if they differ from the paper's, M, c_p,
    c_d0, or is a table. `rho` [kg/m^3], `mu` [Pa s], `omega` [rad/s], `v_axial` and `v_inplane` >=
    0 [m/s]. `tip_loss` and `hub_radius` [m] ask for Prandtl's losses. `v_hover` [m/s] is the static
    inflow (12) at this omega, in descent; by default of the hover computed here.
    """
    y, c, theta = (np.asarray(a, dtype=float) for a in (station, chord, twist))
    losses = {"tip_loss": tip_loss, "hub_radius": hub_radius}
    windmill, ring = False, (0.0, 0.0)
    if v_axial < 0.0:
        if v_hover is None:
            still = (y, c, theta, blades, section, rho, mu, omega, 0.0, 0.0, zero_lift_angle)
            hover = literal_loads(*still, **losses)
            v_hover = static_inflow(hover["thrust"], rho, float(y[-1]))
        windmill = v_axial < WINDMILL_BELOW * v_hover
        ring = vortex_ring(v_axial, v_inplane, v_hover)
    motion = (omega, v_axial, v_inplane)
    wake = LiteralWake(rho, *motion, blades, float(y[-1]), **losses, windmill=windmill)
    count = azimuth_count(omega, float(y[-1]), v_inplane, sharper_stall(section))
    numbers = (rho, mu, *motion, zero_lift_angle, count, SCAN_STEP)
    return LiteralRotor(y, c, theta, blades, section, wake, ring, *numbers)


def literal_loads(*rotor: Any, **options: Any) -> dict[str, float]:
    """Loads of a `literal_rotor` by eqs (1)-(15), the largest root of (11) taken at every radius.

    Returns thrust [N], drag [N], torque [N m] and roll_moment [N m].
    """
    one = literal_rotor(*rotor, **options)
    nodes, weights = radial_nodes(one, float(one.station[0]), float(one.station[-1]))
    totals = weights @ np.array([one.load_densities(r) for r in nodes])  # Eqs (13)-(15)
    names = ("thrust", "drag", "torque", "roll_moment")
    return dict(zip(names, map(float, totals), strict=True))
