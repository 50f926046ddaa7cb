"""What a run does that costs energy, counted: no joules here.

Dynamic actions belong to a piece of work and are the same however long it takes. Standing ones last: a count is then
picoseconds (of one core, one unit, or the device). Both are whole numbers, so that their sums are exact.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import TYPE_CHECKING, Final, Literal, get_args

from hw_model.timing.control_program import members
from hw_model.timing.ps import computing_cores
from hw_model.vocabulary import OPCODES, WORD_BYTES, Datapath, Module, Opcode

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from hw_model.timing.actions import Action, Work
    from hw_model.timing.durations import Durations
    from hw_model.timing.trace import Stage

Dynamic = Literal[
    "add_f64", "add_f32", "mul_f64", "mul_f32", "div_f64", "div_f32", "logic_f64", "logic_f32",
    "bank_read_bit", "bank_write_bit", "microcode_bit", "beat", "register_access", "core_cycle",
]  # fmt: skip
Standing = Literal["core_waiting", "core_idle", "unit_clock", "ps_static", "pl_static", "memory_static"]
EnergyAction = Literal[Dynamic, Standing]

DYNAMIC: Final[tuple[Dynamic, ...]] = get_args(Dynamic)
STANDING: Final[tuple[Standing, ...]] = get_args(Standing)
ENERGY_ACTIONS: Final[tuple[EnergyAction, ...]] = (*DYNAMIC, *STANDING)
BEAT_BYTES: Final = 8
"""Of a transfer between memory and PL."""

_UNITS: dict[Opcode, tuple[str, ...]] = {
    "mul": ("mul",), "add": ("add",), "sub": ("add",), "mul_add": ("mul", "add"), "mul_sub": ("mul", "add"),
    "div": ("div",), "sqrt": ("div",),
}  # fmt: skip
"""What an operation exercises; the others are logic."""
_OPERANDS: dict[Opcode, int] = {
    "move": 1, "neg": 1, "abs": 1, "sqrt": 1, "mul": 2, "add": 2, "sub": 2, "div": 2, "min": 2, "max": 2,
    "compare": 2, "and": 2, "mul_add": 3, "mul_sub": 3, "select": 3,
}  # fmt: skip

Counts = Counter[EnergyAction]


def stage_counts(stage: Stage, datapath: Datapath) -> Counts:
    """Arithmetic and storage of one run of a stage on the PL: each operand is a read of a bank, each result a write."""
    counts: Counter[str] = Counter()
    bits = 8 * WORD_BYTES[datapath]
    for code in OPCODES:
        times = stage.operations[code]
        for unit in _UNITS.get(code, ("logic",)):
            counts[f"{unit}_{datapath}"] += times
        counts["bank_read_bit"] += times * _OPERANDS[code] * bits
        counts["bank_write_bit"] += times * bits
    return _known(counts)


StageCounts = dict[tuple[int, str], Counts]
"""What `stage_counts` said of a trace's (pattern, stage): the same on every platform."""


def work_counts(work: Work, durations: Durations, microcode_word_bits: int, known: StageCounts) -> Counts:
    """Dynamic actions of one piece of work. `known` is kept up to date."""
    counts: Counts = Counter()
    link = durations.platform.link
    if work.kind == "compute" and work.side == "pl":
        key = (work.pattern, work.what)
        if key not in known:
            stages, datapath = durations.trace.patterns[work.pattern].stages, durations.trace.datapath
            known[key] = sum((stage_counts(stages[name], datapath) for name in members(work.what)), Counts())
        counts.update(known[key])
        found = durations.pl_cycles(work)
        stored = found.microcode
        compressed = durations.platform.pl.microcode_format.value == "compressed"
        exact = stored is not None and compressed
        counts["microcode_bit"] += stored.bits if stored and exact else found.cycles * microcode_word_bits
    elif work.kind == "copy":
        counts["beat"] += -(-durations.size_bytes(work) // BEAT_BYTES)
    elif work.kind == "load":
        if durations.loaded.each:
            program = durations.loaded.each[work.pattern]
            counts["beat"] += -(-durations.loaded.written(work.pattern) // BEAT_BYTES)
            counts["register_access"] += program.register_writes + program.word_stores
    elif work.kind not in ("compute", "build", "outer"):
        buffers = len(durations.trace.patterns[work.pattern].buffers)
        confirm = link.status_register_reads.value - (-buffers // link.flags_per_register.value)
        frame, acknowledged = link.frame_register_writes.value, link.acknowledge_register_writes.value
        accesses = {
            "launch": frame,
            "flags": confirm + acknowledged,
            "publish": frame + confirm,
            "rest": link.status_register_reads.value,
            "interrupt": durations.platform.runtime.completion.value == "polling",
        }
        counts["register_access"] += int(accesses.get(work.kind, 0))
    for part in durations.parts(work):
        if part.cause == "ps":
            counts["core_cycle"] += part.cycles + part.shared_cycles * (durations.cores - 1)
    return counts


def standing_counts(durations: Durations, makespan: int, computing: int, *, uses_pl: bool) -> Counts:
    """What lasts: picoseconds × how many of it. `computing`: core-picoseconds spent on the PS's own work."""
    ps, pl = durations.platform.ps, durations.platform.pl
    used = computing_cores(durations.platform, uses_pl=uses_pl)
    leading = max(used, 1) * makespan
    units = (pl.lanes.value + pl.dividers.value) * uses_pl
    return Counter[EnergyAction](
        {
            "core_waiting": max(0, leading - computing),
            "core_idle": (ps.cores.value - max(used, 1)) * makespan,
            "unit_clock": units * makespan,
            "ps_static": makespan,
            "pl_static": makespan,
            "memory_static": makespan,
        }
    )


def run_counts(
    tally: Mapping[Work, int],
    durations: Durations,
    makespan: int,
    microcode_word_bits: int,
    known: StageCounts,
    *,
    uses_pl: bool,
) -> Counts:
    """All actions of a run of `makespan` picoseconds in which each work occurs as often as `tally` says."""
    counts: Counts = Counter()
    computing = 0
    for work, times in tally.items():
        for action, count in work_counts(work, durations, microcode_word_bits, known).items():
            counts[action] += times * count
        computing += times * sum(part.picoseconds for part in durations.parts(work) if part.cause == "ps")
    counts.update(standing_counts(durations, makespan, computing, uses_pl=uses_pl))
    return counts


def counts_by_module(
    actions: Iterable[Action], durations: Durations, microcode_word_bits: int
) -> dict[Module, Counts]:
    """The dynamic actions of each module; with the standing ones, they add up to the run's."""
    found: defaultdict[Module, Counts] = defaultdict(Counter)
    stages: StageCounts = {}
    each: dict[Work, Counts] = {}
    for action in actions:
        if action.work not in each:
            each[action.work] = work_counts(action.work, durations, microcode_word_bits, stages)
        found[action.module].update(each[action.work])
    return dict(found)


def _known(counts: Counter[str]) -> Counts:
    return Counter({action: counts[action] for action in ENERGY_ACTIONS if counts[action]})
