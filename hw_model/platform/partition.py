"""Which modules run on the PL, who controls them, and where their streams end. A partition never changes a number that the solver computes."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, Self

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from hw_model.errors import PartitionError, describe
from hw_model.vocabulary import PL_MODULES, Module, PlModule, Side

from .data_file import Table, is_table, read, shipped

BEST = "best"
"""In place of a name: the fastest partition of a run that fits, which `hw_model.report.best` finds."""


class Partition(BaseModel):
    """A side for each of the seven modules; the PS's own tasks stay on the PS, always.

    `control`: whether the PS launches every segment ("ps"), or the PL's operation control runs whole attempts ("pl",
    resident control, which needs all modules on the PL). `streams`: whether a segment ends with its stage ("stage"), or an
    iteration's stages share streams up to the next decision or stage of the PS ("iteration").
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    description: str = ""
    modules: dict[PlModule, Side]
    control: Side = "ps"
    streams: Literal["stage", "iteration"] = "stage"

    @model_validator(mode="after")
    def _resident(self) -> Self:
        on_ps = [name for name, side in self.modules.items() if side == "ps"]
        if self.control == "pl" and on_ps:
            raise ValueError(
                f'`control` = "pl": needs every module on the PL; on the PS is {", ".join(on_ps)}'
            )
        return self

    @property
    def key(self) -> tuple[str, ...]:
        """What tells two partitions apart, whatever their names."""
        return (*(self.modules[name] for name in PL_MODULES), self.control, self.streams)

    def side(self, module: Module) -> Side:
        """Where the stages of `module` run."""
        if module == "joined":
            return "pl"
        return "ps" if module == "ps" else self.modules[module]

    @property
    def uses_pl(self) -> bool:
        """Whether any module runs on the PL."""
        return "pl" in self.modules.values()


def partition_names() -> list[str]:
    """Names of the partitions that ship."""
    return shipped("partitions")


def load_partition(name_or_path: str | Path) -> Partition:
    """A shipped partition by name ("paper"), a TOML file, or modules on the PL joined by + ("factorization+cone_ops").

    Raises PartitionError naming the key, its value and what is allowed.
    """
    named = str(name_or_path).split("+")
    if len(named) > 1 or named[0] in PL_MODULES:
        return on_pl(*named)
    if str(name_or_path) == BEST:
        raise PartitionError(
            f"partition {BEST!r} is chosen for one run on one platform, and there is none here; name a partition"
            " (`orbsoc hw partition` prices all)"
        )
    raw, where = read("partition", "partitions", name_or_path, PartitionError)
    return parse_partition(raw, where)


def on_pl(*modules: str) -> Partition:
    """The partition with exactly these modules on the PL; PartitionError for one that does not exist."""
    for name in modules:
        if name not in PL_MODULES:
            raise PartitionError(f"partition: no module {name!r}; allowed: {', '.join(PL_MODULES)}")
        if modules.count(name) > 1:
            raise PartitionError(f"partition {'+'.join(modules)!r}: names {name!r} twice; name it once")
    sides = {name: "pl" if name in modules else "ps" for name in PL_MODULES}
    words = "+".join(name for name in PL_MODULES if name in modules)
    return parse_partition({"name": words or "all_ps", "modules": sides})


def all_partitions(*, programs: bool = False) -> list[Partition]:
    """All 2⁷ under the control of the PS, stage by stage, the shipped ones under their names.

    `programs`: then also the shipped ones with streams of several stages or with resident control.
    """
    known = {partition.key: partition for partition in map(load_partition, partition_names())}
    subsets = (
        [name for k, name in enumerate(PL_MODULES) if bits >> k & 1] for bits in range(2 ** len(PL_MODULES))
    )
    partitions = [on_pl(*subset) for subset in subsets]
    plain = {partition.key: known.get(partition.key, partition) for partition in partitions}
    others = [partition for key, partition in known.items() if key not in plain] if programs else []
    return [*plain.values(), *others]


def parse_partition(raw: Table, where: str = "partition") -> Partition:
    """A partition from plain data with the keys of a partition file."""
    modules = raw.get("modules")
    if is_table(modules):
        # A file from before the seventh module leaves it where it was: on the PS.
        raw = raw | {"modules": {"statistics": "ps"} | modules}
        _check_modules(modules, where)
    try:
        return Partition.model_validate(raw)
    except ValidationError as error:
        raise PartitionError(f"{where}: {describe(error, Partition)}") from error


def _check_modules(modules: Table, where: str) -> None:
    allowed = ", ".join(PL_MODULES)
    for name, side in modules.items():
        if name == "ps":
            raise PartitionError(
                f"{where}: `modules.ps` = {side!r}: the PS's own tasks cannot be moved; a partition places {allowed}"
            )
        if name not in PL_MODULES:
            raise PartitionError(f"{where}: `modules.{name}` = {side!r}: no such module; allowed: {allowed}")
    missing = [name for name in PL_MODULES if name not in modules and name != "statistics"]
    if missing:
        raise PartitionError(f'{where}: `modules` lacks {", ".join(missing)}: each needs "ps" or "pl"')
