"""Time of the PS's work, from operation counts.

One core: cycles = ⌈flops / flop_per_cycle + divisions · div_cycles + roots · sqrt_cycles⌉. A multiply-add counts as
two flops, every other operation but division and root as one: loads, stores and index arithmetic are inside
`flop_per_cycle`, which is what sparse kernels sustain. Divisions and roots do not overlap with anything, because the
pivots and scalings that need them are on the dependent chain.

With `price = "executed_instructions"`: cycles = ⌈instructions · instruction_factor · cycles_per_instruction + waits⌉ + divisions
and roots as above, where the instructions of a stage come from counts (instructions.py), and waits are for multiply-adds, other
operations and words of memory, where a core states them (`_stall_cycles`).

n cores: `parallel_fraction` of the stage is divided by n, and forking and joining added (Amdahl); the PS knows both
times beforehand, and uses one core where that is faster.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from hw_model.vocabulary import OPCODES, Datapath, Opcode

from .instructions import can_be_counted, recorded, words_of

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform
    from hw_model.platform.sections import Ps

    from .trace import Pattern, Stage, Work

_TWO_FLOPS: frozenset[Opcode] = frozenset({"mul_add", "mul_sub"})
ALONE: tuple[Opcode, ...] = ("mul", "add", "sub", "neg", "abs", "min", "max", "compare")
"""Operations whose results a core may wait for, each by itself."""
_NOT_STREAMING: frozenset[Opcode] = frozenset({"div", "sqrt"})


PRICES = ("flop_per_cycle", "executed_instructions")
"""What `ps.price` may be."""


def price_words(ps: Ps) -> str:
    """How the PS's stages are priced, in words for a report."""
    if ps.price.value == "flop_per_cycle":
        return f"flop a cycle, {ps.flop_per_cycle.tag}"
    core = recorded(ps.instruction_record).core
    scaled = "" if core.partition(",")[0] in ps.core else f", scaled to {ps.core}"
    return f"executed instructions ({core}{scaled})"


def flops(stage: Stage) -> int:
    """Flops of a stage without its divisions and roots."""
    streaming = (code for code in OPCODES if code not in _NOT_STREAMING)
    return sum((2 if code in _TWO_FLOPS else 1) * stage.operations[code] for code in streaming)


def run_cycles(name: str, pattern: Pattern, ps: Ps, datapath: Datapath) -> int:
    """PS clock cycles of one run of a stage on one core, at the price that the platform asks for.

    Stages that only a warm start runs were never counted, and a pattern that the solver has not recorded has not the sizes
    that the counts go by: they have their flops' price.
    """
    law = recorded(ps.instruction_record)
    names = name.split("+")
    counted = can_be_counted(pattern) and all(stage in law.costs for stage in names)
    if ps.price.value == "flop_per_cycle" or not counted:
        return stage_cycles(pattern.stage(name), ps, datapath)
    executed = math.fsum(law.instructions(stage, pattern) for stage in names)
    return cycles_of(executed * ps.instruction_factor.value, name, pattern, ps, datapath)


def cycles_of(
    instructions: float, name: str, pattern: Pattern, ps: Ps, datapath: Datapath, *, share: float = 1.0
) -> int:
    """PS clock cycles of one run of a stage by its number of the core's own instructions, `share` of its operations done."""
    waits = share * _waits(name, pattern, ps)
    slow = _slow_cycles(pattern.stage(name), ps, datapath)
    return math.ceil(instructions * ps.cycles_per_instruction.value + waits) + slow


def chained(name: str, stage: Stage) -> float:
    """Multiply-adds that wait for the one before: those of a factorization's tiles do not, of two sides each second one does."""
    if stage.module == "factorization":
        return 0.0
    return stage.count("mul_add", "mul_sub") / (2.0 if name.endswith("_pair") else 1.0)


def _waits(name: str, pattern: Pattern, ps: Ps) -> float:
    """Cycles in which a core with figures of its own waits for operations' results and for words."""
    stage = pattern.stage(name)
    return math.fsum(
        (
            chained(name, stage) * ps.multiply_add_stall_cycles.value,
            stage.count(*ALONE) * ps.operation_stall_cycles.value,
            words_of(stage, pattern) * ps.word_stall_cycles.value,
        )
    )


def stage_cycles(stage: Stage, ps: Ps, datapath: Datapath) -> int:
    """PS clock cycles of one run of `stage` on one core, by its flops."""
    return math.ceil(flops(stage) / ps.flop_per_cycle.value) + _slow_cycles(stage, ps, datapath)


def _slow_cycles(stage: Stage, ps: Ps, datapath: Datapath) -> int:
    """Cycles of divisions and roots."""
    if datapath == "f64":
        div, sqrt = ps.div_f64_cycles.value, ps.sqrt_f64_cycles.value
    else:
        div, sqrt = ps.div_f32_cycles.value, ps.sqrt_f32_cycles.value
    return div * stage.count("div") + sqrt * stage.count("sqrt")


def build_cycles(pattern: Pattern, ps: Ps) -> int:
    """PS clock cycles of generating one problem of this pattern, on one core."""
    return math.ceil(pattern.nnz_kkt * ps.build_flops_per_nonzero.value / ps.flop_per_cycle.value)


def outer_cycles(work: Work, ps: Ps) -> int:
    """PS clock cycles of counted work around the solves, on one core: at either price of the stages, by its instructions."""
    slow = ps.div_f64_cycles.value * work.divisions + ps.sqrt_f64_cycles.value * work.roots
    executed = work.instructions * ps.instruction_factor.value
    return math.ceil(executed * ps.cycles_per_instruction.value) + slow


class SharedWork(NamedTuple):
    """Work divided between cores: all cycles of the core that leads, and how many of them, at the end, all cores work."""

    cycles: int
    shared: int


def on_cores(cycles: int, platform: Platform, cores: int) -> SharedWork:
    """Work that takes `cycles` on one core, when `cores` ≥ 1 may share it."""
    ps = platform.ps
    if cores == 1:
        return SharedWork(cycles, 0)
    fork_join = math.ceil(ps.fork_join_us.value * ps.clock_mhz.value)
    fraction = ps.parallel_fraction.value
    together = math.ceil(cycles * (1.0 - fraction + fraction / cores)) + fork_join
    if together >= cycles:
        return SharedWork(cycles, 0)
    return SharedWork(together, math.floor(cycles * fraction / cores))


def computing_cores(platform: Platform, *, uses_pl: bool) -> int:
    """Cores that share a stage: all in use, less one that only controls the PL when work overlaps."""
    used, overlapped = platform.runtime.cores_used.value, platform.runtime.schedule.value == "overlapped"
    return used - 1 if overlapped and uses_pl else used
