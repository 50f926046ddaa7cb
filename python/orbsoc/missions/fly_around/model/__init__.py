"""The mission's mathematics: the ellipse to fly, free flight beside it, waypoints on it, what errors do to it. No solver, no files."""
