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

from hw_model.errors import TraceError
from hw_model.vocabulary import OPCODES, Datapath, Opcode

if TYPE_CHECKING:
    from hw_model.platform.sections import Latencies, Pl

    from .trace import Stage

_ARITHMETIC: tuple[Opcode, ...] = ("mul", "add", "sub", "mul_add", "mul_sub", "div", "sqrt")

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
    """L0 bounds of `stage`.

    Raises TraceError if it has no critical path for the platform's latency preset, or an impossible one.
    """
    chain = stage.critical_path.get(pl.latency_preset)
    if chain is None:
        known = ", ".join(stage.critical_path) or "none"
        raise TraceError(
            f"`stages.{name}.critical_path` has no entry {pl.latency_preset!r} "
            f"(the platform's latency preset); it has: {known}"
        )
    units = pl.units(datapath)
    latencies = _latencies(units)
    serial = sum(count * latencies[code] for code, count in stage.operations.items())
    if chain > serial:
        raise TraceError(
            f"`stages.{name}.critical_path.{pl.latency_preset}` = {chain}: longer than its "
            f"{sum(stage.operations.values())} operations one after another ({serial} cycles)"
        )
    divisions, roots = stage.count("div"), stage.count("sqrt")
    on_lanes = sum(stage.operations.values()) - divisions - roots
    busy = divisions * units.div_interval_cycles.value + roots * units.sqrt_interval_cycles.value
    return Bounds(
        issue=-(-on_lanes // pl.lanes.value),
        dependency=max([chain, *(latencies[code] for code in _ARITHMETIC if stage.operations[code])]),
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
    units = pl.units(datapath)
    drain = units.mul_cycles.value + units.add_cycles.value + pl.segment_overhead_cycles.value
    return Estimate(floor, floor.issue, stalls - divider, divider, drain)


def _latencies(units: Latencies) -> dict[str, int]:
    """Cycles of each operation. Copies, signs, comparisons and selections take at most as long as an addition."""
    add, mul = units.add_cycles.value, units.mul_cycles.value
    both = mul + add
    found: dict[str, int] = dict.fromkeys(OPCODES, add)
    found |= {"mul": mul, "mul_add": both, "mul_sub": both}
    return found | {"div": units.div_cycles.value, "sqrt": units.sqrt_cycles.value}
