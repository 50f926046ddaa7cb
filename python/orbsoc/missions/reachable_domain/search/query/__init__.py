"""Questions to a solved domain: whether an orbit is within reach, and by how much."""
