"""A program that breaks every rule of a schedule: a positive control for the RTL's checks.

The segment `control` breaks every rule of docs/pl-machine.md at least once. An engine whose checks were left out, or of which one
cannot fire, is found by it; nothing else that it leaves is of interest.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

RULES = (
    "read_conflict",
    "read_pending",
    "write_pending",
    "result_conflict",
    "write_conflict",
    "divider_busy",
    "read_unwritten",
    "unknown_operation",
)
_HELD_UP = {"read_pending", "result_conflict", "divider_busy"}
"""What the in-order sequencer never lets through, whatever it is given."""
_MOVE, _MUL, _UNKNOWN = 1, 4, 15
_DIV, _SQRT = 1, 2
_FULL = 3
"""Mode of a compressed field that comes with the item."""
_WORDS = 64
_ASSERTED = re.compile(r"^assert (\w+) ", re.MULTILINE)
_CONFIG = re.compile(
    r"^config fp (\d+) lanes (\d+) dividers (\d+) banks (\d+) clusters (\d+) address_bits (\d+)$",
    re.MULTILINE,
)
_FORMAT = re.compile(r"^format (\w+)$", re.MULTILINE)
_FIRST_LINE = re.compile(r"^microcode \d+\n(\w+)$", re.MULTILINE)
_TEMPLATE_BITS = re.compile(r"^localparam int TEMPLATE_BITS = (\d+);", re.MULTILINE)
_HEADERS_AHEAD = re.compile(r"^localparam int HEADERS_AHEAD = (\d+);", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class _Issue:
    """An operation of a lane or of the divider; it reads `b` if it is not 0."""

    code: int
    a: int
    to: int
    b: int = 0


@dataclass(frozen=True, slots=True)
class _Word:
    lanes: Sequence[_Issue]
    """Of the first lanes; the others have none."""
    divider: _Issue | None = None


@dataclass(slots=True)
class _Bits:
    """Bits, least significant first."""

    value: int = 0
    length: int = 0

    def put(self, value: int, length: int) -> None:
        self.value |= value << self.length
        self.length += length


@dataclass(frozen=True, slots=True)
class Bench:
    """What a control needs to know of an engine: it is in the head of any case for it."""

    fp: int
    lanes: int
    dividers: int
    banks: int
    clusters: int
    address_bits: int
    format: str
    line_bits: int
    template_bits: int
    headers_ahead: int

    @classmethod
    def of(cls, case: str, rtl: Path) -> Bench:
        """That of a case, and of the RTL's folder for the bits of a template's number and how far headers run ahead.

        Raises ValueError if either does not say.
        """
        found = [pattern.search(case) for pattern in (_CONFIG, _FORMAT, _FIRST_LINE)]
        config, form, line = found
        parameters = (rtl / "engine.svh").read_text(encoding="utf-8")
        bits, ahead = _TEMPLATE_BITS.search(parameters), _HEADERS_AHEAD.search(parameters)
        if config is None or form is None or line is None or bits is None or ahead is None:
            raise ValueError(
                "a case without config, format or microcode, or RTL without TEMPLATE_BITS or HEADERS_AHEAD"
            )
        fp, lanes, dividers, banks, clusters, address_bits = map(int, config.groups())
        widths = (4 * len(line[1]), int(bits[1]), int(ahead[1]))
        return cls(fp, lanes, dividers, banks, clusters, address_bits, form[1], *widths)

    @property
    def rules(self) -> frozenset[str]:
        """Those that the control breaks here: all, but for what the in-order sequencer holds up."""
        if self.format != "in_order":
            return frozenset(RULES)
        # Two results meet at a bank only if one word issues both.
        held_up = _HELD_UP if self.lanes > 1 else _HELD_UP | {"write_conflict"}
        return frozenset(RULES) - held_up


def control_case(bench: Bench) -> str:
    """The case with the one segment."""
    words = _words(bench)
    templates: list[int] = []
    if bench.format == "compressed":
        templates, code = _compressed(bench, words)
    else:
        code = [_flat(bench, word) | (number == len(words)) for number, word in enumerate(words, start=1)]
    number = 1 << (bench.fp - 2)
    lines = [
        "orbsoc-pl-case 1",
        f"config fp {bench.fp} lanes {bench.lanes} dividers {bench.dividers} banks {bench.banks}"
        f" clusters {bench.clusters} address_bits {bench.address_bits}",
        f"format {bench.format}",
        *([f"templates {len(templates)}", *(f"{template:x}" for template in templates)] if templates else []),
        f"microcode {len(code)}",
        *(f"{word:x}" for word in code),
        f"run control start 0 words {len(code)} cycles {_WORDS}",
        *(["gaps seed 1 level 0"] if bench.format == "in_order" else []),
        "memory 2",
        f"{_X:x} {number:x}",
        f"{_row(bench, 4):x} {number:x}",
        "expect 0",
        "end",
    ]
    return "\n".join([*lines, ""])


def silent_rules(bench: Bench, answer: str) -> list[str]:
    """Rules that the control broke, and of which the harness's answer says nothing."""
    asserted = set(_ASSERTED.findall(answer))
    return [rule for rule in RULES if rule in bench.rules and rule not in asserted]


_X, _UNWRITTEN, _TO = 0, 1, 3


def _row(bench: Bench, row: int) -> int:
    """A word of the same bank as `_X`."""
    return _X + row * bench.banks


def _words(bench: Bench) -> list[_Word]:
    """Results without end into one bank, and one of each other fault. No latency is needed to know that they meet."""
    other = _row(bench, 4)
    product, move = _Issue(_MUL, other, _TO, b=other), _Issue(_MOVE, _X, _TO)
    beside = [_Issue(_MOVE, _X, _TO + bench.banks)] if bench.lanes > 1 else []
    first = [
        _Word([move], _Issue(_DIV, other, _TO, b=other)),  # two rows of a bank; two results for one word
        _Word([product], _Issue(_SQRT, other, _TO)),  # a divider that is busy
        _Word([_Issue(_MOVE, _UNWRITTEN, _TO)]),
        _Word([_Issue(_UNKNOWN, _X, _TO)]),
        _Word([_Issue(_MOVE, _TO, _TO), *beside]),  # reads what is on its way; two lanes at one bank
    ]
    half = _WORDS // 2
    return [*first, *[_Word([product])] * (half - len(first)), *[_Word([move])] * half, _Word([move])]


def _flat(bench: Bench, word: _Word) -> int:
    """Without its last bit."""
    a, place, code = bench.address_bits, 1, 0
    for lane in range(bench.lanes):
        if lane < len(word.lanes):
            issue = word.lanes[lane]
            code |= (issue.a | issue.b << a | issue.to << 3 * a | issue.code << 4 * a) << place
        place += 4 * a + 4
    if word.divider is not None:
        issue = word.divider
        code |= (issue.a | issue.b << a | issue.to << 2 * a | issue.code << 3 * a) << place
    return code


def _compressed(bench: Bench, words: Sequence[_Word]) -> tuple[list[int], list[int]]:
    """Templates and lines; every word names the templates of all lanes, and every address comes in full."""
    a, templates = bench.address_bits, [0]
    headers, payloads = [], [_Bits() for _ in range(bench.headers_ahead)]
    for number, word in enumerate(words):
        header, payload = _Bits(), _Bits()
        header.put(3 if number == len(words) - 1 else 1, 2)
        header.put((1 << bench.lanes) - 1, bench.lanes)
        for lane in range(bench.lanes):
            template = _template(word.lanes[lane]) if lane < len(word.lanes) else 0
            if template not in templates:
                templates.append(template)
            header.put(templates.index(template), bench.template_bits)
        header.put(0 if word.divider is None else word.divider.code, 2)
        header.put(0, 2 * (bench.dividers - 1))
        for issue in [*word.lanes, *([word.divider] if word.divider else [])]:
            for address in (issue.a, *([issue.b] if issue.b else []), issue.to):
                payload.put(address, a)
        headers.append(header)
        payloads.append(payload)
    headers += [_Bits(0, 2)] * bench.headers_ahead
    stream = _Bits()
    for pair in zip(headers, payloads, strict=True):
        for part in pair:
            stream.put(part.value, part.length)
    mask = (1 << bench.line_bits) - 1
    lines = range(-(-stream.length // bench.line_bits))
    return templates, [stream.value >> line * bench.line_bits & mask for line in lines]


def _template(issue: _Issue) -> int:
    """All fields that are read come with the item; c is not."""
    return issue.code | _FULL << 4 | (_FULL << 6 if issue.b else 0) | _FULL << 10
