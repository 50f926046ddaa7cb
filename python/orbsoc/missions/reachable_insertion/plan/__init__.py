"""What was planned, as data, and what may be said of it."""
