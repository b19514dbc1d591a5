"""Differentiate the thrust of a rotor with respect to the flight state, in a JAX program."""

import jax
import jax.numpy as jnp
import numpy as np

import propmap
import propmap.jax
from propmap.loads import LOADS

rotor = propmap.Rotor(propmap.Model(propmap.propeller("apc-8x6e"), propmap.airfoil("paper-apc")))
omega = 6000 * np.pi / 30  # rad/s


@jax.jit
def thrust(omega, velocity):
    """Return the thrust [N] at a velocity (axial, in-plane) [m/s]."""
    return propmap.jax.loads(rotor, omega, *velocity)[list(LOADS).index("thrust")]


with jax.enable_x64(True):
    velocity = jnp.array([3.0, 8.0])
    by_omega, by_velocity = jax.grad(thrust, argnums=(0, 1))(omega, velocity)
    print("d thrust / d omega    ", float(by_omega), "N s/rad")
    print("d thrust / d velocity ", np.asarray(by_velocity), "N s/m, axial and in-plane")

    # Check the axial derivative with a difference quotient of the thrust.
    ahead, behind = (thrust(omega, velocity.at[0].add(h)) for h in (1e-3, -1e-3))
    print("by differences, axial ", float(ahead - behind) / 2e-3, "N s/m")

    # Find the rotational speed for 2 N of thrust in this flight, by Newton's method.
    for _ in range(5):
        omega -= (thrust(omega, velocity) - 2.0) / jax.grad(thrust)(omega, velocity)
    print("omega for 2 N         ", float(omega), "rad/s")
