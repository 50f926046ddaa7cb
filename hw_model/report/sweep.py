"""A sweep file: axes of values, their grid, and the points priced from one trace.

    [axes]
    device = ["zu9eg", "xc7z045"]
    partition = ["paper", "factorization+linear_solve"]
    "pl.lanes" = [1, 2, 4, 8]
    "pl.clock_mhz" = [100.0, 150.0]

`device` and `partition` default to zu9eg and paper; every other key is a parameter of the platform. Unknown keys are
errors.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hw_model.errors import HwModelError, PlatformError
from hw_model.platform.data_file import is_table, read_toml
from hw_model.platform.partition import load_partition
from hw_model.platform.platform import load_platform

from .study import Point, Study
from .usage import STUDY_USAGE, ParameterUse, require_used

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform
    from hw_model.timing.trace import Trace

MAX_POINTS = 100_000


class SweepError(HwModelError):
    """A sweep file that describes no grid; the message names the key, its value and what is allowed."""


@dataclass(frozen=True, slots=True)
class Sweep:
    """Axes of a grid. `workload` is the file to record, relative to the sweep file, where it names one; `orderings` are orders
    of elimination, by the solver's names; (): the fastest of each point."""

    devices: tuple[str, ...]
    partitions: tuple[str, ...]
    axes: Mapping[str, tuple[Any, ...]]
    workload: Path | None = None
    orderings: tuple[str, ...] = ()

    @property
    def size(self) -> int:
        """Number of points."""
        orders = max(1, len(self.orderings))
        computers = len(self.devices) * math.prod(len(values) for values in self.axes.values())
        return orders * len(self.partitions) * computers


def load_sweep(path: str | Path) -> Sweep:
    """A sweep from a TOML file. Raises SweepError, PlatformError or PartitionError by name."""
    where = f"sweep {Path(path).name}"
    raw = read_toml(Path(path), where, SweepError)
    unknown = sorted(raw.keys() - {"axes", "workload"})
    if unknown:
        raise SweepError(f"{where}: `{unknown[0]}` is not a known key; allowed: axes, workload")
    axes = raw.get("axes")
    if not is_table(axes):
        raise SweepError(f"{where}: `axes` is missing; it holds a list of values for each key")
    flat = {key: _values(where, key, value) for key, value in _flat(where, axes).items()}
    workload = raw.get("workload")
    if workload is not None and not isinstance(workload, str):
        raise SweepError(f"{where}: `workload` = {workload!r}: must be the path of a file")
    devices, partitions = flat.pop("device", ("zu9eg",)), flat.pop("partition", ("paper",))
    orderings = flat.pop("ordering", ())
    place = None if workload is None else Path(path).parent / workload
    return checked(Sweep(devices, partitions, flat, place, orderings), where)


def checked(sweep: Sweep, where: str) -> Sweep:
    """The same sweep; raises for unknown names and keys, impossible values, or too many points."""
    if sweep.size > MAX_POINTS:
        raise SweepError(f"{where}: {sweep.size} points; at most {MAX_POINTS}")
    _no_twins(sweep, where)
    possible_computers(sweep)
    return sweep


@dataclass(frozen=True, slots=True)
class Refused:
    """A computer of the grid that cannot be, or cannot be priced, and why."""

    device: str
    settings: dict[str, Any]
    why: str


def possible_computers(sweep: Sweep) -> tuple[list[tuple[Platform, dict[str, Any]]], list[Refused]]:
    """The computers of the grid with their settings, device by device, and those that cannot be.

    Raises PlatformError when none can be, as where a key is unknown: the first one's reason.
    """
    possible: list[tuple[Platform, dict[str, Any]]] = []
    refused: list[Refused] = []
    first: PlatformError | None = None
    for device in sweep.devices:
        base = load_platform(device)
        for values in product(*sweep.axes.values()):
            settings = dict(zip(sweep.axes, values, strict=True))
            try:
                possible.append((base.with_values(settings), settings))
            except PlatformError as error:
                first = first or error
                refused.append(Refused(base.name, settings, str(error)))
    if first is not None and not possible:
        raise first
    return possible, refused


def run(
    trace: Trace, sweep: Sweep, study: Study | None = None, progress: Callable[[int], None] | None = None
) -> tuple[list[Point], list[Refused]]:
    """Every point of the grid, device by device, and the computers that have none; `progress` is told how many are done.

    Raises IgnoredKeyError for an axis that no point reads, and HwModelError when there is no point at all.
    """
    study = study or Study(trace)
    partitions = [load_partition(name) for name in sweep.partitions]
    possible, refused = possible_computers(sweep)
    usages: list[tuple[Platform, ParameterUse]] = []
    for (platform, _), partition in product(possible, partitions):
        with suppress(HwModelError):  # it is refused below
            usages.append((platform, STUDY_USAGE.of(trace, partition, platform, study.cycles)))
    if usages:
        require_used(sweep.axes, usages)
    points: list[Point] = []
    first: HwModelError | None = None
    for platform, settings in possible:
        shown = {key: value for key, value in settings.items() if key not in ("pl.lanes", "pl.clock_mhz")}
        try:
            points += study.points(platform, partitions, shown)
        except HwModelError as error:
            first = first or error
            refused.append(Refused(platform.name, settings, str(error)))
        if progress is not None:
            progress(len(points) + len(partitions) * len(refused))
    if first is not None and not points:
        raise first
    return points, refused


def _flat(where: str, axes: dict[str, Any]) -> dict[str, Any]:
    """`[axes.pl] lanes = …` and `"pl.lanes" = …` are the same key, which may be there once."""
    flat: dict[str, Any] = {}
    for key, value in axes.items():
        inner = {f"{key}.{name}": item for name, item in value.items()} if is_table(value) else {key: value}
        for name, item in inner.items():
            if name in flat:
                raise SweepError(f"{where}: `axes.{name}` = {item!r}: was given as {flat[name]!r} before")
            flat[name] = item
    return flat


def _values(where: str, key: str, value: Any) -> tuple[Any, ...]:
    if not isinstance(value, list) or not value:
        raise SweepError(f"{where}: `axes.{key}` = {value!r}: must be a list of at least one value")
    values: list[Any] = value
    if key in ("device", "partition", "ordering") and not all(isinstance(item, str) for item in values):
        raise SweepError(f"{where}: `axes.{key}` = {value!r}: must be a list of names")
    if any(item in values[:k] for k, item in enumerate(values)):
        raise SweepError(f"{where}: `axes.{key}` = {value!r}: names a value twice")
    return tuple(values)


def _no_twins(sweep: Sweep, where: str) -> None:
    """Raise when two names stand for one partition or one device: its points would be counted twice."""
    for key, names, load in (
        ("partition", sweep.partitions, lambda name: load_partition(name).modules),
        ("device", sweep.devices, lambda name: load_platform(name).name),
    ):
        seen: list[Any] = []
        for name in names:
            found = load(name)
            if found in seen:
                twin = names[seen.index(found)]
                raise SweepError(f"{where}: `axes.{key}`: {name!r} is the same as {twin!r}; name it once")
            seen.append(found)
