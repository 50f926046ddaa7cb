"""The tables of a platform file: what the model knows of PS, PL, link, runtime, area and resources."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict

from hw_model.vocabulary import Datapath

from .parameter import (
    Banks,
    Completion,
    Count,
    Duration,
    End,
    Exponent,
    FabricName,
    Fraction01,
    MicrocodeFormat,
    MicrocodeMemory,
    Parameter,
    Parity,
    PlClock,
    PsClock,
    PsPrice,
    Rate,
    Schedule,
    StorageDepth,
    StorageMemory,
    Units,
)


class Section(BaseModel):
    """One table of a platform file: unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    more_is_faster: ClassVar[frozenset[str]] = frozenset()
    """Parameters whose large values shorten the run; of all others, the small values do."""

    def own_parameters(self) -> Iterator[tuple[str, Parameter[Any]]]:
        """Name and value of each parameter of this table itself, in the order of its declaration."""
        for name in type(self).model_fields:
            item = getattr(self, name)
            if isinstance(item, Parameter):
                yield name, item

    def parameters(self, prefix: str = "") -> Iterator[tuple[str, Parameter[Any]]]:
        """Key and value of every parameter, those of inner tables last."""
        for name, item in self.own_parameters():
            yield f"{prefix}{name}", item
        for name in type(self).model_fields:
            item = getattr(self, name)
            if isinstance(item, Section):
                yield from item.parameters(f"{prefix}{name}.")

    def at(self, end: End) -> Self:
        """This section with every banded parameter at its `slow` or `fast` end."""
        moved = {
            name: item.at(end, more_is_faster=name in self.more_is_faster)
            for name, item in self.own_parameters()
        }
        return self.model_copy(update=moved)


WITHIN = Parameter(value=0.0, tag="assumed", source="within the cycles of an instruction")
NONE = Parameter(value=0.0, tag="assumed", source="within the fixed part")


class Ps(Section):
    """Processor cores and their caches; `flop_per_cycle` is what one core sustains on sparse kernels.

    `price`: a stage takes its flops at "flop_per_cycle", or its "executed_instructions" (timing/instructions.py), of which
    this core needs `instruction_factor` times as many as `instruction_record` has, at `cycles_per_instruction`; and waits of
    `_stall_cycles` for each multiply-add in a chain, each other operation, and each word of the buffers that the stage touches.

    `build_flops_per_nonzero`: what generating a subproblem's matrices costs, per KKT nonzero. When a stage runs on
    n cores (`runtime.cores_used`), `parallel_fraction` of it is divided by n, and `fork_join_us` is added.
    """

    more_is_faster: ClassVar[frozenset[str]] = frozenset({"clock_mhz", "flop_per_cycle", "parallel_fraction"})

    core: str
    cores: Parameter[Units]
    clock_mhz: Parameter[PsClock]
    flop_per_cycle: Parameter[Rate]
    div_f64_cycles: Parameter[Units]
    sqrt_f64_cycles: Parameter[Units]
    div_f32_cycles: Parameter[Units]
    sqrt_f32_cycles: Parameter[Units]
    build_flops_per_nonzero: Parameter[Duration]
    cache_line_bytes: Parameter[Units]
    parallel_fraction: Parameter[Fraction01]
    fork_join_us: Parameter[Duration]
    price: Parameter[PsPrice] = Parameter(value="flop_per_cycle", tag="assumed", source="design input")
    instruction_factor: Parameter[Rate] = Parameter(
        value=1.0, low=1.0, high=2.0, tag="assumed", source="no count for this core"
    )
    cycles_per_instruction: Parameter[Rate] = Parameter(
        value=1.0, low=0.5, high=2.0, tag="assumed", source="no figure for this core"
    )
    multiply_add_stall_cycles: Parameter[Duration] = WITHIN
    operation_stall_cycles: Parameter[Duration] = WITHIN
    word_stall_cycles: Parameter[Duration] = WITHIN
    instruction_record: str = "instructions"
    """Counts of stages, hw_model/timing/{this}.json."""


class Latencies(Section):
    """Floating-point units of one datapath: result after `_cycles`, next operation after `_interval_cycles`."""

    add_cycles: Parameter[Units]
    mul_cycles: Parameter[Units]
    div_cycles: Parameter[Units]
    sqrt_cycles: Parameter[Units]
    div_interval_cycles: Parameter[Units]
    sqrt_interval_cycles: Parameter[Units]


class LatencyPreset(Section):
    """The same family of units in both widths."""

    f64: Latencies
    f32: Latencies


class Pl(Section):
    """The PL engine: `lanes` issue one operation a cycle each; divisions and roots go to `dividers`.

    `banks` of storage, the `clusters` that lanes and banks lie in, and the `microcode_format` ("flat", or "compressed", which takes fewer bits and some more cycles)
    enter exact schedules and the budget; `microcode_compression` (flat bits over stored bits) a budget from estimates
    alone, for schedules count the bits.

    `storage_memory` and `microcode_memory` say where the two lie: "block_ram", "ultra_ram", or for microcode "streamed", from
    DDR memory over `stream_ports` ports of its own of `stream_bytes_per_cycle` each, the first beat after `stream_start_us`, as
    rtl/ has it for compressed microcode. "streamed_start": only segments that run once an attempt
    are streamed, those of the iteration lie in block RAM, which rtl/ has not. `storage_depth`: rows of a bank, a "power_of_two",
    or as many as the schedules need ("exact"); rtl/ has both.

    `parity`: "per_word", one bit more in each word of storage and each line of microcode, takes area alone (docs/rtl.md, Parity); or "none".

    `load_bytes_per_cycle`: of microcode that the engine's slave takes, whatever the link brings.

    `interleaved`: problems of one pattern that every segment works on at once, each with words of its own (timing/groups.py).
    """

    more_is_faster: ClassVar[frozenset[str]] = frozenset(
        {
            "clock_mhz", "lanes", "dividers", "overlap_exponent", "stream_bytes_per_cycle", "stream_ports",
            "load_bytes_per_cycle",
        }
    )  # fmt: skip

    clock_mhz: Parameter[PlClock]
    lanes: Parameter[Units]
    dividers: Parameter[Units]
    banks: Parameter[Banks]
    clusters: Parameter[Banks]
    microcode_format: Parameter[MicrocodeFormat]
    microcode_compression: Parameter[Exponent]
    storage_memory: Parameter[StorageMemory]
    storage_depth: Parameter[StorageDepth]
    microcode_memory: Parameter[MicrocodeMemory]
    stream_bytes_per_cycle: Parameter[Rate]
    stream_ports: Parameter[Units]
    stream_start_us: Parameter[Duration]
    load_bytes_per_cycle: Parameter[Rate] = Parameter(
        value=6.4,
        tag="measured",
        source="rtl/axi in simulation: 16 beats of 8 bytes in 20 clocks (docs/driver.md, Timing)",
    )
    interleaved: Parameter[Units] = Parameter(
        value=1, tag="assumed", source="design input: one problem at a time"
    )
    parity: Parameter[Parity] = Parameter(
        value="none", tag="assumed", source='design input: as rtl/ is by default; or "per_word"'
    )
    segment_overhead_cycles: Parameter[Count]
    overlap_exponent: Parameter[Exponent]
    latency_preset: str
    latencies: LatencyPreset

    def units(self, datapath: Datapath) -> Latencies:
        """The floating-point units of a datapath."""
        return self.latencies.f64 if datapath == "f64" else self.latencies.f32


class Link(Section):
    """Registers, direct memory access and copies by a core between PS and PL.

    The PS cleans its cache line by line before the PL reads by DMA, and invalidates it before it reads what DMA
    wrote; both cost 0 on a coherent port. A transfer's first burst takes `dma_first_ns_per_byte` more: it is read before it is
    written, and no burst before it hides that. Of a transfer to the PL the beginning, 8 KiB at most, takes
    `dma_cached_ns_per_byte` more, which fits lines that the core's cache has to give on a coherent port. A PUBLISH takes
    `publish_ns` beside its accesses. An attempt's first PUBLISH and launch each take `first_ns` more: their code and data may be in
    no cache.
    """

    more_is_faster: ClassVar[frozenset[str]] = frozenset(
        {
            "dma_to_pl_bytes_per_pl_cycle",
            "dma_to_ps_bytes_per_pl_cycle",
            "port_mb_s",
            "ddr_efficiency",
            "flags_per_register",
        }
    )

    register_write_ns: Parameter[Duration]
    register_write_pl_cycles: Parameter[Duration] = NONE
    register_read_fixed_ns: Parameter[Duration]
    register_read_pl_cycles: Parameter[Duration]
    core_write_ns_per_byte: Parameter[Duration]
    core_write_pl_cycles_per_byte: Parameter[Duration]
    core_read_ns_per_byte: Parameter[Duration]
    core_read_pl_cycles_per_byte: Parameter[Duration]
    dma_fixed_us: Parameter[Duration]
    dma_fixed_pl_cycles: Parameter[Duration] = NONE
    dma_first_ns_per_byte: Parameter[Duration] = NONE
    dma_cached_ns_per_byte: Parameter[Duration] = NONE
    dma_to_pl_bytes_per_pl_cycle: Parameter[Rate]
    dma_to_ps_bytes_per_pl_cycle: Parameter[Rate]
    port_mb_s: Parameter[Rate]
    ddr_efficiency: Parameter[Fraction01]
    cache_clean_ns_per_line: Parameter[Duration]
    cache_invalidate_ns_per_line: Parameter[Duration]
    publish_ns: Parameter[Duration] = NONE
    first_ns: Parameter[Duration] = NONE
    frame_register_writes: Parameter[Count]
    status_register_reads: Parameter[Count]
    flags_per_register: Parameter[Units]
    acknowledge_register_writes: Parameter[Count]


class Runtime(Section):
    """How the PS is programmed: operating system, cores that work on a stage, how it waits, run-to-run jitter.

    `schedule`: "serial", one thing at a time as in the paper, or "overlapped": PS, PL and DMA work side by side where
    the data allow it, and one core only controls the PL. Jitter lengthens a piece of work by at most its bound:
    `_fraction` of its own time, or `_us`. A draw is bound · Uᵏ with U uniform in [0, 1], k = `jitter_exponent`.
    """

    completion: Parameter[Completion]
    schedule: Parameter[Schedule]
    interrupt_entry_us: Parameter[Duration]
    cores_used: Parameter[Units]
    ps_jitter_fraction: Parameter[Duration]
    link_jitter_fraction: Parameter[Duration]
    interrupt_jitter_us: Parameter[Duration]
    jitter_exponent: Parameter[Exponent]


class Area(Section):
    """The family of cells, the engine's parts in them, and how full a device may get (area/engine.py has the formula)."""

    fabric: FabricName
    lut_control: Parameter[Count]
    lut_lane_f64: Parameter[Count]
    lut_lane_f32: Parameter[Count]
    lut_divider_f64: Parameter[Count]
    lut_divider_f32: Parameter[Count]
    ff_control: Parameter[Count]
    ff_lane_f64: Parameter[Count]
    ff_lane_f32: Parameter[Count]
    ff_divider_f64: Parameter[Count]
    ff_divider_f32: Parameter[Count]
    lut_decoder_per_lane: Parameter[Count]
    lut_decoder_per_line_bit: Parameter[Count]
    ff_decoder: Parameter[Count]
    ff_decoder_per_lane: Parameter[Count]
    lut_stream: Parameter[Count]
    ff_stream: Parameter[Count]
    lut_ceiling: Parameter[Fraction01]
    ff_ceiling: Parameter[Fraction01]
    dsp_ceiling: Parameter[Fraction01]
    bram36_ceiling: Parameter[Fraction01]
    uram_ceiling: Parameter[Fraction01]


class Energy(Section):
    """What each action of a run costs (energy/actions.py): picojoules of one, milliwatts of what lasts.

    An operation of the PL by kind and width; a bit read from or written to a bank, or fetched as microcode; a beat of
    eight bytes between memory and PL; a register access; a clock cycle of a core that computes. Milliwatts: a core that
    waits for the PL, each further core, the clock of one lane or divider, and what PS, PL and memory draw all the time.
    """

    add_f64_pj: Parameter[Duration]
    add_f32_pj: Parameter[Duration]
    mul_f64_pj: Parameter[Duration]
    mul_f32_pj: Parameter[Duration]
    div_f64_pj: Parameter[Duration]
    div_f32_pj: Parameter[Duration]
    logic_f64_pj: Parameter[Duration]
    logic_f32_pj: Parameter[Duration]
    bank_read_bit_pj: Parameter[Duration]
    bank_write_bit_pj: Parameter[Duration]
    microcode_bit_pj: Parameter[Duration]
    beat_pj: Parameter[Duration]
    register_access_pj: Parameter[Duration]
    core_cycle_pj: Parameter[Duration]
    core_waiting_mw: Parameter[Duration]
    core_idle_mw: Parameter[Duration]
    unit_clock_mw: Parameter[Duration]
    ps_static_mw: Parameter[Duration]
    pl_static_mw: Parameter[Duration]
    memory_static_mw: Parameter[Duration]


class Resources(Section):
    """What the PL of the device holds. It does not enter any time; the budget compares against it."""

    lut: Parameter[Count]
    ff: Parameter[Count]
    dsp: Parameter[Count]
    bram36: Parameter[Count]
    uram: Parameter[Count] = Parameter(value=0, tag="assumed", source="none is listed for the part")
