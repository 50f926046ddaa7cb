"""The chip's own program: a pattern's tables, setters, self-test and bounds as C99 beside the fixed library."""

from .export import export_c
from .partitioned import FlightError

__all__ = ["FlightError", "export_c"]
