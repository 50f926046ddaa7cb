"""What a plan claims, as data: the class it holds for, what was checked, and how far it may be off.

A verdict line that says *fewest*, *optimum*, *minimum*, *infeasible*, *shortest*, *all time* or *proved* carries one.
`docs/claims.md` is the table of all claims.
"""

from __future__ import annotations

import enum
import re
from dataclasses import dataclass
from typing import Any

REFUSED = ("fewest", "optimum", "minimum", "infeasible", "shortest", "all time", "proved")
"""Words that no verdict line says without a claim."""


class Kind(enum.Enum):
    """How much stands behind a claim."""

    PROVED = "proved"
    """For every programme of the class."""
    BOUND = "bound"
    """For every programme of the class, with a gap to what was found."""
    BEST_FOUND = "best found"
    """Of what was tried; `evidence` says what that is."""
    SAMPLED = "sampled"
    """At samples; `evidence` says how dense, and what holds between them."""


@dataclass(frozen=True, slots=True)
class Claim:
    """One claim: `claim` in words, the class of programmes `class_`, what was checked, and the gap, relative."""

    kind: Kind
    claim: str
    class_: str
    evidence: str
    gap: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """`claim` of a row of `verdict` in plan.json."""
        return {
            "kind": self.kind.value,
            "claim": self.claim,
            "class": self.class_,
            "evidence": self.evidence,
            "gap": self.gap,
        }


def refused_words(text: str) -> tuple[str, ...]:
    """The words of `REFUSED` that a text says.

    >>> refused_words("Optimum  PROVED  5 pulses")
    ('optimum', 'proved')
    """
    return tuple(word for word in REFUSED if re.search(rf"\b{word}\b", text, re.IGNORECASE))
