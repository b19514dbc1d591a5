"""Dynamic inflow for simulators: loads that lag behind changes of rotor speed and velocity."""

from __future__ import annotations

from collections.abc import Sequence
from types import EllipsisType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from propmap.errors import InputError
from propmap.loads import LOADS
from propmap.model.corrections import InflowShape, PittPeters, name_of
from propmap.operating_points import broadcast
from propmap.results import Loads, Wrench, spin_sign
from propmap.rotor import Rotor
from propmap.tasks import cores
from propmap.typing import Floats

_FORCE, _MOMENT = (..., slice(0, 3)), (..., slice(3, 6))  # of rows (..., 17) of the core
STEP = 2e-6  # step of the central differences in ``linearize``, divided by tip speed plus airspeed


class DynamicInflow:
    """Inflow as a state that lags behind changes of rotor speed and velocity.

    A state is an array (..., ``size``) [m/s].  Its first three values are harmonics, which add to
    the inflow of the annuli: a uniform inflow, and the increases from hub to tip along x and y of
    the rotor frame of ``Rotor.wrench``.
    The other values are the inflows of the annuli at fixed radii, positive against the thrust.
    A state whose rates all vanish solves eq. (11), like the inflow of ``rotor.loads``.  If
    blades stall, eq. (11) can have several solutions, and the final state of a simulation can
    differ from the largest solution, which ``rotor.loads`` uses.  The equations are in
    ``core/include/propmap/dynamic_inflow.hpp``, and the limits of the model in docs/theory.md.

    Parameters
    ----------
    rotor : Rotor
        Rotor with the inflow of Pitt and Peters, or with an inflow that is uniform over azimuth.
    spin : str or sequence of str
        Direction of rotation, "ccw" or "cw", seen from above with the thrust up.  A sequence
        lists the spins of several equal rotors.  The last axis of ``omega`` runs over the rotors.

    Attributes
    ----------
    size : int
        Number of values in a state: 3 harmonics and 24 to 192 annuli, most for an abrupt stall.

    Raises
    ------
    InputError
        For a rotor with another inflow, and for a ``spin`` other than "ccw" or "cw".

    References
    ----------
    P. J. Carpenter, B. Fridovich, NACA TN 3044, 1953; D. M. Pitt, D. A. Peters, "Theoretical
    Prediction of Dynamic-Inflow Derivatives", Vertica 5(1), 1981.
    """

    def __init__(self, rotor: Rotor, *, spin: str | Sequence[str] = "ccw") -> None:
        if not isinstance(rotor, Rotor):
            raise InputError(f"rotor is {type(rotor).__name__}", "give a propmap.Rotor")
        other = [one for one in rotor.model.corrections if isinstance(one, InflowShape)]
        if other and not isinstance(other[0], PittPeters):
            found = f"the inflow {name_of(other[0])!r} has no dynamics"
            remedy = 'use a model with propmap.correction("pitt-peters") instead'
            raise InputError(found, remedy)
        self.rotor, self.spin = rotor, spin
        every = [spin_sign(each) for each in ([spin] if isinstance(spin, str) else spin)]
        self._sign = np.array(every[0] if isinstance(spin, str) else every)
        self.size: int = rotor._core.inflow_size

    def steady(self, omega: ArrayLike, velocity: ArrayLike) -> Floats:
        """Return the steady state (..., size) [m/s] for the largest solution of eq. (11).

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
        return self._motion(..., ..., omega, velocity)[0]

    def rates(self, state: ArrayLike, omega: ArrayLike, velocity: ArrayLike) -> Floats:
        """Return the time derivative (..., size) [m/s^2] of a state.

        Parameters
        ----------
        state : array_like, shape (..., size)
            State of the inflow [m/s].
        omega, velocity : array_like
            As in ``steady``.
        """
        return self._motion(state, ..., omega, velocity)[0]

    def step(
        self, state: ArrayLike, dt: ArrayLike, omega: ArrayLike, velocity: ArrayLike
    ) -> Floats:
        """Return the state (..., size) [m/s] after a time step.

        The step solves the linearized equation of each annulus and of each harmonic exactly.  It is
        stable for any step length.

        Parameters
        ----------
        state : array_like, shape (..., size)
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
        return self._motion(state, dt, omega, velocity)[0]

    def loads(self, state: ArrayLike, omega: ArrayLike, velocity: ArrayLike) -> Loads:
        """Return the loads of the blades in the inflow of a state.

        Parameters
        ----------
        state : array_like, shape (..., size)
            State of the inflow [m/s].
        omega, velocity : array_like
            As in ``steady``.
        """
        _, rows = self._motion(state, ..., omega, velocity)
        shape = rows.shape[:-1]
        flat, w = rows[..., 6:].reshape(-1, rows.shape[-1] - 6).T, np.broadcast_to(omega, shape)
        return self.rotor._as_loads(flat[: len(LOADS)], flat[len(LOADS) :], w.ravel(), shape)

    def wrench(self, state: ArrayLike, omega: ArrayLike, velocity: ArrayLike) -> Wrench:
        """Return force and moment on the vehicle in the rotor frame, as in ``Rotor.wrench``.

        Parameters
        ----------
        state : array_like, shape (..., size)
            State of the inflow [m/s].
        omega, velocity : array_like
            As in ``steady``.
        """
        _, rows = self._motion(state, ..., omega, velocity)
        return Wrench(rows[_FORCE], rows[_MOMENT])

    def advance(
        self, state: ArrayLike, dt: ArrayLike, omega: ArrayLike, velocity: ArrayLike
    ) -> tuple[Wrench, Floats]:
        """Return the wrench before a time step and the state (..., size) [m/s] after the step.

        A single evaluation of the blade elements yields both results.

        Parameters
        ----------
        state, dt, omega, velocity : array_like
            As in ``step``.

        Raises
        ------
        InputError
            As in ``step``.
        """
        later, rows = self.rotor._core.inflow_motion(
            state, dt, omega, velocity, self._sign, cores()
        )
        return Wrench(rows[_FORCE], rows[_MOMENT]), later

    def linearize(
        self, omega: float, velocity: ArrayLike, state: ArrayLike | None = None
    ) -> Linearization:
        """Return the linear dynamics about a state, by default about the steady state.

        The derivatives are central differences; near omega = 0, those with respect to omega are
        one-sided.  The eigenvalues of ``a`` are the rates at which
        small deviations grow.  Eigenvalues with a negative real part describe a decay.

        Parameters
        ----------
        omega, velocity : float, array_like
            Operating point, as in ``steady``: one omega, and one velocity of shape (3,).
        state : array_like, shape (size,), optional
            State [m/s] (default: the steady state).

        Raises
        ------
        InputError
            As in ``steady``, and for several operating points, spins or states.
        """
        given = self.steady(omega, velocity) if state is None else broadcast(state=state)[0]
        if given.shape != (self.size,) or self._sign.ndim:
            raise InputError(
                "linearize accepts a single operating point of a single rotor",
                f"give one omega, velocity and spin, and at most one state of {self.size} values",
            )
        inputs = np.array([omega, *np.asarray(velocity, np.float64).tolist()], np.float64)
        center = np.concatenate([given, inputs])
        tip = self.rotor.model.span[1]
        speed = abs(float(omega)) * tip + float(np.linalg.norm(inputs[1:])) + 1.0
        steps = np.full(center.size, STEP * speed)
        steps[self.size] /= tip
        ends = center + np.concatenate([np.diag(steps), np.diag(-steps)])
        n, size = center.size, self.size
        ends[:, size] = np.maximum(ends[:, size], 0.0)
        steps[size] = 0.5 * (ends[size, size] - ends[n + size, size])
        found, rows = self._motion(ends[:, :size], ..., ends[:, size], ends[:, size + 1 :])
        rates, loads = (
            ((values[:n] - values[n:]) / (2.0 * steps[:, None])).T
            for values in (found, rows[:, :6])
        )
        return Linearization(rates[:, :size], rates[:, size:], loads[:, :size], loads[:, size:])

    def _motion(
        self,
        state: ArrayLike | EllipsisType,
        dt: ArrayLike | EllipsisType,
        omega: ArrayLike,
        velocity: ArrayLike,
    ) -> tuple[Floats, Floats]:
        """Return the states after ``dt``; if ``dt`` is Ellipsis, return the rates.

        If ``state`` and ``dt`` are Ellipsis, return the steady states.  Also return rows (..., 17)
        of force, moment, and the core's results for ``Loads``.
        """
        found: tuple[Floats, Floats]
        found = self.rotor._core.inflow_motion(state, dt, omega, velocity, self._sign, cores())
        return found


class Linearization(NamedTuple):
    """Linear dynamics dx/dt = a x + b u, y = c x + d u of deviations from an operating point.

    The state x has n values [m/s].  The inputs u are the rotational speed [rad/s] and the velocity
    [m/s] along x, y and z.  The outputs y are the force [N] and the moment [N m] on the vehicle
    along x, y and z.  All vectors are in the rotor frame.

    Attributes
    ----------
    a : ndarray, shape (n, n)
        Derivatives of the rates with respect to the state [1/s].
    b : ndarray, shape (n, 4)
        Derivatives of the rates with respect to the inputs [m/(s rad)], [1/s].
    c : ndarray, shape (6, n)
        Derivatives of the outputs with respect to the state [N s/m], [N s].
    d : ndarray, shape (6, 4)
        Derivatives of the outputs with respect to the inputs [N s/rad], [N s/m], [N m s/rad],
        [N s].
    """

    a: Floats
    b: Floats
    c: Floats
    d: Floats
