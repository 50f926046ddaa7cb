"""One orbit table for every mission: a state, elements, a TLE, an OMM or a point of an OEM, with a date and a frame.

`table` is the table of a scenario file, `checks` what it refuses, `elements` turns keys to elements, and `catalogue` reads
two-line elements and CCSDS files.
"""

from .checks import orbit_complaints, vehicle_complaints
from .table import Orbit

__all__ = ["Orbit", "orbit_complaints", "vehicle_complaints"]
