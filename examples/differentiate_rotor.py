"""Derivatives of a rotor's loads with JAX: by the flight state and by the section's constants."""

import jax
import jax.numpy as jnp
import numpy as np

import propmap
from propmap.theory.loads import rotor_loads

rotor = propmap.Rotor(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc"))
omega = 6000 * np.pi / 30  # rad/s


def thrust(section, omega, velocity):
    """Thrust [N] for a velocity (axial, in-plane) [m/s]."""
    blade, _, air = rotor.theory
    axial, inplane = velocity
    # The theory works on batches: here a batch of one.
    return rotor_loads(blade, section, air, *(jnp.atleast_1d(x) for x in (omega, axial, inplane)))[
        0
    ][0]


with jax.enable_x64(True):
    section, velocity = rotor.theory[1], jnp.array([3.0, 8.0])
    by_section, by_omega, by_velocity = jax.jit(jax.jacfwd(thrust, argnums=(0, 1, 2)))(
        section, omega, velocity
    )
    print("d thrust / d omega    ", float(by_omega), "N s/rad")
    print("d thrust / d velocity ", np.asarray(by_velocity), "N s/m, axial and in-plane")
    print("d thrust / d c_l1     ", float(by_section.c_l1), "N rad")
    print("d thrust / d alpha_0  ", float(by_section.alpha_0), "N/rad")

    # The same by differences of the computed thrust.
    step = 1e-3
    up, down = (
        float(thrust(section, omega, velocity + jnp.array([h, 0.0]))) for h in (step, -step)
    )
    print("by differences, axial ", (up - down) / (2 * step), "N s/m")
