"""Figures of a solved domain, and of one point of it."""
