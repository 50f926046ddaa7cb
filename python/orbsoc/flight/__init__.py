"""The chip's own program: a pattern's tables, setters, self-test and bounds as C99 beside the fixed library."""

from .export import FlightError, export_c

__all__ = ["FlightError", "export_c"]
