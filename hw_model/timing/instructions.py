"""Executed instructions of a stage on a core, for any pattern, from counts on measured patterns.

`instructions.json` holds what ran under an emulator (scripts/record_instructions.py), `rocket.json` what ran on the
simulated chip (scripts/record_rocket.py): per measured pattern its sizes and
per stage the instructions of one run. A stage's law is a sum of costs: of each kind of operation, and of each size of the
pattern, none negative, fitted to the relative errors of the measured patterns. What the sum misses depends on how a
matrix is filled, which a pattern's counts do not say; so it is corrected by the measured patterns that are most alike:

    instructions(x) = law(x) · exp( Σ_q w_q ln(measured_q / law(q)) / (Σ_q w_q + ε) ),   w_q = exp(−|x − q|² / 2σ²)

with |x − q| between logarithms of ratios of sizes. Far from all of them the law stands alone.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .trace import Pattern, Stage

FOLDER = Path(__file__).parent
RECORD = FOLDER / "instructions.json"
SCHEMA = "orbsoc.instructions/1"
ALIKE = 0.3
"""σ: patterns whose ratios differ by a third are alike."""
ALONE = 0.01
"""ε: the weight of the law by itself."""
LEAST_RATIO = 0.05
"""Added to each ratio: below this, a share of a pattern does not tell."""
SIZE_WEIGHT = 0.3
"""Of a pattern's size, against its ratios."""


@dataclass(frozen=True, slots=True)
class Measured:
    """A pattern whose instructions were counted: where it lies among patterns, and per stage ln(measured / law)."""

    name: str
    place: tuple[float, ...]
    logarithms: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class InstructionLaw:
    """Executed instructions of the stages on one kind of core."""

    core: str
    """"Cortex-A53, NEON"."""
    provenance: str
    costs: Mapping[str, Mapping[str, float]]
    """Per stage, instructions for each feature."""
    measured: tuple[Measured, ...]

    def instructions(self, name: str, pattern: Pattern) -> float:
        """Of one run of a stage; "NAME, spared" where a core leaves out of it what no decision needs."""
        by_law = summed(self.costs[name], features(pattern.stages[name.partition(",")[0]], pattern))
        here = place(pattern)
        weight = correction = 0.0
        for known in self.measured:
            if name in known.logarithms:
                alike = math.exp(-(math.dist(here, known.place) ** 2) / (2.0 * ALIKE**2))
                weight += alike
                correction += alike * known.logarithms[name]
        return by_law * math.exp(correction / (weight + ALONE))


def can_be_counted(pattern: Pattern) -> bool:
    """Whether a pattern has the sizes that the law charges for: that of a trace which the solver has recorded has."""
    return all(size in pattern.buffers for size in ("raw_p", "raw_a", "raw_g", "factor_l"))


def words_of(stage: Stage, pattern: Pattern) -> int:
    """Words of the buffers that a stage reads or writes."""
    return sum(pattern.buffers[name] for name in {*stage.reads, *stage.writes})


def summed(costs: Mapping[str, float], found: Mapping[str, float]) -> float:
    """The law by itself."""
    return math.fsum(cost * found[feature] for feature, cost in costs.items())


def features(stage: Stage, pattern: Pattern) -> dict[str, float]:
    """What the law of a stage may charge for: its operations and the pattern's sizes."""
    count, buffers = stage.operations, pattern.buffers
    multiply_adds = count["mul_add"] + count["mul_sub"]
    unknowns = pattern.n + pattern.p + pattern.m
    found: dict[str, float] = {
        "run": 1,
        "multiply_add": multiply_adds,
        "mul": count["mul"],
        "add": count["add"],
        "sub": count["sub"],
        "div_sqrt": count["div"] + count["sqrt"],
        "other": sum(count[code] for code in ("neg", "abs", "min", "max", "compare", "and", "select")),
        "n": pattern.n,
        "p": pattern.p,
        "linear_rows": pattern.cones.l,
        "cones": len(pattern.cones.q),
        "cone_rows": sum(pattern.cones.q),
        "nonzeros_p": buffers["raw_p"],
        "nonzeros_a": buffers["raw_a"],
        "nonzeros_g": buffers["raw_g"],
    }
    found |= {"unknowns": unknowns, "words": words_of(stage, pattern)}
    if stage.module == "statistics":  # a pass over x, y or z has a cost of its own, unless it is empty
        found["vectors"] = sum(size > 0 for size in (pattern.n, pattern.p, pattern.m))
    if stage.module in ("factorization", "linear_solve", "matrix_update"):
        found |= {
            "nonzeros_kkt": pattern.nnz_kkt,
            "nonzeros_l": pattern.nnz_l,
            "stored_l": buffers["factor_l"],
        }
    if stage.module == "factorization":
        found |= {
            "sqrt(multiply_add·mul)": math.sqrt(multiply_adds * count["mul"]),
            "sqrt(multiply_add·unknowns)": math.sqrt(multiply_adds * unknowns),
            "sqrt(stored_l·unknowns)": math.sqrt(buffers["factor_l"] * unknowns),
        }
    return found


def place(pattern: Pattern) -> tuple[float, ...]:
    """Where a pattern lies among patterns: logarithms of the ratios of its sizes, and of its size."""
    unknowns, buffers = pattern.n + pattern.p + pattern.m, pattern.buffers
    ratios = (
        pattern.p / pattern.n,
        pattern.m / pattern.n,
        (pattern.cones.l + 1) / (pattern.m + 1),
        (len(pattern.cones.q) + 1) / (pattern.m + 1),
        (buffers["raw_a"] + 1) / unknowns,
        (buffers["raw_g"] + 1) / unknowns,
        (buffers["raw_p"] + 1) / unknowns,
        pattern.nnz_kkt / unknowns,
        pattern.nnz_l / unknowns,
        buffers["factor_l"] / max(pattern.nnz_l, 1),
    )
    return (*(math.log(LEAST_RATIO + ratio) for ratio in ratios), SIZE_WEIGHT * math.log(unknowns))


@cache
def recorded(name: str = "instructions") -> InstructionLaw:
    """The law of a record of this folder."""
    return law_of(json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8")))


def law_of(record: Mapping[str, Any]) -> InstructionLaw:
    """The law of a record's entries."""
    measured = tuple(
        Measured(row["name"], tuple(row["place"]), row["logarithms"]) for row in record["measured"]
    )
    provenance = f"{record['core']}: executed under {record['emulator']}, {record['compiler']}, commit {record['commit']}"
    return InstructionLaw(record["core"], provenance, record["costs"], measured)
