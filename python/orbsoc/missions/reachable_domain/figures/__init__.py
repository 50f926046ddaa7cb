"""Figures of a solved domain."""
