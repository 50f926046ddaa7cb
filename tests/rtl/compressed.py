"""Compressed microcode of docs/pl-machine.md, written and timed from the contract alone.

`compress` chooses at random among the modes that are right for a field: the decoder must follow every one of them,
whatever the product's own compression prefers.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass, field

from tests.rtl.machine import DIVIDER_OPS, LANE_OPS, READS_B, READS_C, Machine, Op, Slot

KEEP, STEP, NEW_STEP, FULL = range(4)
EMPTY_MOST = 256


@dataclass
class Bits:
    """Bits, least significant first."""

    value: int = 0
    length: int = 0

    def put(self, value: int, length: int) -> None:
        assert 0 <= value < 1 << length
        self.value |= value << self.length
        self.length += length


@dataclass
class LaneState:
    """What the decoder keeps for a lane: template, and of each field address and step."""

    template: int = 0
    kept: list[int] = field(default_factory=lambda: [0] * 4)
    step: list[int] = field(default_factory=lambda: [0] * 4)


@dataclass
class Compressor:
    """One program: the templates that its segments share."""

    machine: Machine
    draw: random.Random
    templates: list[int] = field(default_factory=lambda: [0])

    @property
    def line_bits(self) -> int:
        machine = self.machine
        a_bits = machine.address_bits
        item = 2 + machine.lanes * (4 * a_bits + 8) + machine.dividers * (3 * a_bits + 2)
        return 32 << (max(machine.lanes, -(-item // 96)) - 1).bit_length()

    def segment(self, slots: Sequence[Slot], words: int) -> tuple[list[int], int]:
        """Lines, and the frozen cycles of their delivery."""
        by_time: dict[int, list[Slot]] = {}
        for slot in slots:
            by_time.setdefault(slot.time, []).append(slot)
        lanes = [LaneState() for _ in range(self.machine.lanes)]
        items: list[tuple[Bits, Bits, int]] = []
        time = 0
        while time < words:
            run = next((n for n in range(EMPTY_MOST) if time + n in by_time), EMPTY_MOST)
            if run and time + run < words:
                item = Bits()
                item.put(2, 2)
                item.put(run - 1, 8)
                items.append((item, Bits(), run))
                time += run
                continue
            items.append((*self._word(by_time.get(time, []), lanes, time == words - 1), 1))
            time += 1
        ahead = self.machine.numbers["HEADERS_AHEAD"]
        headers = [header for header, _, _ in items] + [Bits(0, 2)] * ahead
        payloads = [Bits()] * ahead + [payload for _, payload, _ in items]
        stream = Bits()
        for header, payload in zip(headers, payloads, strict=True):
            stream.put(header.value, header.length)
            stream.put(payload.value, payload.length)
        count = -(-stream.length // self.line_bits)
        lines = [stream.value >> i * self.line_bits & (1 << self.line_bits) - 1 for i in range(count)]
        lengths = [header.length + payload.length for header, payload in zip(headers, payloads, strict=True)]
        return lines, self._frozen(lengths, [0] * ahead + [run for _, _, run in items])

    def _word(self, slots: list[Slot], lanes: list[LaneState], last: bool) -> tuple[Bits, Bits]:
        numbers, a_bits = self.machine.numbers, self.machine.address_bits
        payload, mask, changed = Bits(), 0, []
        ops = {slot.unit: slot.op for slot in slots}
        for lane, state in enumerate(lanes):
            op = ops.get(lane)
            template = 0 if op is None else self._template(op, state)
            if template != state.template:
                mask |= 1 << lane
                changed.append(template)
                state.template = template
            if op is not None:
                self._fields(op, state, payload)
        dividers = [ops.get(self.machine.lanes + d) for d in range(self.machine.dividers)]
        for op in dividers:
            if op is not None:
                for address in [*op.reads, op.to]:
                    payload.put(address, a_bits)
        item = Bits()
        item.put(3 if last else int(bool(mask) or any(dividers)), 2)
        if item.value:
            item.put(mask, self.machine.lanes)
            for template in changed:
                item.put(template, numbers["TEMPLATE_BITS"])
            for op in dividers:
                item.put(0 if op is None else DIVIDER_OPS.index(op.name), 2)
        return item, payload

    def _template(self, op: Op, state: LaneState) -> int:
        """A template that is right for the operation: a random one if there is room, else one of the table."""
        allowed = self._allowed(op, state)
        code = LANE_OPS.index(op.name)
        wanted = code | sum(self.draw.choice(modes) << 4 + 2 * f for f, modes in enumerate(allowed))
        plain = code | sum(max(modes) << 4 + 2 * f for f, modes in enumerate(allowed))
        most = (1 << self.machine.numbers["TEMPLATE_BITS"]) - len(LANE_OPS)  # room for every plain one
        if wanted not in self.templates and len(self.templates) >= most:
            right = [t for t in self.templates if t & 15 == code and self._fits(t, allowed)]
            wanted = self.draw.choice(right) if right else plain
        if wanted not in self.templates:
            self.templates.append(wanted)
        return self.templates.index(wanted)

    @staticmethod
    def _fits(template: int, allowed: list[list[int]]) -> bool:
        return all(template >> 4 + 2 * f & 3 in modes for f, modes in enumerate(allowed))

    def _allowed(self, op: Op, state: LaneState) -> list[list[int]]:
        """The modes that give the operation's addresses, field by field."""
        used = [True, op.name in READS_B, op.name in READS_C, True]
        values = [op.a, op.b, op.c, op.to]
        size, half = 1 << self.machine.address_bits, 1 << self.machine.numbers["SHORT_BITS"] - 1
        allowed = []
        for f, value in enumerate(values):
            modes = [KEEP] if not used[f] else [FULL]
            same = (op.c if used[2] else state.kept[2]) if f == 3 else state.kept[f]
            if used[f] and value == same:
                modes.append(KEEP)
            if used[f] and value == (state.kept[f] + state.step[f]) % size:
                modes.append(STEP)
            if used[f] and (value - state.kept[f] + half) % size < 2 * half:
                modes.append(NEW_STEP)
            allowed.append(modes)
        return allowed

    def _fields(self, op: Op, state: LaneState, payload: Bits) -> None:
        size, short = 1 << self.machine.address_bits, self.machine.numbers["SHORT_BITS"]
        used = [True, op.name in READS_B, op.name in READS_C, True]
        for f, value in enumerate([op.a, op.b, op.c, op.to]):
            mode = self.templates[state.template] >> 4 + 2 * f & 3
            if mode == NEW_STEP:
                state.step[f] = (value - state.kept[f]) % size
                payload.put(state.step[f] % (1 << short), short)
            if mode == FULL:
                payload.put(value, self.machine.address_bits)
            if used[f]:
                state.kept[f] = value

    def _frozen(self, lengths: list[int], runs: list[int]) -> int:
        """Cycles in which something is waited for that is not all there."""
        at, rest, frozen, taken = 0, 0, 0, 0
        before, fetched = 1, 2
        while taken < len(lengths) or rest:
            full = fetched - at // self.line_bits == 4
            opened = at + 2 + self.machine.lanes <= before * self.line_bits
            if rest:
                rest -= 1
            elif opened and at + lengths[taken] <= fetched * self.line_bits:
                at += lengths[taken]
                rest = max(runs[taken] - 1, 0)
                taken += 1
            else:
                frozen += 1
            before = fetched
            fetched += not full
        return frozen
