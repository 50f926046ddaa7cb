"""Time of a stage on one core of the processing system, from its operation counts.

cycles = ⌈flops / flop_per_cycle + divisions · div_cycles + roots · sqrt_cycles⌉

A multiply-add counts as two flops, every other operation but division and root as one: loads, stores and
index arithmetic are inside `flop_per_cycle`, which is what sparse kernels sustain. Divisions and roots do
not overlap with anything, because the pivots and scalings that need them are on the dependent chain.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from .vocabulary import OPCODES, Datapath, Opcode

if TYPE_CHECKING:
    from .platform import Ps
    from .trace import Stage

_TWO_FLOPS: frozenset[Opcode] = frozenset({"mul_add", "mul_sub"})
_NOT_STREAMING: frozenset[Opcode] = frozenset({"div", "sqrt"})


def flops(stage: Stage) -> int:
    """Flops of a stage without its divisions and roots."""
    streaming = (code for code in OPCODES if code not in _NOT_STREAMING)
    return sum((2 if code in _TWO_FLOPS else 1) * stage.operations[code] for code in streaming)


def stage_cycles(stage: Stage, ps: Ps, datapath: Datapath) -> int:
    """PS clock cycles of one run of `stage` on one core."""
    if datapath == "f64":
        div, sqrt = ps.div_f64_cycles.value, ps.sqrt_f64_cycles.value
    else:
        div, sqrt = ps.div_f32_cycles.value, ps.sqrt_f32_cycles.value
    streaming = math.ceil(flops(stage) / ps.flop_per_cycle.value)
    return streaming + div * stage.count("div") + sqrt * stage.count("sqrt")
