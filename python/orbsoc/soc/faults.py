"""Faults that the simulated computer can have on purpose (rtl/soc/soc_fault.sv)."""

from __future__ import annotations

from dataclasses import dataclass

from .errors import SocError

KINDS = ("registers", "memories", "interrupt", "reset", "endless", "clock")
"""An error from the registers, from the memories; the interrupt lost; the engine reset in mid-burst; an attempt that never ends;
the engine's clock stopped. In the order of their numbers, from 1."""
PATIENCE_ROUNDS = 1000
"""Of a launch in a run with a fault: about 4000 clocks of the core each."""
_MOST = 65535


@dataclass(frozen=True, slots=True)
class Fault:
    """It comes at event `skip` of its sort, counted from 0, and at the following ones: `times` in all, 0 for each of them."""

    kind: str
    skip: int = 0
    times: int = 0

    @classmethod
    def parsed(cls, text: str) -> Fault:
        """From KIND, KIND:SKIP or KIND:SKIP:TIMES. Raises SocError."""
        kind, *numbers = text.split(":")
        allowed = f"allowed is KIND[:SKIP[:TIMES]], KIND of {', '.join(KINDS)}, numbers from 0 to {_MOST}"
        if kind not in KINDS or len(numbers) > 2 or not all(n.isdigit() and int(n) <= _MOST for n in numbers):
            raise SocError(f"--fault = {text!r}: {allowed}")
        return cls(kind, *map(int, numbers))

    def __str__(self) -> str:
        return f"{self.kind}:{self.skip}:{self.times}"

    @property
    def arguments(self) -> list[str]:
        """As the harness takes them."""
        return [str(KINDS.index(self.kind) + 1), str(self.skip), str(self.times)]
