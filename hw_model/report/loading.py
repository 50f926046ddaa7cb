"""What loading programs takes, for a report: once a boot, and once a plan whose patterns the device cannot hold together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hw_model.timing.programs import boot_picoseconds, plan_picoseconds
from hw_model.vocabulary import PICOSECONDS_PER_MS, count_of

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform
    from hw_model.timing.programs import Programs


@dataclass(frozen=True, slots=True)
class Loading:
    """Programs of one partition on one platform, nominally. The time of a plan is part of the run's, that of a boot is not."""

    patterns: int
    resident: int
    """Patterns whose microcode stays."""
    program_bytes: int
    """Of the largest program's microcode, as it crosses."""
    boot_bytes: int
    boot_ms: float
    plan_loads: int
    """Times that a plan writes microcode."""
    plan_bytes: int
    plan_ms: float
    """Its changes of the pattern: microcode, where it did not stay, and tables."""

    @property
    def words(self) -> str:
        """A line of a report."""
        if not self.patterns:
            return "no program to load: nothing is on the PL"
        boot = f"{_mb(self.boot_bytes)} once a boot, {self.boot_ms:.3f} ms beside the run"
        if self.patterns == 1:
            return f"modelled loading: one program, {boot}"
        what = count_of(self.patterns, "program")
        if self.resident == self.patterns:
            return (
                f"modelled loading: {what} that stay together, {boot};"
                f" tables at each change of the pattern, {self.plan_ms:.3f} ms of the run"
            )
        stay = f"{self.resident} of them stay: {boot}" if self.resident else "none of them stays"
        return (
            f"modelled loading: {what}, {stay}; {count_of(self.plan_loads, 'load')} a plan, {_mb(self.plan_bytes)},"
            f" {self.plan_ms:.3f} ms of the run"
        )

    def row(self) -> dict[str, Any]:
        """Columns of a table."""
        return {
            "programs": self.patterns, "programs_resident": self.resident, "boot_load_ms": self.boot_ms,
            "plan_loads": self.plan_loads, "plan_load_mb": self.plan_bytes / 1e6, "plan_load_ms": self.plan_ms,
        }  # fmt: skip


def loading(platform: Platform, programs: Programs) -> Loading:
    """Of the programs of a budget."""
    return Loading(
        patterns=len(programs.each),
        resident=len(programs.resident),
        program_bytes=max((program.microcode_bytes for program in programs.each), default=0),
        boot_bytes=programs.boot_bytes,
        boot_ms=boot_picoseconds(platform, programs) / PICOSECONDS_PER_MS,
        plan_loads=programs.loads,
        plan_bytes=programs.plan_bytes,
        plan_ms=plan_picoseconds(platform, programs) / PICOSECONDS_PER_MS,
    )


def _mb(size_bytes: int) -> str:
    return f"{size_bytes / 1e6:.2f} MB"
