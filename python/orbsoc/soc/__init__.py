"""The whole computer in one simulation: the flight code on a core in RTL, beside the engine in RTL. Cycles are counted."""

from .counted import Counted, StageCount
from .errors import SocError
from .machine import Machine
from .program import Program

__all__ = ["Counted", "Machine", "Program", "SocError", "StageCount"]
