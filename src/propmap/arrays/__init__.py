"""What the equations are written in: array functions and loops of JAX or of NumPy."""
