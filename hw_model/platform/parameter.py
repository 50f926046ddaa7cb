"""One number of a platform, with where it comes from."""

from __future__ import annotations

from typing import Annotated, Generic, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

Tag = Literal["sourced", "measured", "routed", "executed", "counted", "scaled", "assumed"]
End = Literal["slow", "nominal", "fast"]
Number = TypeVar("Number", int, float, str)

# Wide enough for any computer, and so narrow that no time leaves the range of its arithmetic.
PsClock = Annotated[float, Field(ge=0.001, le=5000.0, strict=True, allow_inf_nan=False)]
PlClock = Annotated[float, Field(ge=0.001, le=1000.0, strict=True, allow_inf_nan=False)]
Duration = Annotated[float, Field(ge=0.0, le=1e9, strict=True, allow_inf_nan=False)]
Rate = Annotated[float, Field(ge=1e-6, le=1e9, strict=True, allow_inf_nan=False)]
Fraction01 = Annotated[float, Field(gt=0.0, le=1.0, strict=True, allow_inf_nan=False)]
Exponent = Annotated[float, Field(ge=1.0, le=64.0, strict=True, allow_inf_nan=False)]
Count = Annotated[int, Field(ge=0, le=10**9, strict=True)]
Units = Annotated[int, Field(ge=1, le=1024, strict=True)]
Bytes = Annotated[int, Field(ge=64, le=1 << 20, strict=True)]
Banks = Annotated[int, Field(ge=1, le=1024, strict=True), AfterValidator(lambda count: _power_of_two(count))]
Completion = Annotated[str, Field(pattern="^(interrupt|polling)$")]
PsPrice = Annotated[str, Field(pattern="^(flop_per_cycle|executed_instructions)$")]
Schedule = Annotated[str, Field(pattern="^(serial|overlapped)$")]
FabricName = Annotated[str, Field(pattern="^(xc7|ng_ultra)$")]
MicrocodeFormat = Annotated[str, Field(pattern="^(flat|compressed)$")]
StorageMemory = Annotated[str, Field(pattern="^(block_ram|ultra_ram)$")]
StorageDepth = Annotated[str, Field(pattern="^(power_of_two|exact)$")]
Parity = Annotated[str, Field(pattern="^(none|per_word)$")]
MicrocodeMemory = Annotated[str, Field(pattern="^(block_ram|ultra_ram|streamed|streamed_start)$")]


def _power_of_two(count: int) -> int:
    if count & (count - 1):
        raise ValueError(
            f"{count} is no power of two: the low bits of an address name the bank and its cluster"
        )
    return count


class Parameter(BaseModel, Generic[Number]):
    """A value whose unit is in its key, tagged with its provenance.

    `sourced`: printed by the named source; `measured`: by our own RTL or benchmark; `routed`: by place and route of our
    RTL; `executed`: counted instructions of our kernels; `counted`: fitted to clocks and instructions counted in a simulation
    of the whole chip in RTL; `scaled`: sourced, then carried to another part by a stated
    factor; `assumed`: chosen by us, and `source` says why. `low` and `high`, given together, are the ends of a band:
    a report evaluates them and prints its results as bands.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    value: Number
    tag: Tag
    source: Annotated[str, Field(min_length=1)]
    low: Number | None = None
    high: Number | None = None

    @model_validator(mode="after")
    def _ordered(self) -> Parameter[Number]:
        if self.low is None and self.high is None:
            return self
        if self.low is None or self.high is None or not self.low <= self.value <= self.high:
            raise ValueError(
                f"low = {self.low}, value = {self.value}, high = {self.high}: "
                "a band needs both ends, and low ≤ value ≤ high"
            )
        return self

    def at(self, end: End, *, more_is_faster: bool) -> Parameter[Number]:
        """This parameter moved to one end of its band (itself when it has none)."""
        if end == "nominal" or self.low is None or self.high is None:
            return self
        value = self.high if (end == "fast") == more_is_faster else self.low
        return self.model_copy(update={"value": value})
