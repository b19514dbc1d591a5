"""Loads of a model at any operating point."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from propmap.arrays.types import Floats
from propmap.engine.accuracy import accuracy as accuracy_setting
from propmap.engine.evaluation import Prepared, evaluate, prepare, tail_share
from propmap.errors import InputError
from propmap.model.model import Model
from propmap.solve.rotor_loads import RotorLoads

if TYPE_CHECKING:
    from propmap.engine.disk_field import Inflow
    from propmap.engine.search_report import SearchReport
    from propmap.solve.problem import RotorArrays

PRECISIONS = ("float64", "float32")

STATUSES = ("ok", "multiple_roots", "windmill", "coarse", "vortex_ring", "not_converged")
"""From harmless to fatal; where several apply, the last is given."""


@dataclass(frozen=True)
class Loads:
    """Loads of a rotor; every field has the broadcast shape of the operating points.

    Attributes
    ----------
    thrust : ndarray
        Along the axis [N].
    drag : ndarray
        In the disk plane, against the in-plane velocity [N].
    torque : ndarray
        What turns the shaft [N m]; negative where the air drives the propeller.
    roll_moment : ndarray
        About the direction of the in-plane velocity [N m], positive where the advancing side is
        lifted, before the sign of the spin is applied.
    power : ndarray
        Torque times omega [W].
    status : ndarray of str
        Of ``STATUSES``.  "multiple_roots": near stall the inflow has several solutions, the largest
        is used.  "windmill": descent so fast that the wake is above the disk.  "vortex_ring":
        momentum theory does not hold and a measured inflow is blended in; not to be trusted.
        "not_converged": the loads are NaN.
    roots : ndarray of int
        Largest number of solutions of eq. (11) along the blade.
    reverse_flow : ndarray
        Share of the blades' disk that the air meets from behind [-].
    vortex_ring : ndarray
        Share of the measured vortex-ring inflow in the inflow used [-].
    mean_inflow : ndarray
        v_i averaged over the disk [m/s].
    """

    thrust: Floats
    drag: Floats
    torque: Floats
    roll_moment: Floats
    power: Floats
    status: NDArray[np.str_]
    roots: NDArray[np.int64]
    reverse_flow: Floats
    vortex_ring: Floats
    mean_inflow: Floats


@dataclass(frozen=True)
class Wrench:
    """Force and moment on the vehicle at the hub, in the rotor frame.

    Attributes
    ----------
    force, moment : ndarray, shape (..., 3)
        [N], and about the hub [N m].
    """

    force: Floats
    moment: Floats


class Rotor:
    """Loads of a model at any operating point: the face of the package.

    Parameters
    ----------
    model : Model
        Propeller, section law, air and corrections.
    accuracy : str
        "standard" (0.1 % of static thrust and torque) or "fine" (0.01 %, slower).
    compiled : bool
        Whether the first call waits some seconds for the compiler, so that all others take a
        hundredth of the time.  For a few points in a short process it is not worth it: NumPy then
        gives the same loads, but for rounding, in some hundredths of a second each.
    precision : str
        "float64"; or "float32" for large batches of loads in less time, with errors below 0.3 % of
        static thrust and torque where "standard" promises 0.1 %; compiled only.

    Raises
    ------
    InputError
        For arguments of another kind.
    """

    def __init__(
        self,
        model: Model,
        *,
        accuracy: str = "standard",
        compiled: bool = True,
        precision: str = "float64",
    ) -> None:
        if not isinstance(model, Model):
            raise InputError(
                f"model is {model!r}", "give a Model, from propmap.Model(propeller, airfoil)"
            )
        if precision not in PRECISIONS:
            raise InputError(
                f"precision is {precision!r}: it must be one of {', '.join(PRECISIONS)}"
            )
        if precision != PRECISIONS[0] and not (compiled and accuracy == "standard"):
            raise InputError(
                f"{precision} with accuracy {accuracy!r} and compiled={compiled}",
                "it serves compiled programs of accuracy 'standard' alone",
            )
        self.model, self.accuracy = model, accuracy
        self.compiled, self.precision = compiled, precision
        self._setting, self._uniform = accuracy_setting(accuracy), False

    def __repr__(self) -> str:
        m = self.model
        return (
            f"Rotor({m.propeller.name}, {m.law_title}, rho={m.air.density} kg/m^3, "
            f"accuracy={self.accuracy})"
        )

    def for_all_sizes(self) -> Rotor:
        """This rotor, with one set of programs for batches of any size.

        A small batch takes as long as one of some hundred points, but less is compiled in all.
        """
        rotor = Rotor(
            self.model,
            accuracy=self.accuracy,
            compiled=self.compiled,
            precision=self.precision,
        )
        rotor._uniform = True
        return rotor

    def loads(self, omega: ArrayLike, speed: ArrayLike, beta: ArrayLike) -> Loads:
        """Loads at operating points.

        Parameters
        ----------
        omega, speed : array_like
            Rotational speed [rad/s] and V [m/s], >= 0; all three broadcast.
        beta : array_like
            Angle of the velocity to the axis [rad]: 0 axial climb, pi/2 edgewise flight, pi axial
            descent; beta and 2 pi - beta are mirror images with the same loads.

        Raises
        ------
        InputError
            For negative or non-finite values and unequal shapes.
        """
        w, v, b = _broadcast(omega=omega, speed=speed, beta=beta)
        _refuse_negative("omega", w, "give the spin by its direction, not by a sign [rad/s]")
        _refuse_negative("speed", v, "give the direction by beta, pi for descent [m/s]")
        return self._loads(w, *_resolve(v, b))

    def loads_at_velocity(self, omega: ArrayLike, velocity: ArrayLike) -> Loads:
        """Loads for a velocity vector in the rotor frame.

        Parameters
        ----------
        omega : array_like, shape (...)
            Rotational speed [rad/s], >= 0.
        velocity : array_like, shape (..., 3)
            Of the hub through the air, z along the thrust [m/s]; broadcast over the leading axes.
        """
        w, along, across, _ = _split(omega, velocity)
        return self._loads(w, along, across)

    def wrench(self, omega: ArrayLike, velocity: ArrayLike, spin: str = "ccw") -> Wrench:
        """Force and moment on the vehicle, as vectors in the rotor frame.

        The frame is right-handed with z along the thrust.

        Parameters
        ----------
        omega, velocity : array_like
            As in ``loads_at_velocity``.
        spin : str
            "ccw" or "cw", seen from above with the thrust up.
        """
        if spin not in ("ccw", "cw"):
            raise InputError(f"spin is {spin!r}: it must be 'ccw' or 'cw', seen from above")
        w, along, across, direction = _split(omega, velocity)
        loads = self._loads(w, along, across)
        # Counter-clockwise, the advancing side is on the right: lifting it rolls about -x.
        sign = 1.0 if spin == "ccw" else -1.0
        z = np.array([0.0, 0.0, 1.0])
        force = loads.thrust[..., None] * z - loads.drag[..., None] * direction
        moment = -sign * (loads.torque[..., None] * z + loads.roll_moment[..., None] * direction)
        return Wrench(force, moment)

    def hover_inflow(self, omega: ArrayLike) -> Floats:
        """Static inflow v_i0 [m/s] of eq. (12) at ``omega`` [rad/s], from own static thrust."""
        from propmap.engine.evaluation import static_inflow

        (w,) = _broadcast(omega=omega)
        _refuse_negative("omega", w, "give the spin by its direction, not by a sign [rad/s]")
        return static_inflow(self._prepared, self._setting, w.ravel()).reshape(w.shape)

    def inflow(
        self,
        omega: float,
        speed: float,
        beta: float,
        *,
        radius: ArrayLike | None = None,
        azimuth: ArrayLike | None = None,
    ) -> Inflow:
        """The inflow v_i(y), the angle of attack and the loads along the blade.

        What a wing behind the rotor sees is v_i (the paper's footnote 3).

        Parameters
        ----------
        omega, speed, beta : float
            One operating point, as in ``loads``.
        radius : array_like, optional
            Stations inside the blade [m]; by default 60 from root to tip.
        azimuth : array_like, optional
            psi [rad]; by default every 5 degrees of a full turn.
        """
        from propmap.engine.disk_field import look_at_disk

        w, v, b = _broadcast(omega=omega, speed=speed, beta=beta)
        if w.ndim:
            raise InputError("inflow takes one operating point: give scalars")
        _refuse_negative("omega", w, "give the spin by its direction, not by a sign [rad/s]")
        _refuse_negative("speed", v, "give the direction by beta, pi for descent [m/s]")
        blade = self.model.propeller
        y = np.linspace(blade.root, blade.radius, 60) if radius is None else np.ravel(radius)
        psi = np.linspace(0.0, 2.0 * np.pi, 73) if azimuth is None else np.ravel(azimuth)
        y, psi = _broadcast(radius=y)[0], _broadcast(azimuth=psi)[0]
        if (y < blade.root).any() or (y > blade.radius).any():
            raise InputError(f"radius must lie between {blade.root:g} and {blade.radius:g} m")
        along, across = _resolve(v, b)
        still = self.hover_inflow(w) if along < 0.0 else np.zeros(())
        flow = (float(w), float(along), float(across), float(still))
        return look_at_disk(self.arrays, flow, y, psi, compiled=self.compiled)

    def explain(
        self, omega: float, speed: float, beta: float, *, max_steps: int | None = None
    ) -> SearchReport:
        """How the inflow equation (11) was solved at one operating point, station by station.

        The place to look where a status is "not_converged": ``print(rotor.explain(...))`` names
        the station, the steps taken and the residual that is left.

        Parameters
        ----------
        omega, speed, beta : float
            The operating point, as in ``loads``.
        max_steps : int, optional
            Steps after which the search is given up; by default as in ``loads``.

        Raises
        ------
        InputError
            For arrays, and for values that ``loads`` refuses.
        """
        from propmap.engine.programs import Flow
        from propmap.engine.search_report import search_report
        from propmap.solve.root import MAX_STEPS

        w, v, b = _broadcast(omega=omega, speed=speed, beta=beta)
        if w.ndim:
            raise InputError("explain takes one operating point: give scalars")
        _refuse_negative("omega", w, "give the spin by its direction, not by a sign [rad/s]")
        _refuse_negative("speed", v, "give the direction by beta, pi for descent [m/s]")
        along, across = _resolve(v, b)
        still = self.hover_inflow(w)[None] if along < 0.0 else None
        flow = Flow(w[None], along[None], across[None], still)
        return search_report(self._prepared, self._setting, flow, max_steps or MAX_STEPS)

    @functools.cached_property
    def arrays(self) -> RotorArrays:
        """The model as arrays of NumPy float64, for ``propmap.solve.rotor_loads``."""
        return self.model.arrays()

    @functools.cached_property
    def _prepared(self) -> Prepared:
        double = self.precision == PRECISIONS[0]
        return prepare(self.arrays, compiled=self.compiled, uniform=self._uniform, double=double)

    def _loads(self, omega: Floats, v_axial: Floats, v_inplane: Floats) -> Loads:
        shape = omega.shape
        flow = (omega.ravel(), v_axial.ravel(), v_inplane.ravel())
        flat = evaluate(self._prepared, self._setting, *flow)
        coarse = tail_share(self._prepared, *flow, flat) > self._setting.finer[-1][1]
        found: Any = RotorLoads.of_rows(row.reshape(shape) for row in flat.rows)
        blade = self.model.propeller
        reverse = _reverse_flow(omega, v_inplane, blade.root, blade.radius)
        return Loads(
            **found.loads._asdict(),
            power=found.loads.torque * omega,
            status=_status(found, v_axial, coarse.reshape(shape)),
            roots=found.roots,
            reverse_flow=reverse,
            vortex_ring=found.ring,
            mean_inflow=found.mean_inflow,
        )


def _status(found: Any, v_axial: Floats, coarse: NDArray[np.bool_]) -> NDArray[np.str_]:
    windmill = (v_axial < 0.0) & (v_axial + 2.0 * found.mean_inflow <= 0.0)
    ring = (found.ring > 0.0) | found.mirrored
    lost = ~np.isfinite(found.loads.thrust)
    cases = [lost, ring, coarse, windmill, found.roots > 1]
    return np.asarray(np.select(cases, STATUSES[:0:-1], STATUSES[0]))


def _reverse_flow(omega: Floats, v_inplane: Floats, root: float, tip: float) -> Floats:
    """Share of the annulus between root and tip inside the reverse-flow circle [-].

    The circle y = -V sin(beta) sin(psi) / Omega passes through the hub.
    """
    diameter = np.minimum(v_inplane / np.maximum(omega, 1e-12), 1e4 * tip)

    def within(radius: float) -> Floats:
        angle = np.arccos(np.minimum(radius / np.maximum(diameter, 1e-12), 1.0))
        rest = 0.5 * np.pi - angle - np.sin(angle) * np.cos(angle)
        return np.asarray(radius**2 * angle + 0.5 * diameter**2 * rest)

    return np.asarray((within(tip) - within(root)) / (np.pi * (tip**2 - root**2)))


def _broadcast(**named: ArrayLike) -> list[Floats]:
    arrays = []
    for name, value in named.items():
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError(f"{name} is {value!r}: give a number or an array of numbers") from None
        if not np.isfinite(array).all():
            raise InputError(f"{name} holds a value that is not finite: remove NaN and infinity")
        arrays.append(array)
    try:
        return [np.array(a) for a in np.broadcast_arrays(*arrays)]
    except ValueError:
        shapes = ", ".join(f"{n} {np.shape(a)}" for n, a in zip(named, arrays, strict=True))
        raise InputError(f"shapes do not fit together: {shapes}; they must broadcast") from None


def _resolve(speed: Floats, beta: Floats) -> tuple[Floats, Floats]:
    """V cos(beta) and |V sin(beta)|; a multiple of pi/2 is taken at its word."""
    cosine, sine = np.cos(beta), np.abs(np.sin(beta))
    rounding = 4e-16 * np.maximum(1.0, np.abs(beta))
    cosine = np.where(np.abs(cosine) < rounding, 0.0, cosine)
    return speed * cosine, speed * np.where(sine < rounding, 0.0, sine)


def _refuse_negative(name: str, values: Floats, remedy: str) -> None:
    if (values < 0.0).any():
        raise InputError(f"{name} is negative ({values.min():g}): {remedy}")


def _split(omega: ArrayLike, velocity: ArrayLike) -> tuple[Floats, Floats, Floats, Floats]:
    """omega, velocity along the axis and across it, and the unit vector of the latter."""
    (vector,) = _broadcast(velocity=velocity)
    if vector.ndim == 0 or vector.shape[-1] != 3:
        raise InputError(f"velocity has shape {vector.shape}: its last axis must hold x, y, z")
    w, x, y, z = _broadcast(omega=omega, vx=vector[..., 0], vy=vector[..., 1], vz=vector[..., 2])
    _refuse_negative("omega", w, "give the spin by its direction, not by a sign [rad/s]")
    across = np.hypot(x, y)
    unit = np.where(across > 0.0, across, 1.0)
    direction = np.stack([np.where(across > 0.0, x / unit, 1.0), y / unit, np.zeros_like(x)], -1)
    return w, z, across, direction
