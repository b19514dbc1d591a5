"""The inflow as a state, for simulators: loads that lag behind the rotor and the flight."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from propmap.errors import InputError
from propmap.model.corrections import PittPeters
from propmap.operating_points import FlowPoints, broadcast, split_velocity
from propmap.results import Loads, Wrench, hub_wrench, spin_sign
from propmap.rotor import Rotor
from propmap.tasks import cores
from propmap.typing import Floats


class DynamicInflow:
    """The inflow of Pitt and Peters as a state that follows rotor and flight with a delay.

    A state is an array (..., 3) [m/s] in the rotor frame of ``Rotor.wrench``: the mean inflow over
    the disk, positive against the thrust, and by how much the inflow grows from the hub to the tip
    along x and along y.  Its steady value is the static solution that ``rotor.loads`` uses.
    ``core/include/propmap/dynamic_inflow.hpp`` has the equations, docs/theory.md what they leave
    out.

    Parameters
    ----------
    rotor : Rotor
        Its model has the correction "pitt-peters".
    spin : str
        "ccw" or "cw", seen from above with the thrust up.

    Raises
    ------
    InputError
        For a rotor without this correction and another spin.

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
        """The state (..., 3) [m/s] that stays as it is.

        Parameters
        ----------
        omega : array_like, shape (...)
            Rotational speed [rad/s], >= 0.
        velocity : array_like, shape (..., 3)
            Velocity of the hub through the air, z along the thrust [m/s]; broadcast over the
            leading axes.

        Raises
        ------
        InputError
            For values that are not finite, negative omega and shapes that do not fit together.
        """
        points = _StatePoints(omega, velocity)
        return points.shaped(self._motion(points).steady)

    def rates(self, state: ArrayLike, omega: ArrayLike, velocity: ArrayLike) -> Floats:
        """The rates (..., 3) [m/s^2] at which a state changes.

        Parameters
        ----------
        state : array_like, shape (..., 3)
            As above [m/s].
        omega, velocity : array_like
            As in ``steady``.
        """
        points = _StatePoints(omega, velocity, state=state)
        return points.shaped(self._motion(points).rates)

    def step(
        self, state: ArrayLike, dt: ArrayLike, omega: ArrayLike, velocity: ArrayLike
    ) -> Floats:
        """The state (..., 3) [m/s] after a time step.

        Exact where the loads are linear in the state, and stable however long the step is: after a
        long one the state is ``steady``.

        Parameters
        ----------
        state : array_like, shape (..., 3)
            At the step's beginning [m/s].
        dt : array_like, shape (...)
            Its length [s], >= 0.
        omega, velocity : array_like
            As in ``steady``; they hold throughout the step.

        Raises
        ------
        InputError
            Also for a negative ``dt``.
        """
        points = _StatePoints(omega, velocity, state=state, dt=dt)
        return points.shaped(self._motion(points).later)

    def loads(self, state: ArrayLike, omega: ArrayLike, velocity: ArrayLike) -> Loads:
        """Loads of the blades in the inflow of a state.

        Parameters
        ----------
        state : array_like, shape (..., 3)
            As above [m/s]; it is the ``mean_inflow`` of the result.
        omega, velocity : array_like
            As in ``steady``.
        """
        points = _StatePoints(omega, velocity, state=state)
        motion = self._motion(points)
        static = self.rotor._as_loads(motion.loads, motion.found, points.flow.omega, points.shape)
        return replace(static, mean_inflow=points.state[::3].reshape(points.shape))

    def wrench(self, state: ArrayLike, omega: ArrayLike, velocity: ArrayLike) -> Wrench:
        """Force and moment on the vehicle in the rotor frame, as ``Rotor.wrench``.

        Parameters
        ----------
        state : array_like, shape (..., 3)
            As above [m/s].
        omega, velocity : array_like
            As in ``steady``.
        """
        points = _StatePoints(omega, velocity, state=state)
        return hub_wrench(self._motion(points).loads, points.direction, self._sign)

    def advance(
        self, state: ArrayLike, dt: ArrayLike, omega: ArrayLike, velocity: ArrayLike
    ) -> tuple[Wrench, Floats]:
        """The ``wrench`` at the step's beginning, and the state (..., 3) [m/s] that ``step`` gives.

        Both follow from one static solution, so that they take little longer than either alone.

        Parameters
        ----------
        state, dt, omega, velocity : array_like
            As in ``step``.

        Raises
        ------
        InputError
            As ``step`` does.
        """
        points = _StatePoints(omega, velocity, state=state, dt=dt)
        motion = self._motion(points)
        wrench = hub_wrench(motion.loads, points.direction, self._sign)
        return wrench, points.shaped(motion.later)

    def time_constants(self, omega: ArrayLike, velocity: ArrayLike) -> Floats:
        """Times (..., 3) [s] in which small deviations fall to 1/e, the longest first.

        They are -1 over the real parts of the eigenvalues at the steady state: in hover of the mean
        inflow and twice of the gradients.  Negative where a deviation grows, in stall.

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
    """N states of the inflow as the core gives them, with loads (L, N)."""

    steady: Floats  # states and rates (N, 3)
    rates: Floats
    later: Floats  # a step later
    loads: Floats
    linear: Floats  # derivatives of the rates with the state along the flight (N, 3, 3)
    found: Floats  # of the static solution (5, N)


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
                f"state has shape {given.shape}: its last axis must hold the mean inflow and two "
                "gradients"
            )
        flow, direction = split_velocity(omega, velocity)
        # Simulators step by one number; `broadcast` takes as long as all else here.
        good = isinstance(dt, float) and 0.0 <= dt < np.inf
        (time,) = (np.array(dt),) if good else broadcast(dt=dt)
        if not good and (time < 0.0).any():
            raise InputError(f"dt is negative ({time.min():g}): give the step's length [s]")
        shapes = {"omega": flow.omega.shape, "state": given.shape[:-1], "dt": time.shape}
        alike = flow.omega.shape == given.shape[:-1] == time.shape
        try:
            self.shape = time.shape if alike else np.broadcast_shapes(*shapes.values())
        except ValueError:
            found = ", ".join(f"{name} {shape}" for name, shape in shapes.items())
            raise InputError(f"shapes do not fit together: {found}; they must broadcast") from None

        def spread(values: Floats, shape: tuple[int, ...]) -> Floats:
            # Simulators step one point at a time, which NumPy's function would take half of.
            return values if values.shape == shape else np.broadcast_to(values, shape)

        def flat(values: Floats) -> Floats:
            return spread(values, self.shape).ravel()

        self.direction = spread(direction, (*self.shape, 3))
        self.flow = FlowPoints(flat(flow.omega), flat(flow.v_axial), flat(flow.v_inplane))
        self.dt, self.state = flat(time), spread(given, self.direction.shape).ravel()

    def shaped(self, vectors: Floats) -> Floats:
        """Give flat (N, 3) the shape (..., 3) of the points."""
        return vectors.reshape(*self.shape, 3)
