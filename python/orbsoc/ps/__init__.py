"""Python plays the processing system: it schedules the stages of the solver on an emulated PS+PL computer."""

from .registers import ProtocolError
from .scheduler import PsScheduler

__all__ = ["ProtocolError", "PsScheduler"]
