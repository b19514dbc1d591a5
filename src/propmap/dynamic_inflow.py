"""Dynamic inflow for simulators: loads that lag behind changes of rotor speed and velocity."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from propmap.errors import InputError
from propmap.model.corrections import PittPeters
from propmap.operating_points import FlowPoints, broadcast, forward, split_velocity
from propmap.results import Loads, Wrench, hub_wrench, spin_sign
from propmap.rotor import Rotor
from propmap.tasks import cores
from propmap.typing import Floats


class DynamicInflow:
    """Inflow of Pitt and Peters as a state that lags behind changes of rotor speed and velocity.

    A state is an array (..., 3) [m/s] in the rotor frame of ``Rotor.wrench``.  It contains the
    mean inflow over the disk, positive against the thrust, and the increases of the inflow from
    hub to tip along x and along y.  The steady state is the static solution that ``rotor.loads``
    uses.  ``core/include/propmap/dynamic_inflow.hpp`` contains the equations, and docs/theory.md
    describes their limits.

    Parameters
    ----------
    rotor : Rotor
        Rotor whose model has the correction "pitt-peters".
    spin : str
        Direction of rotation, "ccw" or "cw", seen from above with the thrust up.

    Raises
    ------
    InputError
        For a rotor without this correction, or another ``spin``.

    References
    ----------
    D. A. Peters, N. HaQuang, "Dynamic Inflow for Practical Applications", J. American Helicopter
    Society 33(4), 1988.
    """

    def __init__(self, rotor: Rotor, *, spin: str = "ccw") -> None:
        if not isinstance(rotor, Rotor) or rotor.model.correction_of(PittPeters) is None:
            found = "dynamic inflow needs a rotor with the inflow of Pitt and Peters"
            remedy = 'add propmap.correction("pitt-peters") to the model\'s corrections'
            raise InputError(found, remedy)
        self.rotor, self.spin, self._sign = rotor, spin, spin_sign(spin)

    def steady(self, omega: ArrayLike, velocity: ArrayLike) -> Floats:
        """Return the steady state (..., 3) [m/s].

        Parameters
        ----------
        omega : array_like, shape (...)
            Rotational speed [rad/s], >= 0.
        velocity : array_like, shape (..., 3)
            Velocity of the hub through the air, z along the thrust [m/s].  The leading axes
            broadcast with ``omega``.

        Raises
        ------
        InputError
            For values that are not finite, negative ``omega``, and shapes that do not broadcast.
        """
        points = _StatePoints(omega, velocity)
        return points.shaped(self._motion(points).steady)

    def rates(self, state: ArrayLike, omega: ArrayLike, velocity: ArrayLike) -> Floats:
        """Return the time derivative (..., 3) [m/s^2] of a state.

        Parameters
        ----------
        state : array_like, shape (..., 3)
            State of the inflow [m/s].
        omega, velocity : array_like
            As in ``steady``.
        """
        points = _StatePoints(omega, velocity, state=state)
        return points.shaped(self._motion(points).rates)

    def step(
        self, state: ArrayLike, dt: ArrayLike, omega: ArrayLike, velocity: ArrayLike
    ) -> Floats:
        """Return the state (..., 3) [m/s] after a time step.

        The step is exact for loads that are linear in the state.  It is stable for any step
        length: a long step ends in the ``steady`` state.

        Parameters
        ----------
        state : array_like, shape (..., 3)
            State at the start of the step [m/s].
        dt : array_like, shape (...)
            Step length [s], >= 0.
        omega, velocity : array_like
            As in ``steady``; constant during the step.

        Raises
        ------
        InputError
            As in ``steady``, and for a negative ``dt``.
        """
        points = _StatePoints(omega, velocity, state=state, dt=dt)
        return points.shaped(self._motion(points).later)

    def loads(self, state: ArrayLike, omega: ArrayLike, velocity: ArrayLike) -> Loads:
        """Return the loads of the blades in the inflow of a state.

        Parameters
        ----------
        state : array_like, shape (..., 3)
            State of the inflow [m/s]; ``mean_inflow`` of the result is its first component.
        omega, velocity : array_like
            As in ``steady``.
        """
        points = _StatePoints(omega, velocity, state=state)
        motion = self._motion(points)
        static = self.rotor._as_loads(motion.loads, motion.found, points.flow.omega, points.shape)
        return replace(static, mean_inflow=points.state[::3].reshape(points.shape))

    def wrench(self, state: ArrayLike, omega: ArrayLike, velocity: ArrayLike) -> Wrench:
        """Return force and moment on the vehicle in the rotor frame, as in ``Rotor.wrench``.

        Parameters
        ----------
        state : array_like, shape (..., 3)
            State of the inflow [m/s].
        omega, velocity : array_like
            As in ``steady``.
        """
        points = _StatePoints(omega, velocity, state=state)
        return hub_wrench(self._motion(points).loads, points.direction, self._sign)

    def advance(
        self, state: ArrayLike, dt: ArrayLike, omega: ArrayLike, velocity: ArrayLike
    ) -> tuple[Wrench, Floats]:
        """Return the ``wrench`` at the start of a step, and the state (..., 3) [m/s] at its end.

        Separate calls of ``wrench`` and ``step`` solve the static inflow twice; this method solves
        it once.

        Parameters
        ----------
        state, dt, omega, velocity : array_like
            As in ``step``.

        Raises
        ------
        InputError
            As in ``step``.
        """
        points = _StatePoints(omega, velocity, state=state, dt=dt)
        motion = self._motion(points)
        wrench = hub_wrench(motion.loads, points.direction, self._sign)
        return wrench, points.shaped(motion.later)

    def time_constants(self, omega: ArrayLike, velocity: ArrayLike) -> Floats:
        """Return the time constants (..., 3) [s] of small deviations, the longest first.

        They are -1 over the real parts of the eigenvalues at the steady state.  In hover one time
        constant belongs to the mean inflow and two equal ones to the gradients.  A time constant is
        negative if the deviation grows, which occurs in stall.

        Parameters
        ----------
        omega, velocity : array_like
            As in ``steady``.
        """
        points = _StatePoints(omega, velocity)
        matrices = self._motion(points).linear
        known = np.isfinite(matrices).all(axis=(1, 2))
        values = np.full((len(matrices), 3), np.nan)
        values[known] = np.sort(np.linalg.eigvals(matrices[known]).real, axis=1)[:, ::-1]
        with np.errstate(divide="ignore"):
            return points.shaped(-1.0 / values)

    def _motion(self, points: _StatePoints) -> _Motion:
        of = points.state, points.direction.ravel(), self._sign, points.dt
        return _Motion(*self.rotor._core.inflow_motion(points.flow.rows, *of, cores()))


class _Motion(NamedTuple):
    """Results of the core for N states of the inflow."""

    steady: Floats  # steady states (N, 3)
    rates: Floats  # (N, 3)
    later: Floats  # states after the step (N, 3)
    loads: Floats  # (L, N)
    linear: Floats  # derivatives of the rates, for axes along the in-plane velocity (N, 3, 3)
    found: Floats  # other results of the static solution (5, N)


class _StatePoints:
    """Operating points and states, broadcast and flat."""

    def __init__(
        self,
        omega: ArrayLike,
        velocity: ArrayLike,
        *,
        state: ArrayLike = (0.0, 0.0, 0.0),
        dt: ArrayLike = 0.0,
    ) -> None:
        (given,) = broadcast(state=state)
        if given.ndim == 0 or given.shape[-1] != 3:
            raise InputError(
                f"state has shape {given.shape}: its last axis must be the mean inflow and two "
                "gradients"
            )
        flow, direction = split_velocity(omega, velocity)
        forward(flow)
        # Simulators pass one number, for which `broadcast` would double the time of this function.
        good = isinstance(dt, float) and 0.0 <= dt < np.inf
        (time,) = (np.array(dt),) if good else broadcast(dt=dt)
        if not good and (time < 0.0).any():
            raise InputError(f"dt is negative ({time.min():g}): give a step length of 0 s or more")
        shapes = {"omega": flow.omega.shape, "state": given.shape[:-1], "dt": time.shape}
        alike = flow.omega.shape == given.shape[:-1] == time.shape
        try:
            self.shape = time.shape if alike else np.broadcast_shapes(*shapes.values())
        except ValueError:
            found = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
            raise InputError(f"shapes cannot be broadcast together: {found}") from None

        def spread(values: Floats, shape: tuple[int, ...]) -> Floats:
            # Simulators step one point at a time: `np.broadcast_to` would take half of that time.
            return values if values.shape == shape else np.broadcast_to(values, shape)

        def flat(values: Floats) -> Floats:
            return spread(values, self.shape).ravel()

        self.direction = spread(direction, (*self.shape, 3))
        self.flow = FlowPoints(flat(flow.omega), flat(flow.v_axial), flat(flow.v_inplane))
        self.dt, self.state = flat(time), spread(given, self.direction.shape).ravel()

    def shaped(self, vectors: Floats) -> Floats:
        """Return ``vectors`` (N, 3) in the shape (..., 3) of the points."""
        return vectors.reshape(*self.shape, 3)
