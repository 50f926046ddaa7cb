"""The search for an engine: every shape, order, clock, memory and partition of one workload under a device's resources.

A shape (order of elimination, lanes, dividers, banks) is scheduled once, by itself; its clocks,
memories and partitions are priced from that. The workload is solved once under each order, before that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hw_model import HwModelError
from hw_model.area.budget import engine_shape, require_ports
from hw_model.platform.partition import all_partitions
from hw_model.platform.platform import load_platform
from hw_model.report.design import PAPER, Row
from hw_model.report.study import Study
from orbsoc.conic.problem_file import encode_problem
from orbsoc.conic.settings import ORDERINGS
from orbsoc.files.atomic_write import write_atomically
from orbsoc.files.json_fields import read_json, write_json

from .exact_cycles import exact_cycles
from .workload import Workload, load_workload, pattern_file

if TYPE_CHECKING:
    from hw_model import Platform
    from hw_model.platform.partition import Partition

DESIGNS = "designs"
"""The dataset of the priced designs."""
_KINDS: dict[str, Any] = {"str": object, "int": int, "float": float}


@dataclass(frozen=True, slots=True, kw_only=True)
class Space:
    """What is searched: values of each parameter; every one with every other, but for clusters that do not divide the lanes and for
    streamed microcode whose lines are too short for a port of rtl/."""

    ordering: tuple[str, ...] = ("amd", "nested_dissection")
    lanes: tuple[int, ...] = (1, 2, 4, 8, 16)
    dividers: tuple[int, ...] = (1, 2, 4)
    banks: tuple[int, ...] = (16, 32)
    clusters: tuple[int, ...] = (1, 8)
    clock_mhz: tuple[float, ...] = (100.0, 150.0)
    microcode_memory: tuple[str, ...] = ("block_ram", "streamed_start")

    def __post_init__(self) -> None:
        unknown = [name for name in self.ordering if name not in ORDERINGS]
        if unknown:
            raise HwModelError(f"`ordering` = {unknown[0]!r}: allowed are {', '.join(ORDERINGS)}")

    @property
    def shapes(self) -> list[dict[str, Any]]:
        """Engines that need a schedule of their own."""
        names = ("ordering", "lanes", "dividers", "banks", "clusters")
        every = (
            dict(zip(names, values, strict=True)) for values in product(*(getattr(self, n) for n in names))
        )
        return [shape for shape in every if shape["clusters"] == 1 or shape["lanes"] % shape["clusters"] == 0]

    @property
    def designs_of_a_shape(self) -> int:
        """Designs that are priced from one schedule, at most."""
        return len(self.clock_mhz) * len(self.microcode_memory) * len(_partitions())


@cache
def _partitions() -> tuple[Any, ...]:
    """All that use the PL, streams and resident control among them: without it there is no engine to design."""
    return tuple(partition for partition in all_partitions(programs=True) if partition.uses_pl)


def record(workload: Path, ordering: str, folder: Path) -> Workload:
    """The workload, solved under an order of elimination, or as an earlier run left it in `folder`."""
    place = folder / f"record-{ordering}" / "recorded.json"
    if not place.is_file():
        made = load_workload(workload, ordering)
        place.parent.mkdir(parents=True, exist_ok=True)
        for number, problem in enumerate(made.problems):
            write_json(encode_problem(problem), place.with_name(pattern_file(number)))
        write_json({"origin": made.origin}, place.with_name("origin.json"))
        write_atomically(place, made.trace.model_dump_json(by_alias=True))
    return load_workload(place)


def origin(ordering: str, folder: Path) -> str:
    """What was recorded, in words."""
    return str(read_json(folder / f"record-{ordering}" / "origin.json")["origin"])


def payloads(space: Space, device: str, settings: Mapping[str, Any], folder: Path) -> list[dict[str, Any]]:
    """What `price_shape` takes for each shape, `designs_of_a_shape` rows each at most."""
    return [
        {
            "shape": shape,
            "device": device,
            "settings": dict(settings),
            "clocks": list(space.clock_mhz),
            "memories": list(space.microcode_memory),
            "record": str(folder / f"record-{shape['ordering']}" / "recorded.json"),
        }
        for shape in space.shapes
    ]


@cache
def _recorded(place: str) -> Workload:
    return load_workload(place)


def price_shape(payload: dict[str, Any]) -> dict[str, Any]:
    """Schedule the shape of a payload, price its designs; columns of `hw_model.report.design.Row`."""
    work, shape = _recorded(payload["record"]), payload["shape"]
    study = Study(work.trace, exact_cycles(work.problems, (), work.settings))
    base = load_platform(payload["device"]).with_values(payload["settings"])
    rows: list[Row] = []
    for clock, memory in product(payload["clocks"], payload["memories"]):
        platform = platform_of(base, shape, clock, memory)
        points = study.points(platform, [each for each in _partitions() if _is_fed(study, platform, each)])
        rows += [Row.of(point, shape["ordering"], platform) for point in points]
    return columns(rows)


def _is_fed(study: Study, platform: Platform, partition: Partition) -> bool:
    """Whether the ports of streamed microcode can feed the engine, where it streams."""
    try:
        require_ports(platform, engine_shape(study.trace, platform, partition, study.cycles))
    except HwModelError:
        return False
    return True


def platform_of(base: Platform, shape: Mapping[str, Any], clock_mhz: float, memory: str) -> Platform:
    """The device with an engine of a shape."""
    return base.with_values(
        {
            "pl.lanes": shape["lanes"],
            "pl.dividers": shape["dividers"],
            "pl.banks": shape["banks"],
            "pl.clusters": shape["clusters"],
            "pl.clock_mhz": clock_mhz,
            "pl.microcode_memory": memory,
        }
    )


def paper_design(space: Space, device: str, settings: Mapping[str, Any], folder: Path) -> Row:
    """The paper's split on the device's own engine, in the first order of the search, which is amd by default."""
    ordering = "amd" if "amd" in space.ordering else space.ordering[0]
    work = _recorded(str(folder / f"record-{ordering}" / "recorded.json"))
    platform = load_platform(device).with_values(dict(settings))
    study = Study(work.trace, exact_cycles(work.problems, (), work.settings))
    (paper,) = (partition for partition in _partitions() if partition.name == PAPER)
    (point,) = study.points(platform, [paper])
    return Row.of(point, ordering, platform)


def columns(rows: Sequence[Row]) -> dict[str, Any]:
    """Rows as columns, as a shard holds them."""
    return {
        each.name: np.array([getattr(row, each.name) for row in rows], dtype=_KINDS[str(each.type)])
        for each in fields(Row)
    }


def rows_of(found: Mapping[str, Any]) -> list[Row]:
    """The rows again, all against the PS alone in the order that it is fastest in: a shallow tree makes it slower.

    Raises HwModelError where there are none.
    """
    names = list(found)
    plain = zip(*(found[name].tolist() for name in names), strict=True)
    rows = [Row(**dict(zip(names, values, strict=True))) for values in plain]
    if not rows:
        raise HwModelError(
            "no design is left: microcode of each is streamed, and its lines are too short for a port of rtl/"
        )
    fastest = min(row.baseline_ms for row in rows)
    return [replace(row, baseline_ms=fastest) for row in rows]
