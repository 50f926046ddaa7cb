"""A computer of one processing system (PS) and one programmable logic (PL), as tagged parameters.

A platform is a TOML file; `platforms/` holds those that ship, and presets.toml what they share.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict, ValidationError

from .data_file import Table, is_table, read, shipped
from .errors import PlatformError, describe
from .parameter import (
    Count,
    Duration,
    End,
    Exponent,
    Fraction01,
    Parameter,
    PlClock,
    PsClock,
    Rate,
    Tag,
    Units,
)
from .presets import preset, with_preset
from .vocabulary import Datapath


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
    """Processor cores. One of them runs the solve; `flop_per_cycle` is sustained on sparse kernels."""

    more_is_faster: ClassVar[frozenset[str]] = frozenset({"clock_mhz", "flop_per_cycle"})

    core: str
    cores: Parameter[Units]
    clock_mhz: Parameter[PsClock]
    flop_per_cycle: Parameter[Rate]
    div_f64_cycles: Parameter[Units]
    sqrt_f64_cycles: Parameter[Units]
    div_f32_cycles: Parameter[Units]
    sqrt_f32_cycles: Parameter[Units]


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
    """The PL engine: `lanes` issue one operation a cycle each; divisions and roots go to `dividers`."""

    more_is_faster: ClassVar[frozenset[str]] = frozenset(
        {"clock_mhz", "lanes", "dividers", "overlap_exponent"}
    )

    clock_mhz: Parameter[PlClock]
    lanes: Parameter[Units]
    dividers: Parameter[Units]
    segment_overhead_cycles: Parameter[Count]
    overlap_exponent: Parameter[Exponent]
    latency_preset: str
    latencies: LatencyPreset


class Link(Section):
    """Registers, direct memory access and interrupts between PS and PL."""

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
    dma_fixed_us: Parameter[Duration]
    dma_to_pl_bytes_per_pl_cycle: Parameter[Rate]
    dma_to_ps_bytes_per_pl_cycle: Parameter[Rate]
    port_mb_s: Parameter[Rate]
    ddr_efficiency: Parameter[Fraction01]
    interrupt_entry_us: Parameter[Duration]
    frame_register_writes: Parameter[Count]
    status_register_reads: Parameter[Count]
    flags_per_register: Parameter[Units]
    acknowledge_register_writes: Parameter[Count]


class Resources(Section):
    """What the PL of the device holds. Not used for time; a later budget compares against it."""

    lut: Parameter[Count]
    ff: Parameter[Count]
    dsp: Parameter[Count]
    bram36: Parameter[Count]


@dataclass(frozen=True, slots=True)
class Assumption:
    """One parameter as a report echoes it; `used` says whether this run's times depend on it."""

    key: str
    value: float | int
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
    resources: Resources

    def corner(self, ps: End, fabric: End) -> Platform:
        """This platform with the bands of the PS, and of PL and link together, at one end each."""
        return self.model_copy(
            update={"ps": self.ps.at(ps), "pl": self.pl.at(fabric), "link": self.link.at(fabric)}
        )

    def with_value(self, key: str, value: float | int | str) -> Platform:
        """A copy in which `key`, e.g. "pl.lanes" or "pl.latency_preset", is `value`, exactly (no band).

        Raises PlatformError for an unknown key or an impossible value.
        """
        raw = self.model_dump()
        section, _, name = key.partition(".")
        allowed = [entry.key for entry in self.assumptions() if not entry.key.startswith("pl.latencies.")]
        if key == "pl.latency_preset":
            raw["pl"]["latency_preset"] = value
        elif key in allowed:
            was = raw[section][name]["value"]
            raw[section][name] = {"value": value, "tag": "assumed", "source": f"set for this run (was {was})"}
        else:
            raise PlatformError(
                f"`{key}` is not a parameter; allowed: {', '.join(allowed)}, pl.latency_preset"
            )
        del raw["pl"]["latencies"]
        return _validated(raw, f"platform {self.name}")

    def assumptions(self, datapath: Datapath | None = None, *, pl_used: bool = True) -> list[Assumption]:
        """Every parameter with its provenance; `used` for a run of `datapath` with or without PL."""
        other = {"f64": "f32", "f32": "f64", None: ""}[datapath]
        rows: list[Assumption] = []
        for section in (self.ps, self.pl, self.link, self.resources):
            for key, item in _walk(section, type(section).__name__.lower()):
                used = _affects_time(key, other, pl_used=pl_used)
                rows.append(Assumption(key, item.value, item.low, item.high, item.tag, item.source, used))
        return rows


def _affects_time(key: str, other_datapath: str, *, pl_used: bool) -> bool:
    section, _, name = key.partition(".")
    if section == "resources" or name == "cores" or (other_datapath and other_datapath in name):
        return False
    return section == "ps" or pl_used


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
    for section in ("ps", "pl", "link"):
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
