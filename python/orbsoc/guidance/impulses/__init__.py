"""Impulses: a programme of them as data, as unknowns of a conic problem, and by column generation with a bound."""

from .generation import INSTANTS, Generated, Round, generate, primer_arcs, primer_ceiling
from .nowhere import Family, Nowhere, nowhere_feasible
from .programme import CSV_COLUMNS, ImpulseFileError, ImpulseProgramme
from .unknowns import KICK, Affine, Cost, Impulses, ImpulsesError, spread_kick

__all__ = [
    "CSV_COLUMNS",
    "INSTANTS",
    "KICK",
    "Affine",
    "Cost",
    "Family",
    "Generated",
    "ImpulseFileError",
    "ImpulseProgramme",
    "Impulses",
    "ImpulsesError",
    "Nowhere",
    "Round",
    "generate",
    "nowhere_feasible",
    "primer_arcs",
    "primer_ceiling",
    "spread_kick",
]
