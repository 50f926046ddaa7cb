"""Impulses: a programme of them as data, as unknowns of a conic problem, and by column generation with a bound."""

from .generation import INSTANTS, Generated, Round, generate, primer_ceiling
from .programme import CSV_COLUMNS, ImpulseFileError, ImpulseProgramme
from .unknowns import KICK, Affine, Cost, Impulses, ImpulsesError

__all__ = [
    "CSV_COLUMNS",
    "INSTANTS",
    "KICK",
    "Affine",
    "Cost",
    "Generated",
    "ImpulseFileError",
    "ImpulseProgramme",
    "Impulses",
    "ImpulsesError",
    "Round",
    "generate",
    "primer_ceiling",
]
