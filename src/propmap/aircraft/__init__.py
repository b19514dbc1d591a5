"""An aircraft's steady states: trim, power, top speed, missions, and the choice of propellers."""
