"""A vehicle, its rotors, and logs of its flights."""
