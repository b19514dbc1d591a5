"""The inflow equation (11): its roots along the blade, and radial nodes that follow stall."""
