"""The bounds that the search relies on hold, and are close enough that a smaller one would not.

Each check compares a bound with the sampled maximum of what it bounds, or the walk with a scan for
every root.  ``test_mutants_of_bounds.py`` shows that each check notices a bound that is too small.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from propmap.arrays.namespace import by_numpy
from propmap.physics import element
from propmap.physics.element import Annulus, Station
from propmap.physics.sections.blended import BlendedLaw
from propmap.physics.sections.law import Coefficients, LawBounds, SectionFlow
from propmap.physics.tip_loss import PrandtlLoss
from propmap.physics.velocities import azimuth_nodes
from propmap.physics.wake import Wake
from propmap.solve import bounds, root
from propmap.solve.problem import AnnulusProblem, residual, residual_slope

AXIAL = azimuth_nodes(1)


class WavyLaw(NamedTuple):
    """Lift that rises and falls all over, as steeply bent as its bounds say: the worst of laws."""

    slope: Any
    size: Any
    waves: Any
    phase: Any
    zero_lift_angle: float = 0.0
    drag_factor: float = 1.0

    def coefficients(self, flow: SectionFlow) -> Coefficients:
        at = self.waves * flow.angle + self.phase
        lift = self.slope * flow.sine * flow.cosine + self.size * np.sin(at)
        by_angle = self.slope * (flow.cosine**2 - flow.sine**2)
        by_angle = by_angle + self.size * self.waves * np.cos(at)
        drag = 0.02 + 0.0 * lift
        return Coefficients(lift, drag, by_angle, 0.0 * lift, 0.0, 0.0)

    def bounds(self) -> LawBounds:
        bend = 2.0 * self.slope + self.size * self.waves**2
        none = np.zeros_like(self.slope)
        return LawBounds(
            lift=0.5 * self.slope + self.size,
            lift_bend=bend,
            foot_bend=bend,
            attached_bend=bend,
            drag_bend=0.06 + none,
            friction=0.0,
            attached_from=none,
            attached_to=none,
            attached_slope=none,
            least_stall_angle=none,
            stall_width=none,
        )


def wavy(random: np.random.Generator, count: int) -> WavyLaw:
    return WavyLaw(
        random.uniform(1.0, 4.0, count),
        10.0 ** random.uniform(-2.0, 0.0, count),
        random.uniform(3.0, 60.0, count),
        random.uniform(0.0, 2.0 * np.pi, count),
    )


def blended(random: np.random.Generator, count: int) -> BlendedLaw:
    def drawn(low: float, high: float) -> Any:
        return random.uniform(low, high, count)

    rest: Any = (drawn(-0.1, 0.05), drawn(0.0, 0.1), drawn(0.0, 2.0), drawn(20.0, 150.0))
    return BlendedLaw(
        drawn(2.0, 8.0), drawn(0.0, 4.0), drawn(0.0, 3.0), drawn(0.1, 0.9), *rest, np.ones(count)
    )


def annuli(random: np.random.Generator, law: Any, count: int, descent: bool) -> Annulus:
    """Annuli (1, B) of all kinds of blades and flows."""
    radius = random.uniform(0.02, 0.099, (1, count))
    chord = radius * random.uniform(0.05, 0.6, (1, count))
    pitch = random.uniform(-0.1, 0.8, (1, count))
    per_speed = 6e4 * chord
    station = Station(radius, chord, np.sin(pitch), np.cos(pitch), per_speed, per_speed**-0.5)
    omega, across = random.uniform(100.0, 900.0, count), random.uniform(0.0, 8.0, count)
    along = random.uniform(-15.0 if descent else 0.0, 0.0 if descent else 12.0, count)
    across[::3], along[1::3] = 0.0, 0.0 if not descent else along[1::3]
    ends: Any = (np.float64(2.0), np.float64(0.02), np.float64(0.1))
    return Annulus(station, omega, along, across, *ends, law)


def largest_by_scan(problem: AnnulusProblem, azimuth: Any, grid: Any) -> Any:
    """The lower end of the highest interval of ``grid`` (G, 1, B) in which (11) turns negative."""
    values = np.stack([residual(problem, v, azimuth)[0] for v in grid])
    falls = (values[:-1] > 0.0) & (values[1:] <= 0.0)
    last = falls.shape[0] - 1 - np.argmax(falls[::-1], axis=0)
    lower = np.take_along_axis(grid[:, 0], last[None], axis=0)[0]
    return np.where(falls.any(axis=0), lower, -np.inf), values


def the_walk_passes_no_root(azimuths: int = 1) -> None:
    """Against a scan, for laws with up to some dozens of roots."""
    random, count = np.random.default_rng(1952), 1500
    with by_numpy():
        at = annuli(random, wavy(random, count), count, descent=False)
        problem, azimuth = AnnulusProblem(at, Wake(None)), azimuth_nodes(azimuths)
        ended = root.search(problem, np.array(root.MAX_STEPS), azimuth)
        start = bounds.find_bounds(at, Wake(None)).start
        top = 1.3 * start[0] + 1.0
        grid = -at.v_axial + (top + at.v_axial) * np.linspace(0.0, 1.0, 1201)[:, None]
        lower, values = largest_by_scan(problem, azimuth, grid[:, None])
    assert (values[-1] < 0.0).all()
    found = ended.found[0]
    assert found.mean() > 0.98
    passed = found & (ended.inflow[0] < lower - 1e-9)
    assert not passed.any(), f"{passed.sum()} of {count} walks passed a root"


def newton_steps_meet_the_theorem() -> None:
    """Where the walk steps further than is safe, there is one root about the step: by the theorem
    of Newton and Kantorovich, if the slope changes by less than its half along the step."""
    random, count = np.random.default_rng(1948), 40000
    with by_numpy():
        # Of this law no element counts as far from stall, where (11) bends one way only.
        at = annuli(random, wavy(random, count), count, descent=False)
        problem = AnnulusProblem(at, Wake(None))
        bound = bounds.find_bounds(at, problem.wake)
        v = at.turning * np.tan(random.uniform(0.02, 0.9, count)) - at.v_axial
        value, slope = residual_slope(problem, v, AXIAL)
        nowhere = np.full_like(v, np.inf)
        before = root._Evaluated(nowhere, nowhere, nowhere)
        walk = root._Walk(v, np.full_like(v, root.NEWTON_STEPS), before)
        there = root._step(problem, bound, walk, np.array(1), value, slope)
        safe, step = bounds.safe_step(at, problem.wake, bound, v, value, slope), v - there.v
        bold = (value < 0.0) & (step > safe * (1.0 + 1e-9))
        bold = bold & (v - step + at.v_axial > 0.0)  # there is a kink in axial flow
        slopes = [
            residual_slope(problem, v - share * step, AXIAL)[1]
            for share in np.linspace(0.0, 1.0, 61)
        ]
        change = np.abs(np.stack(slopes) - slope).max(axis=0) / np.abs(slope)
    assert bold.sum() > 500
    assert change[bold].max() < 0.5
    assert change[bold].max() > 0.1


def no_root_lies_above_the_start() -> None:
    random, count = np.random.default_rng(1686), 4000
    for make in (wavy, blended):
        for descent in (False, True):
            with by_numpy():
                at = annuli(random, make(random, count), count, descent)
                problem = AnnulusProblem(at, Wake(None))
                start = bounds.find_bounds(at, problem.wake).start
                for share in np.linspace(0.0, 1.0, 60) ** 2:
                    v = start + share * (start + at.turning)
                    value = residual(problem, v, AXIAL)
                    assert (value <= 1e-9 * np.abs(value).max()).all()


def the_blade_bends_by_no_more(least_ratio: float = 0.3) -> None:
    """d^2/dv_i^2 of the blade elements' thrust, against N_b c/2 times the law's bounds."""
    random, count, worst = np.random.default_rng(1918), 20000, 0.0
    for make in (wavy, blended):
        with by_numpy():
            law = make(random, count)
            at = annuli(random, law, count, descent=False)
            bound = bounds.find_bounds(at, Wake(None))
            u = at.turning * np.tan(random.uniform(-0.2, 1.2, count))
            v, h = u - at.v_axial, 1e-5 * at.turning
            # One azimuth of a turn: the bound holds for each.
            up, down = (
                element.element_forces(at, v + d, np.float64(0.0)).normal_slope for d in (h, -h)
            )
            bend = 2.0 * (up - down) / (2.0 * h)
            friction = 2.0 * bound.friction * np.sqrt(bound.speed) / bound.speed
            most = friction + bound.half * bounds._blade_bend(bound.law, bound.law.lift_bend)
        ratio = bend / most
        assert ratio.max() <= 1.0
        worst = max(worst, float(ratio.max()))
    assert worst > least_ratio  # no mutant of a quarter survives


def the_wake_bends_by_no_more() -> None:
    """-d^2/dv_i^2 of the wake's thrust over an interval, against the bound for it."""
    random, count = np.random.default_rng(1935), 3000
    factors = (PrandtlLoss(), PrandtlLoss(np.float64(0.0199)))  # type: ignore[arg-type]
    for windmill in (None, np.ones(count)):
        for some in ((), factors[:1], factors[1:], factors):
            with by_numpy():
                descent = windmill is not None
                at = annuli(random, wavy(random, count), count, descent)
                wake = Wake(windmill, some)
                # On one side of U_P = 0, as the walk asks.
                side = np.where(random.random(count) < 0.5, 1.0, -1.0) if descent else 1.0
                ends = 10.0 ** random.uniform(-2.0, 1.0, (2, count))
                u = np.sort(side * ends, axis=0)
                low, high = (one[None] - at.v_axial for one in u)
                most = wake.largest_bend(at, low, high)
                h = 1e-5 * (high - low)
                sampled = []
                for share in np.linspace(0.01, 0.99, 50):
                    v = low + share * (high - low)
                    up, down = (wake.thrust_slope(at, v + d)[1] for d in (h, -h))
                    sampled.append(-(up - down) / (2.0 * h))
            ratio = np.stack(sampled) / np.maximum(most, 1e-12)
            # Differences over 1e-5 of the interval have rounding of 1e-16 / 1e-10.
            noise = 1e-5 * 4.0 * np.pi * at.radius / np.maximum(most, 1e-12)
            assert (ratio <= 1.0 + 1e-3 + noise).all(), f"{some} {descent} {ratio.max()}"
            # ``descent`` alone: in climb (10) bends upwards only, and the bound is zero.
            assert ratio.max() > 0.55 or not descent


def nearly_axial(at: Annulus, random: np.random.Generator) -> Annulus:
    """The annuli at in-plane velocities from 1e-12 to 1e-4 of their speed."""
    share = 10.0 ** random.uniform(-12.0, -4.0, at.omega.size)
    return at._replace(v_inplane=share * (at.turning[0] + np.abs(at.v_axial)))


def the_wake_bends_by_no_more_in_nearly_axial_flow() -> None:
    """The same where V sin(beta) is tiny, and the bend of (10) about U_P = 0 as narrow."""
    random, count = np.random.default_rng(1926), 3000
    largest = []
    for descent in (False, True):
        for windmill in (None, np.zeros(count), np.ones(count))[: 3 if descent else 2]:
            with by_numpy():
                at = nearly_axial(annuli(random, wavy(random, count), count, descent), random)
                wake, p = Wake(windmill), at.v_inplane
                # On one side of U_P = 0, from a tenth to a million of V sin(beta).
                side = np.where(random.random(count) < 0.5, 1.0, -1.0)
                u = np.sort(side * p * 10.0 ** random.uniform(-1.0, 6.0, (2, count)), axis=0)
                low, high = (one[None] - at.v_axial for one in u)
                most = wake.largest_bend(at, low, high)
                sampled = []
                for share in np.linspace(0.0, 1.0, 50) ** 4:
                    for one in (u[1] + share * (u[0] - u[1]), u[0] + share * (u[1] - u[0])):
                        v, h = one[None] - at.v_axial, 1e-3 * np.abs(one)
                        up, down = (wake.thrust_slope(at, v + d)[1] for d in (h, -h))
                        sampled.append(-(up - down) / (2.0 * h))
                # Below that, differences are lost in the rounding of v_i.
                known = p > 1e-7 * (1.0 + np.abs(at.v_axial))
            bend = np.stack(sampled)[:, 0, known]
            most = most[0, known]
            assert known.sum() > 500
            assert (bend <= 1.01 * most + 1e-2).all()
            largest.append((bend / np.maximum(most, 0.1)).max())
    assert max(largest) > 0.55


def the_wake_is_close_to_that_of_axial_flow() -> None:
    """``above_axial`` by the difference, and no more below anywhere than ``most_below_axial``."""
    random, count = np.random.default_rng(1865), 3000
    for some in ((), (PrandtlLoss(),)):
        with by_numpy():
            at = annuli(random, wavy(random, count), count, descent=False)
            at = at._replace(v_inplane=10.0 ** random.uniform(-6.0, 0.0, count))
            axial, wake = at._replace(v_inplane=0.0 * at.v_inplane), Wake(None, some)
            u = random.choice([-1.0, 1.0], count) * 10.0 ** random.uniform(-5.0, 1.0, count)
            v = u[None] - at.v_axial
            thrust, slope = wake.thrust_slope(at, v)
            without, slope_without = wake.thrust_slope(axial, v)
            above, above_slope = wake.above_axial(at, v)
            low = v - random.uniform(0.0, 5.0, count)
            most = wake.most_below_axial(at, low)
            np.testing.assert_allclose(above, thrust - without, atol=1e-9)
            np.testing.assert_allclose(above_slope, slope - slope_without, atol=1e-6)
            below = [
                wake.thrust_slope(axial, x)[0] - wake.thrust_slope(at, x)[0]
                for x in (low + share * (v - low) for share in np.linspace(0.0, 1.0, 200))
            ] + [wake.thrust_slope(axial, -at.v_axial)[0] - wake.thrust_slope(at, -at.v_axial)[0]]
        inside = (low < -at.v_axial) & (v > -at.v_axial)
        below[-1] = np.where(inside, below[-1], -np.inf)
        assert (np.stack(below) <= most + 1e-9).all()
        assert (np.stack(below).max(axis=0) > 0.5 * most)[most > 1e-6].any()


def the_walk_passes_no_root_in_nearly_axial_climb() -> None:
    """Against a scan on either side of U_P = 0, and not lost there in tiny steps."""
    random, count = np.random.default_rng(1889), 1500
    with by_numpy():
        at = annuli(random, wavy(random, count), count, descent=False)
        at = nearly_axial(at, random)
        problem = AnnulusProblem(at, Wake(None))
        ended = root.search(problem, np.array(root.MAX_STEPS), AXIAL)
        top = 1.3 * bounds.find_bounds(at, Wake(None)).start[0] + 1.0
        share = np.linspace(-0.5, 1.0, 1801)[:, None]
        grid = -at.v_axial + (top + at.v_axial) * share
        lower, values = largest_by_scan(problem, AXIAL, grid[:, None])
    assert (values[-1] < 0.0).all()
    found = ended.found[0]
    assert found.mean() > 0.98
    assert ((ended.inflow[0] < -at.v_axial) & found).sum() > 50
    passed = found & (ended.inflow[0] < lower - 1e-9)
    assert not passed.any(), f"{passed.sum()} of {count} walks passed a root"


def prandtls_factor_keeps_within_its_bounds() -> None:
    random, count = np.random.default_rng(1919), 3000
    for factor in (PrandtlLoss(), PrandtlLoss(np.float64(0.0199))):  # type: ignore[arg-type]
        with by_numpy():
            at = annuli(random, wavy(random, count), count, descent=True)
            reach = 10.0 ** random.uniform(-2.0, 0.0, (2, count))
            u = np.sort(reach * at.turning, axis=0)
            low, high = u[0] - at.v_axial, u[1] - at.v_axial
            limit = factor.bounds(at, low[None], high[None])
            h = 1e-5 * (high - low)
            value, slope, bend = [], [], []
            for share in np.linspace(0.0, 1.0, 120):
                v = (low + share * (high - low))[None]
                f, f_slope = factor.factor_slope(at, v)
                up, down = (factor.factor_slope(at, v + d)[1] for d in (h, -h))
                value.append(f), slope.append(np.abs(f_slope))
                bend.append(np.abs(up - down) / (2.0 * h))
        least, slope, bend = np.min(value, axis=0), np.max(slope, axis=0), np.max(bend, axis=0)
        assert (least >= limit.least - 1e-12).all()
        assert np.median(least - limit.least) < 1e-3
        assert (slope <= limit.slope * (1.0 + 1e-9) + 1e-12).all()
        assert (slope / np.maximum(limit.slope, 1e-12)).max() > 0.8
        assert (bend <= limit.bend * (1.0 + 1e-4) + 1e-6).all()
        assert (bend / np.maximum(limit.bend, 1e-12)).max() > 0.4


def the_law_keeps_within_its_bounds() -> None:
    """Of eqs. (3) and (4), the second differences by the angle."""
    random, count = np.random.default_rng(2017), 400
    law = blended(random, count)
    angle = np.linspace(-1.5, 1.5, 6001)[:, None]
    reynolds = np.full_like(angle, 1e5)
    with by_numpy():
        flow = SectionFlow(angle, np.sin(angle), np.cos(angle), reynolds, reynolds**-0.5)
        lift = law.coefficients(flow).lift
        limit = law.bounds()
    bend = np.diff(lift, 2, axis=0) / (angle[1] - angle[0]) ** 2
    inner = angle[1:-1]
    lifts, bends = np.abs(lift).max(axis=0), np.abs(bend).max(axis=0)
    assert (lifts <= limit.lift * (1.0 + 1e-12)).all() and (lifts / limit.lift).max() > 0.9
    assert (bends <= limit.lift_bend + 1e-6).all() and (bends / limit.lift_bend).max() > 0.6
    foot = np.where(inner > limit.attached_from, bend, 0.0).max(axis=0)
    assert (foot <= limit.foot_bend + 1e-6).all() and (foot / limit.foot_bend).max() > 0.6
    calm = (inner > 0.0) & (inner < limit.attached_to) & (law.c_l1 > law.c_l2)
    attached = np.where(calm, bend, -1.0).max(axis=0)
    assert (attached <= limit.attached_bend + 1e-6).all()


CHECKS: list[Callable[[], None]] = [
    the_walk_passes_no_root,
    newton_steps_meet_the_theorem,
    no_root_lies_above_the_start,
    the_blade_bends_by_no_more,
    the_wake_bends_by_no_more,
    the_wake_bends_by_no_more_in_nearly_axial_flow,
    the_wake_is_close_to_that_of_axial_flow,
    the_walk_passes_no_root_in_nearly_axial_climb,
    prandtls_factor_keeps_within_its_bounds,
    the_law_keeps_within_its_bounds,
]


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_the_bounds_hold(check: Callable[[], None]) -> None:
    check()


def test_the_walk_passes_no_root_in_oblique_flow() -> None:
    the_walk_passes_no_root(azimuths=8)


@pytest.mark.parametrize("azimuths", [1, 8])
def test_a_drag_angle_leaves_the_bounds_true(azimuths: int) -> None:
    """Of the blended law with its pressure drag least at any angle, against a scan."""
    random, count = np.random.default_rng(27), 3000
    law = blended(random, count)
    tilt, law = random.uniform(-0.3, 0.3, count), law._replace(c_d=2.0 * law.c_d)
    with by_numpy():
        at = annuli(random, law, count, descent=False)
        least = np.arctan2(at.station.sine, at.station.cosine) - tilt
        station = at.station._replace(drag_sine=np.sin(least), drag_cosine=np.cos(least))
        at = at._replace(station=station)
        problem, azimuth = AnnulusProblem(at, Wake(None)), azimuth_nodes(azimuths)
        ended = root.search(problem, np.array(root.MAX_STEPS), azimuth)
        bound = bounds.find_bounds(at, problem.wake)
        grid = -at.v_axial + (bound.start + at.v_axial) * np.linspace(0.0, 1.0, 1201)[:, None, None]
        lower, values = largest_by_scan(problem, azimuth, grid)
        # The second derivative by v_i of the blade's thrust at one azimuth, as above.
        v, h = at.turning * np.tan(random.uniform(-0.2, 1.2, count)) - at.v_axial, 1e-5 * at.turning
        up, down = (
            element.element_forces(at, v + d, np.float64(0.0)).normal_slope for d in (h, -h)
        )
        friction = 2.0 * bound.friction * np.sqrt(bound.speed) / bound.speed
        most = friction + bound.half * bounds._blade_bend(bound.law, bound.law.lift_bend)
    assert (values[-1] <= 0.0).all()
    assert ((up - down) / h <= most).all()
    found = ended.found[0]
    assert found.mean() > 0.98
    passed = found & (ended.inflow[0] < lower - 1e-9)
    assert not passed.any(), f"{passed.sum()} of {count} walks passed a root"
