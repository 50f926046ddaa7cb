"""The words that traces, partitions and platforms share, and how time is counted.

Time is an integer number of picoseconds (`_picoseconds`), so that sums are exact and "the causes add up to
the makespan" is an equality. "ps" always means the processing system, never picoseconds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Final, Literal, get_args

Side = Literal["ps", "pl"]
PlModule = Literal[
    "matrix_update", "matrix_scaling", "factorization", "linear_solve", "cone_ops", "line_search",
    "statistics",
]  # fmt: skip
Module = Literal["ps", PlModule, "joined"]
"""`ps`: the processing system's own tasks, which no partition moves; `joined`: stages of several modules as one stream."""
Datapath = Literal["f64", "f32"]
Opcode = Literal[
    "move", "neg", "abs", "mul", "add", "sub", "mul_add", "mul_sub", "div", "sqrt", "min", "max",
    "compare", "and", "select",
]  # fmt: skip
PlCause = Literal["issue", "dependency", "bank", "divider", "write_port", "fetch", "drain"]
Cause = Literal["ps", PlCause, "cache", "link", "interrupt"]

PL_MODULES: Final[tuple[PlModule, ...]] = get_args(PlModule)
MODULES: Final[tuple[Module, ...]] = ("ps", *get_args(PlModule))
ACCOUNTS: Final[tuple[Module, ...]] = (*MODULES, "joined")
"""Where time is accounted for: a stage belongs to one module, a stream may not."""
OPCODES: Final[tuple[Opcode, ...]] = get_args(Opcode)
PL_CAUSES: Final[tuple[PlCause, ...]] = get_args(PlCause)
CAUSES: Final[tuple[Cause, ...]] = get_args(Cause)
PICOSECONDS_PER_MS: Final = 10**9
WORD_BYTES: Final[dict[Datapath, int]] = {"f64": 8, "f32": 4}


def count_of(number: int, noun: str, several: str = "") -> str:
    """A number of things: "1 lane", "4 lanes"; `several` where an s does not do."""
    return f"{number} {noun}" if number == 1 else f"{number} {several or f'{noun}s'}"


def by_place(causes: Mapping[Cause, int]) -> dict[str, int]:
    """Causes in four groups: PS, PL, link (with the cache maintenance that it needs) and interrupt."""
    return {
        "PS": causes["ps"],
        "PL": sum(causes[cause] for cause in PL_CAUSES),
        "link": causes["link"] + causes["cache"],
        "interrupt": causes["interrupt"],
    }


def picoseconds_of_cycles(parts: Sequence[int], clock_mhz: float) -> list[int]:
    """Durations of consecutive parts, each given in whole clock cycles, in picoseconds.

    The end of each part is rounded, not its length, so the parts add up to the rounded total
    whatever the clock: 3 cycles at 150 MHz are 20 000 ps as one part and 6667 + 6666 + 6667 as three.
    """
    picoseconds_per_cycle = Fraction(10**6) / Fraction(clock_mhz)
    ends = [0]
    cycles = 0
    for part in parts:
        cycles += part
        ends.append(int(cycles * picoseconds_per_cycle + Fraction(1, 2)))
    return [end - start for start, end in pairwise(ends)]


def picoseconds_of_ns(duration_ns: float) -> int:
    """A duration in nanoseconds, rounded to a whole number of picoseconds."""
    return round(duration_ns * 1000.0)
