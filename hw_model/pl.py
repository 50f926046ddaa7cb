"""Cycles of a stage on the PL engine: exact lower bounds (L0) and an estimate above them (L1).

L0. Three resources bound a stage from below, whatever the order of its operations:
  issue       ⌈operations other than divisions and roots / lanes⌉: a lane starts one a cycle
  dependency  the longest dependent chain, at the latencies of the preset
  divider     ⌈(divisions · interval + roots · interval) / dividers⌉
The largest is the bound, and its name the bottleneck.

L1 estimate. A schedule overlaps the three, but not fully: (issueᵖ + dependencyᵖ + dividerᵖ)^(1/p), with p the
platform's `overlap_exponent` (1: no overlap; ∞: the bound itself), plus the drain: the depth of a lane and
the overhead of starting a segment. Never below L0. It knows nothing of banks, ports, crossbar or fetch.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from .errors import TraceError

if TYPE_CHECKING:
    from .platform import Latencies, Pl
    from .trace import Stage
    from .vocabulary import Datapath

Bottleneck = Literal["issue", "dependency", "divider"]


@dataclass(frozen=True, slots=True)
class Bounds:
    """L0 of one stage, in PL cycles."""

    issue: int
    dependency: int
    divider: int

    @property
    def cycles(self) -> int:
        """The bound: no schedule on these resources is shorter."""
        return max(self.issue, self.dependency, self.divider)

    @property
    def bottleneck(self) -> Bottleneck:
        """The resource that sets the bound."""
        if self.issue == self.cycles:
            return "issue"
        return "divider" if self.divider == self.cycles else "dependency"


@dataclass(frozen=True, slots=True)
class Estimate:
    """L1 estimate of one stage, in PL cycles, every cycle with one cause.

    `issue`: a lane slot is needed; `dependency`, `divider`: no operation was ready, for want of an
    operand or of a divider; `drain`: after the last issue, and around the segment.
    """

    bounds: Bounds
    issue: int
    dependency: int
    divider: int
    drain: int

    @property
    def cycles(self) -> int:
        """Sum of the causes."""
        return self.issue + self.dependency + self.divider + self.drain


def bounds(stage: Stage, pl: Pl, datapath: Datapath, name: str = "stage") -> Bounds:
    """L0 bounds of `stage`. Raises TraceError if it has no critical path for the platform's latency preset."""
    chain = stage.critical_path.get(pl.latency_preset)
    if chain is None:
        known = ", ".join(stage.critical_path) or "none"
        raise TraceError(
            f"`stages.{name}.critical_path` has no entry {pl.latency_preset!r} "
            f"(the platform's latency preset); it has: {known}"
        )
    units = pl.latencies.f64 if datapath == "f64" else pl.latencies.f32
    divisions, roots = stage.count("div"), stage.count("sqrt")
    on_lanes = sum(stage.operations.values()) - divisions - roots
    busy = divisions * units.div_interval_cycles.value + roots * units.sqrt_interval_cycles.value
    return Bounds(
        issue=-(-on_lanes // pl.lanes.value),
        dependency=max(chain, _slowest(stage, units)),
        divider=-(-busy // pl.dividers.value),
    )


def estimate(stage: Stage, pl: Pl, datapath: Datapath, name: str = "stage") -> Estimate:
    """L1 estimate of `stage`; stalls are divided between dependency and divider as their p-th powers."""
    floor = bounds(stage, pl, datapath, name)
    power = pl.overlap_exponent.value
    # Relative to the largest: no power overflows, and as that share is exactly 1, never below the bound.
    top = max(floor.cycles, 1)
    shares = [(part / top) ** power for part in (floor.issue, floor.dependency, floor.divider)]
    busy = round(top * sum(shares) ** (1.0 / power))
    stalls = busy - floor.issue
    waiting = shares[1] + shares[2]
    divider = round(stalls * shares[2] / waiting) if waiting > 0.0 else 0
    units = pl.latencies.f64 if datapath == "f64" else pl.latencies.f32
    drain = units.mul_cycles.value + units.add_cycles.value + pl.segment_overhead_cycles.value
    return Estimate(floor, floor.issue, stalls - divider, divider, drain)


def _slowest(stage: Stage, units: Latencies) -> int:
    """Latency of the slowest arithmetic operation present: a chain is at least that long."""
    latencies = {
        "mul": units.mul_cycles, "add": units.add_cycles, "sub": units.add_cycles,
        "div": units.div_cycles, "sqrt": units.sqrt_cycles,
    }  # fmt: skip
    return max((unit.value for code, unit in latencies.items() if stage.operations[code]), default=0)
