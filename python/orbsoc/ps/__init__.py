"""Python plays the processing system: it schedules the stages of the solver on an emulated PS+PL computer."""

from orbsoc.ps.registers import ProtocolError
from orbsoc.ps.scheduler import PsScheduler

__all__ = ["ProtocolError", "PsScheduler"]
