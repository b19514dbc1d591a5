"""Plan the fastest flight through three gates, and fly the plan on the full model.

One plan uses the exported polynomial, the other the hover model.  In flight, an LQR follows each
plan.
"""

import casadi
import numpy as np
from apc_8x6e_multinomial import force, moment

import propmap
from propmap.vehicle.vehicle import Body, Mount

GATES = np.array([[6.0, 2.0, 1.5], [10.0, -3.0, 2.5], [16.0, 0.0, 1.0]])  # m, from the start
HOVER = 675.0  # approximate rotor speed in hover [rad/s], the unit of speeds in the plan
SLOWEST, FASTEST, LIMIT = 400.0, 880.0, 950.0  # [rad/s]; limits in the plan, and in flight
STEPS = 12  # from gate to gate
WEIGHTS = np.diag([20.0] * 3 + [2.0] * 3 + [20.0] * 4 + [0.5] * 3), 2e-4 * np.eye(4)  # of the LQR
GRAVITY = np.array([0.0, 0.0, -9.81])

blade, law = propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")
corrections = propmap.correction("pitt-peters"), propmap.correction("radial-friction")
rotor = propmap.Rotor(propmap.Model(blade, law, corrections=corrections))  # as in the table
places = [(0.16, -0.16, 0.02), (-0.16, 0.16, 0.02), (0.16, 0.16, 0.02), (-0.16, -0.16, 0.02)]
spins = "ccw", "ccw", "cw", "cw"
mounts = [Mount(p, spin=spin) for p, spin in zip(places, spins, strict=True)]
body = Body(drag_area=(0.015, 0.015, 0.03))  # m^2
quad = propmap.Vehicle("quad", 1.2, blade, tuple(mounts), body=body)
INERTIA = np.array([0.011, 0.011, 0.02])  # kg m^2
static = rotor.loads(HOVER, 0.0, 0.0)


def turned(q):
    """Return the rotation matrix from the body to the world, for a quaternion w, x, y, z."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return casadi.vertcat(*(casadi.horzcat(*row) for row in rows))


def wrench_of(plan, velocity, rates, omega):
    """Return force and moment of rotors and body, by the "polynomial" or the "hover model"."""
    area, arms = 0.5 * quad.air.density * np.array(body.drag_area), casadi.SX.zeros(3)
    total = -area * velocity * casadi.sqrt(velocity**2 + 1e-6)
    for k, place in enumerate(places):
        sign, square = 1 if spins[k] == "ccw" else -1, (omega[k] / HOVER) ** 2
        pushed, spun = [0, 0, square * static.thrust], [0, 0, -sign * square * static.torque]
        if plan == "polynomial":
            hub = casadi.vertsplit(velocity + casadi.cross(rates, casadi.DM(place)))
            pushed, spun = force(omega[k], *hub, sign), moment(omega[k], *hub, sign)
        total += casadi.vertcat(*pushed)
        arms += casadi.vertcat(*spun) + casadi.cross(casadi.DM(place), casadi.vertcat(*pushed))
    return total, arms


def motion(state, pushed, spun):
    """Return the rate of position, velocity, quaternion and body rates for a force and moment."""
    q, w = state[6:10], state[10:]
    turning = casadi.vertcat(
        -q[1] * w[0] - q[2] * w[1] - q[3] * w[2],
        q[0] * w[0] + q[2] * w[2] - q[3] * w[1],
        q[0] * w[1] - q[1] * w[2] + q[3] * w[0],
        q[0] * w[2] + q[1] * w[1] - q[2] * w[0],
    )
    acceleration = turned(q) @ pushed / quad.mass + GRAVITY
    angular = (spun - casadi.cross(w, INERTIA * w)) / INERTIA
    return casadi.vertcat(state[3:6], acceleration, 0.5 * turning, angular)


def runge_kutta(rate, state, length):
    """Return the state after one Runge-Kutta step of fourth order."""
    a = rate(state)
    b = rate(state + length / 2 * a)
    c = rate(state + length / 2 * b)
    return state + length / 6 * (a + 2 * b + 2 * c + rate(state + length * c))


def planned(plan):
    """Return durations of the steps, states, rotor speeds and feedback of the fastest flight."""
    state, omega, length = casadi.SX.sym("s", 13), casadi.SX.sym("w", 4), casadi.SX.sym("t")

    def rate(s):
        return motion(s, *wrench_of(plan, turned(s[6:10]).T @ s[3:6], s[10:], omega))

    later = runge_kutta(rate, state, length)
    step = casadi.Function("step", [state, omega, length], [later])
    by = [casadi.jacobian(later, x) for x in (state, omega)]
    slopes = casadi.Function("slopes", [state, omega, length], by)
    problem, count = casadi.Opti(), STEPS * len(GATES)
    lengths = problem.variable(len(GATES))
    states = problem.variable(13, count + 1)
    speeds = problem.variable(4, count)  # as multiples of HOVER
    each = [lengths[k // STEPS] / STEPS for k in range(count)]
    # The small second term prevents jumps of the rotor speeds.
    jumps = casadi.sumsqr(speeds[:, 1:] - speeds[:, :-1])
    problem.minimize(casadi.sum1(lengths) + 2e-3 * jumps)
    start = np.zeros(13)
    start[6] = 1.0
    problem.subject_to(states[:, 0] == start)
    for k in range(count):
        problem.subject_to(states[:, k + 1] == step(states[:, k], HOVER * speeds[:, k], each[k]))
    problem.subject_to(problem.bounded(SLOWEST / HOVER, casadi.vec(speeds), FASTEST / HOVER))
    problem.subject_to(problem.bounded(-8.0, casadi.vec(states[10:, :]), 8.0))  # rad/s
    problem.subject_to(problem.bounded(0.2, lengths, 5.0))
    path = np.vstack([np.zeros(3), GATES])
    for k, gate in enumerate(GATES, start=1):
        problem.subject_to(states[:3, STEPS * k] == gate)
    way = np.linspace(0, len(GATES), count + 1)
    guess = [np.interp(way, np.arange(len(GATES) + 1), path[:, axis]) for axis in range(3)]
    problem.set_initial(states[:3, :], np.array(guess))
    problem.set_initial(states[6, :], 1.0)
    problem.set_initial(speeds, 1.0)
    problem.set_initial(lengths, 1.0)
    quiet = {"print_level": 0, "sb": "yes", "max_iter": 500}
    problem.solver("ipopt", {"print_time": False}, quiet)
    found = problem.solve()
    times = np.repeat(found.value(lengths) / STEPS, STEPS)
    flown, turning = found.value(states).T, HOVER * found.value(speeds).T
    (cost, effort), gains = WEIGHTS, []
    left = cost
    for k in reversed(range(count)):
        a, b = (np.asarray(m) for m in slopes(flown[k], turning[k], times[k]))
        gain = np.linalg.solve(effort + b.T @ left @ b, b.T @ left @ a)
        left = cost + a.T @ left @ (a - b @ gain)
        gains.insert(0, gain)
    return times, flown, turning, gains


def flown_on_full_model(times, plan, speeds, gains, parts=5):
    """Return the states (n, 13) of a flight along a plan, simulated with all rotor loads."""
    forces = propmap.VehicleForces(quad, rotor)
    state, states = plan[0], [plan[0]]
    for length, wanted, feed, gain in zip(times, plan[:-1], speeds, gains, strict=True):
        omega = np.clip(feed - gain @ (state - wanted), SLOWEST, LIMIT)

        def rate(s, omega=omega):
            found = forces.wrench(omega, np.asarray(turned(s[6:10]).T @ s[3:6]).ravel(), s[10:])
            return np.asarray(motion(s, found.force, found.moment)).ravel()

        for _ in range(parts):
            state = runge_kutta(rate, state, length / parts)
            state[6:10] /= np.linalg.norm(state[6:10])
        states.append(state)
    return np.array(states)


for name in ("polynomial", "hover model"):
    times, plan, speeds, gains = planned(name)
    flight = flown_on_full_model(times, plan, speeds, gains)
    off = np.linalg.norm(flight[:, :3] - plan[:, :3], axis=1)
    print(
        f"{name}: {times.sum():.2f} s, up to {np.linalg.norm(plan[:, 3:6], axis=1).max():.1f} m/s; "
        f"flown, {', '.join(f'{one:.2f}' for one in off[STEPS::STEPS])} m from the gates, "
        f"at most {off.max():.2f} m from the plan"
    )
