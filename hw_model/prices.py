"""How long each piece of work takes on one platform, cause by cause."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

from . import link, pl, ps
from .vocabulary import WORD_BYTES, Cause, picos_of_cycles

if TYPE_CHECKING:
    from .platform import Platform
    from .trace import Trace
    from .walk import Action, Work


class Part(NamedTuple):
    """A stretch of one cause. `cycles` counts the clock of the side that computes; 0 for link and interrupt."""

    cause: Cause
    picos: int
    cycles: int
    detail: str
    """What the PS or link is doing: "compute", "launch", "flags", "publish", "copy x to the PL by dma", … """


class Prices:
    """Prices of the work in one trace on one platform; each distinct piece is priced once."""

    def __init__(self, trace: Trace, platform: Platform) -> None:
        self.trace = trace
        self.platform = platform
        self._known: dict[Work, tuple[Part, ...]] = {}

    def parts(self, work: Work) -> tuple[Part, ...]:
        """The parts of `work`, in order; none is empty. Σ picos is its duration."""
        known = self._known.get(work)
        if known is None:
            known = tuple(part for part in self._price(work) if part.picos or part.cycles)
            self._known[work] = known
        return known

    def total_picos(self, actions: Iterable[Action]) -> int:
        """Makespan of `actions`: they run one after another."""
        totals = {work: sum(part.picos for part in self.parts(work)) for work in {a.work for a in actions}}
        return sum(totals[action.work] for action in actions)

    def estimate(self, work: Work) -> pl.Estimate:
        """L1 estimate of a "compute" on the PL."""
        stage = self.trace.patterns[work.pattern].stages[work.what]
        return pl.estimate(stage, self.platform.pl, self.trace.datapath, work.what)

    def _price(self, work: Work) -> list[Part]:
        links, pl_clock_mhz = self.platform.link, self.platform.pl.clock_mhz.value
        match work.kind:
            case "launch":
                return [Part("link", link.frame(links), 0, "launch")]
            case "flags":
                picos = self._confirmation(work.pattern) + link.acknowledgement(links)
                return [Part("link", picos, 0, "flags")]
            case "publish":
                return [Part("link", link.frame(links) + self._confirmation(work.pattern), 0, "publish")]
            case "rest":
                return [Part("link", link.status(links, pl_clock_mhz), 0, "rest")]
            case "interrupt":
                return [Part("interrupt", link.interrupt_entry(links), 0, "interrupt")]
            case "copy":
                copy = link.copy(links, pl_clock_mhz, self.size_bytes(work), work.side)
                return [
                    Part(
                        "link", copy.picos, 0, f"copy {work.what} to the {work.side.upper()} by {copy.method}"
                    )
                ]
            case "compute":
                return self._on_pl(work) if work.side == "pl" else self._on_ps(work)

    def size_bytes(self, work: Work) -> int:
        """Bytes of the buffer of a "copy"."""
        return self.trace.patterns[work.pattern].buffers[work.what] * WORD_BYTES[self.trace.datapath]

    def _confirmation(self, pattern: int) -> int:
        buffers = len(self.trace.patterns[pattern].buffers)
        return link.confirmation(self.platform.link, self.platform.pl.clock_mhz.value, buffers)

    def _on_ps(self, work: Work) -> list[Part]:
        stage = self.trace.patterns[work.pattern].stages[work.what]
        cycles = ps.stage_cycles(stage, self.platform.ps, self.trace.datapath)
        [picos] = picos_of_cycles([cycles], self.platform.ps.clock_mhz.value)
        return [Part("ps", picos, cycles, "compute")]

    def _on_pl(self, work: Work) -> list[Part]:
        found = self.estimate(work)
        causes: tuple[Cause, ...] = ("issue", "dependency", "divider", "drain")
        cycles = [found.issue, found.dependency, found.divider, found.drain]
        picos = picos_of_cycles(cycles, self.platform.pl.clock_mhz.value)
        return [Part(*row, "compute") for row in zip(causes, picos, cycles, strict=True)]
