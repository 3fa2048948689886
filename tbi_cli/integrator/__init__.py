"""The integrator: it knows arrays, not trains."""
