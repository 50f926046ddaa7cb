"""Vehicle, thrust arcs and their ends: the direct and the indirect method, and the flight that checks both."""
