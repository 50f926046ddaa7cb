"""The answer to a mission as data: one line a question, one word a line; the worst word rules the exit code.

Console, report, `plan.json` and notebook print the same lines. A mission answers *Answer*, *Optimum*, *Engine*,
*Safety*, *Option* and *Flights*; the run of the plan adds the second solver's check, *Deadline* and *Computer*.
"""

from __future__ import annotations

import enum
import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from html import escape
from shlex import quote
from textwrap import wrap
from typing import Any

from .claims import Claim

WIDTH = 100
"""Characters of a printed line."""
MARGIN = 22
"""Of them for question and word; a line that is too long goes on below its figure."""
ROOM = WIDTH - MARGIN
"""Of them for figure, limit and evidence."""
MOST_LINES = 8
"""Of a printed verdict."""


def shortened(text: str, room: int = 2 * ROOM) -> str:
    """The first whole clauses of a sentence made elsewhere that fit into two lines; all of it where none do.

    >>> shortened("the plane is tilted by 0.3° (some 41.2 m/s of velocity out of the plane)", 40)
    'the plane is tilted by 0.3°'
    """
    ends = [found.start() for found in re.finditer(r"[;.] | \(", text) if found.start() <= room]
    return text if len(text) <= room or not ends else text[: ends[-1]]


def set_options(settings: Mapping[str, Any]) -> str:
    """Values by key as options of `orbsoc plan`, as a shell takes them.

    >>> set_options({"burn.ignition": "free", "slot": [1, 2]})
    "--set burn.ignition=free --set 'slot=[1, 2]'"
    """
    words = {key: value if isinstance(value, str) else json.dumps(value) for key, value in settings.items()}
    return " ".join(f"--set {quote(f'{key}={word}')}" for key, word in words.items())


class Level(enum.IntEnum):
    """What a word means for the exit code."""

    GOOD = 0
    """The question is answered as one would wish."""
    OPEN = 1
    """Told, and not decided: the exit code stays 0."""
    BAD = 2
    """What was asked for does not hold: the exit code is 1."""


class Question(enum.Enum):
    """What is asked, in the order in which it is printed."""

    ANSWER = "Answer"
    OPTION = "Option"
    OPTIMUM = "Optimum"
    ENGINE = "Engine"
    SAFETY = "Safety"
    FLIGHTS = "Flights"
    CHECK = "Check"
    DEADLINE = "Deadline"
    COMPUTER = "Computer"


class Word(enum.Enum):
    """The one word of a line: what it says and its level."""

    VERIFIED = "VERIFIED", Level.GOOD
    NOT_VERIFIED = "NOT VERIFIED", Level.BAD
    INFEASIBLE = "INFEASIBLE", Level.BAD
    NOT_FOUND = "NOT FOUND", Level.BAD
    FAILED = "NO ANSWER", Level.BAD
    INTERRUPTED = "INTERRUPTED", Level.BAD
    CHEAPER = "CHEAPER", Level.OPEN
    POSSIBLE = "POSSIBLE", Level.OPEN
    """Another setting reaches what was asked for."""
    PROVED = "PROVED", Level.GOOD
    BOUND = "BOUND", Level.GOOD
    BEST_FOUND = "BEST FOUND", Level.OPEN
    SAMPLED = "SAMPLED", Level.OPEN
    ENOUGH = "ENOUGH", Level.GOOD
    TOO_WEAK = "TOO WEAK", Level.BAD
    SAFE = "SAFE", Level.GOOD
    PARTLY = "PARTLY", Level.OPEN
    """Safe as the scenario asked, and not in a stronger sense that is told."""
    NOT_SAFE = "NOT SAFE", Level.BAD
    NOT_ASKED = "NOT ASKED", Level.OPEN
    MET = "MET", Level.GOOD
    MISSED = "MISSED", Level.BAD
    INSTEAD = "INSTEAD", Level.OPEN
    """What was asked for is out of reach, and what was chosen in its place was reached."""
    AGREES = "AGREES", Level.GOOD
    DISAGREES = "DISAGREES", Level.BAD
    PASS = "PASS", Level.GOOD
    MARGINAL = "MARGINAL", Level.OPEN
    FAIL = "FAIL", Level.BAD
    NOT_JUDGED = "NOT JUDGED", Level.OPEN
    MODELLED = "MODELLED", Level.GOOD
    NOT_NEEDED = "NOT NEEDED", Level.GOOD
    DOES_NOT_FIT = "DOES NOT FIT", Level.OPEN
    OTHER_BITS = "OTHER BITS", Level.BAD
    """The scheduled solves do not return the bits of the native ones."""

    def __init__(self, text: str, level: Level) -> None:
        self.text = text
        self.level = level


@dataclass(frozen=True, slots=True)
class VerdictLine:
    """One answered question. `figure` is the number that answers it, `limit` what it is held against, `evidence` what
    was checked; each is a short phrase in plain text. `claim` says what stands behind words like *fewest*."""

    question: Question
    word: Word
    figure: str
    limit: str = ""
    evidence: str = ""
    claim: Claim | None = None
    settings: Mapping[str, str] = field(default_factory=dict)
    """Of an option: the keys of the scenario to set."""
    command: str = ""
    """What sets them, behind all that plans the scenario where its file is known."""

    @classmethod
    def of_claim(cls, question: Question, claim: Claim, limit: str = "", evidence: str = "") -> VerdictLine:
        """The line that a claim makes: its kind is the word, its words the figure."""
        return cls(question, Word[claim.kind.name], claim.claim, limit, evidence, claim)

    @property
    def text(self) -> str:
        """Figure, limit and evidence in a row."""
        text = f"{self.figure} (allowed {self.limit})" if self.limit else self.figure
        return "; ".join(filter(None, (text, self.evidence)))

    def __str__(self) -> str:
        """The line as it is printed, in as many of `WIDTH` characters as it takes; a command has its own."""
        head = f"{self.question.value:<9}{self.word.text:<13}"
        bound = re.sub(r"(?<=\d) (?=\S)", "\N{NO-BREAK SPACE}", self.text)  # a number stays beside its unit
        lines = wrap(
            bound, WIDTH, initial_indent=head, subsequent_indent=" " * MARGIN, break_on_hyphens=False
        )
        if self.settings:
            fits = len(self.command) + 9 <= WIDTH
            lines.append(" " * 9 + (self.command if self.command and fits else set_options(self.settings)))
        return "\n".join(lines).replace("\N{NO-BREAK SPACE}", " ") or head.rstrip()

    def to_dict(self) -> dict[str, Any]:
        """A row of `verdict` in plan.json."""
        return {
            "question": self.question.value,
            "word": self.word.text,
            "figure": self.figure,
            "limit": self.limit,
            "evidence": self.evidence,
            "claim": self.claim and self.claim.to_dict(),
            "command": self.command or set_options(self.settings),
        }


@dataclass(frozen=True, slots=True)
class Verdict:
    """All answered questions, each at most once but for options, in the order of `Question`."""

    lines: tuple[VerdictLine, ...]

    @classmethod
    def of(cls, lines: Iterable[VerdictLine | None]) -> Verdict:
        """The lines that there are, in order."""
        order = list(Question)
        return cls(tuple(sorted(filter(None, lines), key=lambda line: order.index(line.question))))

    def with_lines(self, lines: Iterable[VerdictLine | None]) -> Verdict:
        """These and more."""
        return Verdict.of([*self.lines, *lines])

    @property
    def level(self) -> Level:
        """The worst of all lines."""
        return max((line.word.level for line in self.lines), default=Level.GOOD)

    @property
    def succeeded(self) -> bool:
        """Whether nothing that was asked for fails."""
        return self.level < Level.BAD

    def word(self, question: Question) -> Word | None:
        """The word that answers a question; None where it was not put."""
        return next((line.word for line in self.lines if line.question is question), None)

    def of_file(self, path: str, changes: Mapping[str, Any]) -> Verdict:
        """The same with options told as whole commands, for a scenario file of which some keys were changed."""
        plan = f"orbsoc plan {quote(path)}"
        return Verdict(
            tuple(
                replace(line, command=f"{plan} {set_options({**changes, **line.settings})}")
                if line.settings
                else line
                for line in self.lines
            )
        )

    def __str__(self) -> str:
        """The table as the console prints it, one or two lines a question; the last evidence gives way to `MOST_LINES`."""
        lines = list(self.lines)
        for k in reversed(range(len(lines))):
            if sum(str(line).count("\n") + 1 for line in lines) <= MOST_LINES:
                break
            lines[k] = replace(lines[k], evidence="")
        return "\n".join(map(str, lines))

    def _repr_html_(self) -> str:
        cells = (
            f"<tr><th>{line.question.value}</th><td><b>{escape(line.word.text)}</b></td><td>{escape(line.figure)}</td>"
            f"<td>{escape(line.limit)}</td><td>{escape('; '.join(filter(None, (line.evidence, line.command or set_options(line.settings)))))}</td></tr>"
            for line in self.lines
        )
        return f"<table>{''.join(cells)}</table>"

    def to_list(self) -> list[dict[str, Any]]:
        """`verdict` of plan.json."""
        return [line.to_dict() for line in self.lines]
