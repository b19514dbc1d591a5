"""The inflow equation (11): its roots along the blade, and what follows stall."""
