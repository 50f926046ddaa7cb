"""What flies the plan by other means than planned it: another integrator, and the engine as it is."""
