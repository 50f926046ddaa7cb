"""A computer of one processing system (PS) and one programmable logic (PL), as tagged parameters.

A platform is a TOML file; `platforms/` holds those that ship, and presets.toml what they share.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from hw_model.errors import PlatformError, describe
from hw_model.report.reading import Reading, why_ignored

from .data_file import Table, is_table, read, shipped
from .parameter import (
    Banks,
    Completion,
    Count,
    Duration,
    End,
    Exponent,
    Fraction01,
    MicrocodeFormat,
    Parameter,
    PlClock,
    PsClock,
    Rate,
    Schedule,
    Tag,
    Units,
)
from .presets import preset, with_preset


class Section(BaseModel):
    """One table of a platform file: unknown keys are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    more_is_faster: ClassVar[frozenset[str]] = frozenset()
    """Parameters whose large values shorten the run; of all others, the small values do."""

    def at(self, end: End) -> Self:
        """This section with every banded parameter at its `slow` or `fast` end."""
        moved = {
            name: item.at(end, more_is_faster=name in self.more_is_faster)
            for name, item in parameters_of(self)
        }
        return self.model_copy(update=moved)


class Ps(Section):
    """Processor cores and their caches; `flop_per_cycle` is what one core sustains on sparse kernels.

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

    `banks` of storage and the `microcode_format` ("flat", or "compressed", which takes fewer bits and some more cycles)
    enter exact schedules and the budget; `microcode_compression` (flat bits over stored bits) a budget from estimates
    alone, for schedules count the bits.
    """

    more_is_faster: ClassVar[frozenset[str]] = frozenset(
        {"clock_mhz", "lanes", "dividers", "overlap_exponent"}
    )

    clock_mhz: Parameter[PlClock]
    lanes: Parameter[Units]
    dividers: Parameter[Units]
    banks: Parameter[Banks]
    microcode_format: Parameter[MicrocodeFormat]
    microcode_compression: Parameter[Exponent]
    segment_overhead_cycles: Parameter[Count]
    overlap_exponent: Parameter[Exponent]
    latency_preset: str
    latencies: LatencyPreset


class Link(Section):
    """Registers, direct memory access and copies by a core between PS and PL.

    The PS cleans its cache line by line before the PL reads by DMA, and invalidates it before it reads what DMA
    wrote; both cost 0 on a coherent port.
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
    register_read_fixed_ns: Parameter[Duration]
    register_read_pl_cycles: Parameter[Duration]
    core_write_ns_per_byte: Parameter[Duration]
    core_write_pl_cycles_per_byte: Parameter[Duration]
    core_read_ns_per_byte: Parameter[Duration]
    core_read_pl_cycles_per_byte: Parameter[Duration]
    dma_fixed_us: Parameter[Duration]
    dma_to_pl_bytes_per_pl_cycle: Parameter[Rate]
    dma_to_ps_bytes_per_pl_cycle: Parameter[Rate]
    port_mb_s: Parameter[Rate]
    ddr_efficiency: Parameter[Fraction01]
    cache_clean_ns_per_line: Parameter[Duration]
    cache_invalidate_ns_per_line: Parameter[Duration]
    frame_register_writes: Parameter[Count]
    status_register_reads: Parameter[Count]
    flags_per_register: Parameter[Units]
    acknowledge_register_writes: Parameter[Count]


class Runtime(Section):
    """How the PS is programmed: operating system, cores that work on a stage, how it waits, run-to-run jitter.

    `schedule`: "serial", one thing at a time as in the paper, or "overlapped": PS, PL and DMA work side by side
    where the data allow it, and one core does nothing but control the PL. Jitter lengthens a piece of work by up to its bound, never by more: `_fraction` of its
    own time, or `_us`; a draw is bound · Uᵏ with U uniform in [0, 1] and k = `jitter_exponent` (1: uniform).
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
    """Lookup tables and flip-flops of the engine's parts, and how full a device may get (area.py has the formula)."""

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
    lut_ceiling: Parameter[Fraction01]
    ff_ceiling: Parameter[Fraction01]
    dsp_ceiling: Parameter[Fraction01]
    bram36_ceiling: Parameter[Fraction01]


class Resources(Section):
    """What the PL of the device holds. It does not enter any time; the budget compares against it."""

    lut: Parameter[Count]
    ff: Parameter[Count]
    dsp: Parameter[Count]
    bram36: Parameter[Count]


@dataclass(frozen=True, slots=True)
class Assumption:
    """One parameter as a report echoes it; `used` says whether that report reads it."""

    key: str
    value: float | int | str
    low: float | int | None
    high: float | int | None
    tag: Tag
    source: str
    used: bool


class Platform(Section):
    """A complete computer; `load_platform` makes one."""

    name: str
    description: str
    ps: Ps
    pl: Pl
    link: Link
    runtime: Runtime
    area: Area
    resources: Resources

    @model_validator(mode="after")
    def _enough_cores(self) -> Self:
        used, there = self.runtime.cores_used.value, self.ps.cores.value
        if used > there:
            raise ValueError(f"`runtime.cores_used` = {used}: this PS has {there}")
        if self.runtime.schedule.value == "overlapped" and used < 2:
            raise ValueError(
                '`runtime.cores_used` = 1: schedule "overlapped" needs 2, for one core controls the PL'
            )
        return self

    def corner(self, ps: End, fabric: End, build: End = "nominal") -> Platform:
        """This platform with three sets of bands at one end each.

        They are the PS; all that the PL brings with it; and the size of the problems' generation, apart from the PS
        because it slows run and baseline alike.
        """
        generation = self.ps.build_flops_per_nonzero.at(build, more_is_faster=False)
        cores = self.ps.at(ps).model_copy(update={"build_flops_per_nonzero": generation})
        fabric_side = {name: getattr(self, name).at(fabric) for name in ("pl", "link", "runtime")}
        return self.model_copy(update={"ps": cores, **fabric_side})

    def with_value(self, key: str, value: float | int | str) -> Platform:
        """A copy in which `key`, e.g. "pl.lanes" or "pl.latency_preset", is `value`, exactly (no band).

        Raises PlatformError for an unknown key or an impossible value.
        """
        return self.with_values({key: value})

    def with_values(self, settings: Mapping[str, float | int | str]) -> Platform:
        """A copy in which several parameters are set at once, as `with_value` sets one.

        A runtime preset comes first, whatever the order: "runtime.preset" = "linux" replaces the whole section.
        """
        raw = self.model_dump()
        if "runtime.preset" in settings:
            raw["runtime"] = preset("runtime", settings["runtime.preset"])
        allowed = [entry.key for entry in self.assumptions() if not entry.key.startswith("pl.latencies.")]
        for key, value in settings.items():
            section, _, name = key.partition(".")
            if key == "pl.latency_preset":
                raw["pl"]["latency_preset"] = value
            elif key in allowed:
                was = raw[section][name]["value"]
                source = f"set for this run (was {was})"
                raw[section][name] = {"value": value, "tag": "assumed", "source": source}
            elif key != "runtime.preset":
                raise PlatformError(
                    f"`{key}` is not a parameter; allowed: {', '.join(allowed)}, pl.latency_preset, runtime.preset"
                )
        del raw["pl"]["latencies"]
        return _validated(raw, f"platform {self.name}")

    def assumptions(self, reading: Reading | None = None) -> list[Assumption]:
        """Every parameter with its provenance; `used` by what `reading` reads, or by nothing."""
        rows: list[Assumption] = []
        for section in (self.ps, self.pl, self.link, self.runtime, self.area, self.resources):
            for key, item in _walk(section, type(section).__name__.lower()):
                used = reading is not None and why_ignored(key, self, reading) is None
                rows.append(Assumption(key, item.value, item.low, item.high, item.tag, item.source, used))
        return rows


def parameters_of(section: Section) -> Iterator[tuple[str, Parameter[Any]]]:
    """Name and value of each parameter that `section` itself holds, in the order of its declaration."""
    for name in type(section).model_fields:
        item = getattr(section, name)
        if isinstance(item, Parameter):
            yield name, item


def _walk(section: Section, prefix: str) -> Iterator[tuple[str, Parameter[Any]]]:
    for name, item in parameters_of(section):
        yield f"{prefix}.{name}", item
    for name in type(section).model_fields:
        item = getattr(section, name)
        if isinstance(item, Section):
            yield from _walk(item, f"{prefix}.{name}")


def platform_names() -> list[str]:
    """Names of the platforms that ship."""
    return shipped("platforms")


def load_platform(name_or_path: str | Path) -> Platform:
    """A shipped platform by name ("zu9eg"), or one from a TOML file (a path, or a name ending in .toml).

    Raises PlatformError naming the key, its value and what is allowed.
    """
    raw, where = read("platform", "platforms", name_or_path, PlatformError)
    for section, name in (("runtime", "bare_metal"), ("area", "orbsoc_rtl")):
        raw.setdefault(section, {"preset": name})
    for section in ("ps", "pl", "link", "runtime", "area"):
        given = raw.get(section)
        if is_table(given):
            try:
                raw[section] = with_preset(section, given)
            except PlatformError as error:
                raise PlatformError(f"{where}: {error}") from None
    return _validated(raw, where)


def _validated(raw: Table, where: str) -> Platform:
    """A platform from complete tables; the latencies come from presets.toml by `pl.latency_preset`."""
    try:
        pl = raw.get("pl")
        if is_table(pl) and "latency_preset" in pl:
            if "latencies" in pl:
                raise PlatformError("`pl.latencies` cannot be given; name a `pl.latency_preset`")
            raw = raw | {"pl": pl | {"latencies": preset("latency", pl["latency_preset"])}}
        return Platform.model_validate(raw)
    except ValidationError as error:
        raise PlatformError(f"{where}: {describe(error, Platform)}") from error
    except PlatformError as error:
        raise PlatformError(f"{where}: {error}") from None
