"""The motion about an approach, its transition matrices, and how errors spread along it."""
