"""From one point to the whole domain: attempts, continuation over the grid, and the boundary."""
