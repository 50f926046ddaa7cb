"""The pictures of a plan: the orbit with the burn on it, what the burn does over time, and diagnostic panels."""
