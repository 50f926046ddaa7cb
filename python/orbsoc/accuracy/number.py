"""A published number beside the one computed here, as a row of `orbsoc reproduce`."""

from __future__ import annotations

from dataclasses import dataclass

from orbsoc.guidance.mission import BROKEN, PaperRow

AGREES = "agrees"


@dataclass(frozen=True, slots=True)
class Number:
    """`theirs` as it is printed, with as many digits; `allowed`: half a unit of its last digit, or what stands in `why`."""

    quantity: str
    source: str
    theirs: str
    ours: float
    allowed: float
    unit: str = ""
    why: str = ""

    @property
    def difference(self) -> float:
        return self.ours - float(self.theirs)

    @property
    def row(self) -> PaperRow:
        """Broken where the difference is more than what is allowed; NaN is."""
        unit = f" {self.unit}" if self.unit else ""
        agrees = abs(self.difference) <= self.allowed
        told = f"differs by {self.difference:+.1e}{unit}"
        return PaperRow(
            self.quantity, self.source, f"{self.theirs}{unit}", f"{self.ours:.12g}{unit}", AGREES if agrees else BROKEN,
            f"{told}; {self.why}" if self.why else told, f"±{self.allowed:.2g}{unit}",
        )  # fmt: skip
