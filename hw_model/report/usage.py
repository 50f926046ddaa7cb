"""Parameter usage: which parameters of a platform a report reads, and why it does not read the others.

One table for all reports. It marks the parameters that a report echoes as used, and refuses a parameter that is set
where nothing reads it. A test changes every parameter under every command and compares the outcome with the table.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from hw_model.errors import IgnoredKeyError
from hw_model.timing.control_program import segments_on_pl, streams_of
from hw_model.timing.groups import NO_GROUPS_BY_THE_PS, NO_GROUPS_HERE
from hw_model.timing.instructions import can_be_counted
from hw_model.timing.ps import computing_cores
from hw_model.timing.stage_cycles import NO_GROUPS_ESTIMATED, of_program
from hw_model.vocabulary import OPCODES, Opcode

if TYPE_CHECKING:
    from hw_model.area.fabric import Kind
    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform
    from hw_model.timing.stage_cycles import StageCycles
    from hw_model.timing.trace import Trace
    from hw_model.vocabulary import Datapath

Question = Literal["times", "worst", "energy", "throughput", "loads", "fit", "memory", "engine", "written"]
"""`times`: of a run; `worst`: with jitter; `energy`: its joules; `throughput`: of many; `loads`: of programs; `fit`: shares of the device; `memory`: that of block RAM alone; `engine`: schedules
and the clock alone; `written`: all of the platform goes into a file."""


@dataclass(frozen=True, slots=True)
class ParameterUse:
    """What a report asks of a platform.

    `area`: the resources it counts. `on_pl`, `off_pl`: whether runs with and without the PL are in it. `scheduled`: its
    cycles come from schedules, not from the estimate.
    """

    questions: frozenset[Question]
    area: frozenset[Kind] = frozenset()
    on_pl: bool = True
    resident: bool = False
    """Whether the PL controls the run."""
    off_pl: bool = False
    scheduled: bool = False
    datapaths: frozenset[Datapath] = frozenset({"f64"})
    ps_datapaths: frozenset[Datapath] = frozenset({"f64"})
    ps_codes: frozenset[Opcode] = frozenset(OPCODES)
    """Operations that the PS runs at all."""
    counted: bool = True
    """Whether executed instructions of the trace's patterns can be told."""
    a_core_each: bool = False
    """Whether each core of the PS has problems of its own."""
    outer_loop: bool = False
    """Whether what happens around the solves was counted, in instructions of one core and in binary64."""

    def of(self, trace: Trace, partition: Partition, platform: Platform, cycles: StageCycles) -> ParameterUse:
        """The same of one trace under one partition, with the cycles from this source."""
        off_pl, outer_loop = self.off_pl or not partition.uses_pl, trace.outer_loop is not None
        ps_codes = _codes_on_ps(trace, None if off_pl else partition)
        ps_datapaths: frozenset[Datapath] = frozenset({trace.ps_datapath or trace.datapath})
        return replace(
            self,
            on_pl=partition.uses_pl,
            resident=partition.control == "pl",
            off_pl=off_pl,
            ps_codes=ps_codes | (_SLOW_CODES if outer_loop else frozenset()),
            scheduled=is_scheduled(trace, partition, platform, cycles),
            datapaths=frozenset({trace.datapath}),
            ps_datapaths=ps_datapaths | ({"f64"} if outer_loop else set()),
            counted=all(map(can_be_counted, trace.patterns)),
            outer_loop=outer_loop,
        )

    @property
    def asks_cycles(self) -> bool:
        """Whether it reads cycles of the PL."""
        return bool(self.area or self.questions & {"times", "engine"})


_SLOW_CODES: frozenset[Opcode] = frozenset({"div", "sqrt"})
ALL_KINDS: frozenset[Kind] = frozenset({"lut", "ff", "dsp", "bram36", "uram"})
TIMELINE_USAGE = ParameterUse(frozenset({"times"}))
"""One run without jitter: the file for a trace viewer."""
TRACE_USAGE = ParameterUse(frozenset({"times", "throughput", "loads", "fit"}), ALL_KINDS)
"""One run without jitter, and many: trace."""
THROUGHPUT_USAGE = replace(TRACE_USAGE, off_pl=True, a_core_each=True)
"""Many runs, and what sets of engines take: throughput."""
EXPLAIN_USAGE = ParameterUse(frozenset({"times", "energy", "loads", "fit"}), ALL_KINDS)
"""Times and energies of two runs: explain."""
WORST_CASE_USAGE = ParameterUse(
    frozenset({"times", "worst", "energy", "throughput", "loads", "fit"}), ALL_KINDS
)
"""Times with their worst case, energy, and many runs: plan."""
STUDY_USAGE = ParameterUse(frozenset({"times", "worst", "energy", "loads", "fit"}), ALL_KINDS, off_pl=True)
"""Times, energy and resources against a run on the PS alone: partition, sweep."""
BUDGET_USAGE = ParameterUse(frozenset({"loads", "fit"}), ALL_KINDS)
SCHEDULE_USAGE = ParameterUse(frozenset({"engine", "memory"}), scheduled=True)
"""Schedules of one engine, and whether their microcode has room: run."""
PRECISION_USAGE = ParameterUse(
    frozenset({"times"}),
    frozenset({"lut", "dsp", "bram36"}),
    scheduled=True,
    datapaths=frozenset({"f64", "f32"}),
)
"""Datapaths compared: precision."""
CALIBRATION_USAGE = ParameterUse(frozenset({"written"}))


def _codes_on_ps(trace: Trace, partition: Partition | None) -> frozenset[Opcode]:
    """Operations that the PS runs under a partition; without one, all stages are its own."""
    ran = {(solve.pattern, name) for solve in trace.solves for name, _ in solve.events}
    stages = [trace.patterns[pattern].stages[name] for pattern, name in ran]
    own = [stage for stage in stages if partition is None or partition.side(stage.module) == "ps"]
    return frozenset(code for code in OPCODES if any(stage.operations[code] for stage in own))


def is_scheduled(trace: Trace, partition: Partition, platform: Platform, cycles: StageCycles) -> bool:
    """Whether `cycles` answers with schedules for what `partition` has on the PL."""
    cycles = of_program(cycles, streams_of(trace, partition))
    for number, pattern in enumerate(trace.patterns):
        for name in segments_on_pl(trace, pattern, partition):
            return cycles(trace, platform, number, name).origin == "schedule"
    return False


def require_used(settings: Mapping[str, object], usages: Iterable[tuple[Platform, ParameterUse]]) -> None:
    """Raise IgnoredKeyError for a key that was set and that none of the usages reads, with the first usage's reason.

    `settings`: as `Platform.with_values` takes them, or the axes of a sweep.
    """
    reasons: dict[str, str] = {}
    unused = dict.fromkeys(settings)
    for platform, usage in usages:
        for key in list(unused):
            why = _why_of_setting(key, platform, usage)
            if why is None:
                del unused[key]
            else:
                reasons.setdefault(key, why)
        if not unused:
            return
    for key in unused:
        raise IgnoredKeyError(f"`{key}` = {settings[key]!r} would do nothing here: {reasons[key]}")


def why_ignored(key: str, platform: Platform, usage: ParameterUse) -> str | None:
    """Why a report does not read the parameter, and what to do; None when it does."""
    if "written" in usage.questions:
        return "it is what the measurement replaces; leave it out" if key == "ps.flop_per_cycle" else None
    section, _, name = key.partition(".")
    found = {
        "ps": _ps, "pl": _pl, "link": _link, "runtime": _runtime, "area": _area, "energy": _energy,
        "resources": _resources,
    }  # fmt: skip
    return found[section](name, platform, usage)


def _why_of_setting(key: str, platform: Platform, usage: ParameterUse) -> str | None:
    """`why_ignored` of a key as it is set: `runtime.preset` stands for the parameters in which the presets differ."""
    if key == "runtime.preset":
        reasons = [
            why_ignored(f"runtime.{name}", platform, usage)
            for name in (
                "interrupt_entry_us",
                "interrupt_jitter_us",
                "ps_jitter_fraction",
                "link_jitter_fraction",
            )
        ]
        return None if None in reasons else reasons[0]
    if key == "ps.cores" and "times" in usage.questions and platform.runtime.cores_used.value > 1:
        return None  # the limit of what is set beside it
    return why_ignored(key, platform, usage)


def _unless(used: bool, why: str) -> str | None:
    return None if used else why


def _ps(name: str, platform: Platform, usage: ParameterUse) -> str | None:
    if "times" not in usage.questions:
        return _NO_TIMES
    if name == "cores":  # those that idle draw as well
        used = "energy" in usage.questions or usage.a_core_each
        return _unless(used, "it only limits `runtime.cores_used`; set that too")
    if name == "cache_line_bytes":
        return _unless(usage.on_pl, _NO_PL)
    if name in ("parallel_fraction", "fork_join_us"):
        cores = {computing_cores(platform, uses_pl=way) for way in _ways(usage)}
        return _unless(max(cores) > 1, "one core computes; set `runtime.cores_used` to more")
    if name == "build_flops_per_nonzero":
        used = not usage.outer_loop or platform.pl.interleaved.value > 1
        return _unless(used, "the outer loop of this plan was counted, the generation of its problems in it")
    each_instruction = name in ("instruction_factor", "cycles_per_instruction")
    if each_instruction and usage.outer_loop:
        return None
    of_instructions = each_instruction or name.endswith("_stall_cycles")
    if (name == "price" or of_instructions) and not usage.counted:
        return "the trace has not the solver's own buffers, by which executed instructions go"
    if of_instructions:
        both = {"worst", "throughput"} <= usage.questions  # a report that prints either price
        return _unless(
            both or platform.ps.price.value == "executed_instructions",
            "`ps.price` is flop_per_cycle; set it to executed_instructions",
        )
    for code in ("div", "sqrt"):
        if name.startswith(f"{code}_") and code not in usage.ps_codes:
            return f"no stage that the PS runs here has the operation {code}"
    return _other_datapath(name, usage.ps_datapaths)


def _pl(name: str, platform: Platform, usage: ParameterUse) -> str | None:
    if not usage.asks_cycles:
        return "this report reads nothing of the PL; leave it out"
    if not usage.on_pl:
        return _NO_PL
    if name == "clock_mhz":
        return _unless(
            bool(usage.questions & {"times", "loads", "engine"}), f"{_NO_TIMES}; area has no clock"
        )
    if name == "load_bytes_per_cycle":
        return _unless("loads" in usage.questions, _NO_LOADS)
    if "engine" in usage.questions:
        return _unless(
            name in ("lanes", "dividers", "banks", "clusters", "interleaved", "latency_preset"),
            "this report lists every segment's cycles and microcode in both formats; leave it out",
        )
    if name in ("overlap_exponent", "segment_overhead_cycles"):
        return _unless(not usage.scheduled, "cycles come from exact schedules; ask for --estimate")
    if name in ("banks", "clusters", "microcode_format"):
        what = name.removesuffix("_format")
        return _unless(
            bool(usage.scheduled or usage.area), f"the estimate knows no {what}; ask for schedules (--exact)"
        )
    if name == "interleaved":
        return _interleaved(usage)
    if name == "microcode_compression":
        return _compression(platform, usage)
    if name == "storage_depth" and not usage.scheduled:
        return "the estimate knows no rows that temporaries need; ask for schedules (--exact)"
    if name in ("storage_memory", "storage_depth", "parity"):
        return _unless(bool(usage.area), "this report prices no area; `orbsoc hw budget` does")
    if name == "microcode_memory":
        timed = "times" in usage.questions and usage.scheduled
        return _unless(
            bool(usage.area) or timed, "the estimate knows no microcode; ask for schedules (--exact)"
        )
    if name.startswith("stream_"):
        return _stream(name, platform, usage)
    return _other_datapath(name, usage.datapaths)


def _interleaved(usage: ParameterUse) -> str | None:
    if "worst" in usage.questions or ("times" in usage.questions and "throughput" not in usage.questions):
        return NO_GROUPS_HERE
    if not usage.resident:
        return NO_GROUPS_BY_THE_PS
    return _unless(usage.scheduled, NO_GROUPS_ESTIMATED)


def _stream(name: str, platform: Platform, usage: ParameterUse) -> str | None:
    if not platform.pl.microcode_memory.value.startswith("streamed"):
        return "`pl.microcode_memory` is not streamed; set that too"
    timed = "times" in usage.questions and usage.scheduled
    if name == "stream_ports":
        return _unless(
            bool(usage.area) or timed, "the estimate knows no microcode; ask for schedules (--exact)"
        )
    return _unless(timed, _NO_TIMES)


def _compression(platform: Platform, usage: ParameterUse) -> str | None:
    if not usage.area:
        return "this report prices no area; `orbsoc hw budget` does"
    if platform.pl.microcode_format.value == "flat":
        return "`pl.microcode_format` is flat, which is not compressed"
    if usage.scheduled:
        return "the schedules' own microcode is compressed and counted; ask for --estimate to assume a compression"
    return None


def _link(name: str, platform: Platform, usage: ParameterUse) -> str | None:
    if "times" not in usage.questions and not ("loads" in usage.questions and name in OF_LOADS):
        return _NO_TIMES
    return _unless(usage.on_pl, _NO_PL)


def _runtime(name: str, platform: Platform, usage: ParameterUse) -> str | None:
    if "times" not in usage.questions:
        return _NO_TIMES
    if name in ("cores_used", "schedule") and usage.a_core_each:
        return "each core has problems of its own here; leave it out"
    if name == "cores_used":
        return None
    if name == "jitter_exponent":
        return "it shapes runs that are drawn (hw_model.timing.jitter.distribution); no report's bound depends on it"
    if "jitter" in name and "worst" not in usage.questions:
        return (
            "this report is of a run without jitter; `orbsoc hw partition` and `hw sweep` print worst cases"
        )
    if name == "ps_jitter_fraction":
        return None
    if not usage.on_pl:
        return _NO_PL
    if name.startswith("interrupt_") and platform.runtime.completion.value == "polling":
        return "`runtime.completion` is polling; set it to interrupt"
    return None


def _area(name: str, platform: Platform, usage: ParameterUse) -> str | None:
    if name.endswith("_stream") and not platform.pl.microcode_memory.value.startswith("streamed"):
        return "`pl.microcode_memory` is not streamed; set that too"
    if name.startswith("uram") and not _takes_uram(platform):
        return _NO_URAM
    if name.endswith("_ceiling"):
        return _compared(
            name, usage, "this report does not compare it with a ceiling; `orbsoc hw budget` does"
        )
    kind = name.partition("_")[0]
    if kind not in usage.area:
        return f"this report prices no {kind.upper()}; `orbsoc hw budget` does"
    if not usage.on_pl:
        return _NO_PL
    if "decoder" in name and platform.pl.microcode_format.value == "flat":
        return "`pl.microcode_format` is flat, which needs no decoder"
    return _other_datapath(name, usage.datapaths)


def _energy(name: str, platform: Platform, usage: ParameterUse) -> str | None:
    """The table of energies goes with the times, but for actions that do not occur; schedules alone have the PL's."""
    if "energy" not in usage.questions:
        if "engine" in usage.questions and name.endswith(("_f64_pj", "_f32_pj", "_bit_pj")):
            return _other_datapath(name, usage.datapaths)
        return _NO_ENERGY
    if name == "core_idle_mw":
        return _unless(platform.ps.cores.value > platform.runtime.cores_used.value, "no core idles here")
    if name in ("core_cycle_pj", "ps_static_mw", "pl_static_mw", "memory_static_mw"):
        return None
    if name == "core_waiting_mw" and platform.runtime.cores_used.value > 1:
        return None  # for the other one
    return _other_datapath(name, usage.datapaths) if usage.on_pl else _NO_PL


def _takes_uram(platform: Platform) -> bool:
    return "ultra_ram" in (platform.pl.storage_memory.value, platform.pl.microcode_memory.value)


def _resources(name: str, platform: Platform, usage: ParameterUse) -> str | None:
    if name == "uram" and not _takes_uram(platform):
        return _NO_URAM
    return _compared(name, usage, "this report does not ask whether it fits; `orbsoc hw budget` does")


def _compared(name: str, usage: ParameterUse, why: str) -> str | None:
    """None where the report asks for the share of the resource that a parameter is about; of times without the PL it does not."""
    if "times" in usage.questions and not usage.on_pl:
        return _NO_PL
    return _unless(
        "fit" in usage.questions or ("memory" in usage.questions and name.startswith("bram36")), why
    )


def _other_datapath(name: str, datapaths: frozenset[Datapath]) -> str | None:
    """A parameter that has a datapath in its name is read for that datapath only."""
    named: tuple[Datapath, ...] = ("f64", "f32")
    for datapath in named:
        if datapath in name and datapath not in datapaths:
            return f"nothing here computes in {datapath}; this run is in {' and '.join(sorted(datapaths))}"
    return None


def _ways(usage: ParameterUse) -> list[bool]:
    """Whether the runs of a report use the PL: with, without, or both."""
    return [True] * usage.on_pl + [False] * (usage.off_pl or not usage.on_pl)


OF_LOADS = frozenset(
    {
        "register_write_ns", "register_write_pl_cycles", "dma_fixed_us", "dma_fixed_pl_cycles",
        "dma_first_ns_per_byte", "dma_cached_ns_per_byte", "dma_to_pl_bytes_per_pl_cycle", "port_mb_s", "ddr_efficiency",
    }
)  # fmt: skip
"""What of the link a load of a program takes."""
_NO_LOADS = "this report loads no program; `orbsoc hw budget` does"
_NO_TIMES = "this report times no PS, link or interrupts; `orbsoc hw trace` and `hw partition` do"
_NO_URAM = "nothing is in UltraRAM; set `pl.storage_memory` or `pl.microcode_memory` to ultra_ram"
_NO_PL = "the partition leaves the PL idle; choose one that uses it"
_NO_ENERGY = "this report has no energy; `orbsoc hw explain` and `hw partition` have"
