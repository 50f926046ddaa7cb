"""The PL engine of docs/pl-machine.md, once more and small: words, a greedy schedule, what a run must give.

Written from the contract alone, beside the scheduler that the product uses, so that the RTL has two judges.
Addresses and times are plain numbers; a word of storage is its bit pattern.
"""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tests.rtl.engine_sources import parameters

LANE_OPS = (
    "nop",
    "move",
    "neg",
    "abs",
    "mul",
    "add",
    "sub",
    "add_mul",
    "sub_mul",
    "min",
    "max",
    "compare",
    "and",
    "select",
)
DIVIDER_OPS = ("nop", "div", "sqrt")
READS_B = {"mul", "add_mul", "sub_mul", "min", "max", "compare", "and", "select", "div"}
READS_C = {"add", "sub", "add_mul", "sub_mul", "select"}
MIXTURE = [*LANE_OPS[1:], "add_mul", "sub_mul", "mul", "add"] * 3 + ["div", "sqrt"]
SEQUENCERS = {"flat": 0, "compressed": 1, "in_order": 2}


@dataclass(frozen=True)
class Machine:
    """One configuration of the engine."""

    fp: int = 64
    lanes: int = 2
    dividers: int = 1
    banks: int = 8
    clusters: int = 1
    address_bits: int = 10
    parity: bool = False
    rows: int = 0
    """Of a bank; 0: as many as an address tells apart."""

    @property
    def words(self) -> int:
        return self.rows * self.banks if self.rows else 1 << self.address_bits

    @property
    def numbers(self) -> dict[str, int]:
        return parameters()

    def latency(self, name: str) -> int:
        """U of the contract's table of operations."""
        table, prefix = self.numbers, f"F{self.fp}_"
        add, mul = table[prefix + "ADD_CYCLES"], table[prefix + "MUL_CYCLES"]
        special = {"mul": mul, "add": add, "sub": add, "add_mul": mul + add, "sub_mul": mul + add}
        special |= {"div": table[prefix + "DIV_CYCLES"], "sqrt": table[prefix + "SQRT_CYCLES"]}
        return special.get(name, table["SIMPLE_CYCLES"])

    def interval(self, name: str) -> int:
        """Cycles from the issue of an operation to the next on the same unit."""
        return self.numbers[f"F{self.fp}_{name.upper()}_INTERVAL_CYCLES"] if name in DIVIDER_OPS else 1

    def distance(self, name: str) -> int:
        """Cycles from issue until the result may be read: U + READ + WRITE."""
        return self.latency(name) + self.numbers["READ_CYCLES"] + self.numbers["WRITE_CYCLES"]

    def build_options(self, form: str) -> dict[str, int]:
        """Module parameters of this engine with the sequencer for `form`."""
        return (
            {
                "FP": self.fp,
                "LANES": self.lanes,
                "DIVIDERS": self.dividers,
                "BANKS": self.banks,
                "CLUSTERS": self.clusters,
                "ADDRESS_BITS": self.address_bits,
                "SEQUENCER": SEQUENCERS[form],
                "CODE_BITS": 17,
            }
            | ({"PARITY": 1} if self.parity else {})
            | ({"ROWS": self.rows} if self.rows else {})
        )

    def cluster_of(self, unit: int) -> int:
        """Lanes in equal runs, dividers in turn."""
        return (
            (unit - self.lanes) % self.clusters if unit >= self.lanes else unit * self.clusters // self.lanes
        )

    def canonical_nan(self) -> int:
        return 0x7FF8_0000_0000_0000 if self.fp == 64 else 0x7FC0_0000


@dataclass(frozen=True)
class Op:
    """`to` := name(a, b, c); an operand that the operation does not read is 0."""

    name: str
    to: int
    a: int
    b: int = 0
    c: int = 0

    @property
    def divides(self) -> bool:
        return self.name in DIVIDER_OPS

    @property
    def reads(self) -> list[int]:
        """Addresses read, by replica; None where a replica is not."""
        return [address for _, address in self.ports]

    @property
    def ports(self) -> list[tuple[str, int]]:
        """(replica, address) of every read."""
        ports = [("A", self.a)]
        ports += [("B", self.b)] if self.name in READS_B else []
        return ports + ([("C", self.c)] if self.name in READS_C else [])


@dataclass(frozen=True)
class Slot:
    """An operation placed: cycle of issue and unit (lanes first, then dividers)."""

    op: Op
    time: int
    unit: int


def encode(machine: Machine, slots: Iterable[Slot], words: int) -> list[int]:
    """Flat microcode, one integer per cycle."""
    a, lane_bits = machine.address_bits, 4 * machine.address_bits + 4
    code = [0] * words
    for slot in slots:
        op = slot.op
        if slot.unit < machine.lanes:
            fields = op.a | op.b << a | op.c << 2 * a | op.to << 3 * a | LANE_OPS.index(op.name) << 4 * a
            place = 1 + slot.unit * lane_bits
        else:
            fields = op.a | op.b << a | op.to << 2 * a | DIVIDER_OPS.index(op.name) << 3 * a
            place = 1 + machine.lanes * lane_bits + (slot.unit - machine.lanes) * (3 * a + 2)
        code[slot.time] |= fields << place
    code[-1] |= 1
    return code


def busy_cycles(machine: Machine, slots: Sequence[Slot], words: int) -> int:
    """STARTUP + E + FINISH of a static segment."""
    ends = [slot.time + machine.distance(slot.op.name) + 1 for slot in slots]
    return machine.numbers["STARTUP_CYCLES"] + max([words, *ends]) + machine.numbers["FINISH_CYCLES"]


@dataclass
class Reservations:
    """What a greedy schedule has taken; `place` puts one operation at its earliest cycle."""

    machine: Machine
    ready: dict[int, int] = field(default_factory=dict)
    read_last: dict[int, int] = field(default_factory=dict)
    rows: dict[tuple[str, int, int], int] = field(default_factory=dict)
    issued: set[tuple[int, int]] = field(default_factory=set)
    results: set[tuple[int, int]] = field(default_factory=set)
    writes: set[tuple[int, int]] = field(default_factory=set)
    exported: dict[tuple[str, int, int], int] = field(default_factory=dict)
    """(replica, cluster, cycle): the address that units of other clusters read."""
    leaving: set[tuple[int, int]] = field(default_factory=set)
    """(cluster, cycle) in which a result leaves it."""
    divider_free: dict[int, int] = field(default_factory=dict)

    def place(self, op: Op) -> Slot:
        touched = [*op.reads, op.to]
        time = max([self.ready.get(address, 0) for address in touched] + [self.read_last.get(op.to, 0)])
        while (unit := self._unit(op, time)) is None:
            time += 1
        end = time + self.machine.latency(op.name)
        self.ready[op.to] = time + self.machine.distance(op.name)
        for replica, address in op.ports:
            self.read_last[address] = max(self.read_last.get(address, 0), time)
            self.rows[replica, address % self.machine.banks, time] = address
            if self._remote(address, unit):
                self.exported[replica, address % self.machine.clusters, time] = address
        if self._remote(op.to, unit):
            self.leaving.add((self.machine.cluster_of(unit), end))
        self.issued.add((unit, time))
        self.results.add((unit, end))
        self.writes.add((op.to % self.machine.banks, end))
        if op.divides:
            self.divider_free[unit] = time + self.machine.interval(op.name)
        return Slot(op, time, unit)

    def _unit(self, op: Op, time: int) -> int | None:
        banks, end = self.machine.banks, time + self.machine.latency(op.name)
        if (op.to % banks, end) in self.writes:
            return None
        if any(self.rows.get((replica, x % banks, time), x) != x for replica, x in op.ports):
            return None
        if op.divides:
            units = range(self.machine.lanes, self.machine.lanes + self.machine.dividers)
            free = (u for u in units if self.divider_free.get(u, 0) <= time)
        else:
            free = (
                u
                for u in range(self.machine.lanes)
                if not {(u, time)} & self.issued and (u, end) not in self.results
            )
        return next((u for u in free if self._reaches(op, time, end, u)), None)

    def _remote(self, address: int, unit: int) -> bool:
        return address % self.machine.clusters != self.machine.cluster_of(unit)

    def _reaches(self, op: Op, time: int, end: int, unit: int) -> bool:
        """Whether the network brings a unit its operands, and its result to the bank."""
        if self._remote(op.to, unit) and (self.machine.cluster_of(unit), end) in self.leaving:
            return False
        clusters = self.machine.clusters
        imports = ((replica, x) for replica, x in op.ports if self._remote(x, unit))
        return all(self.exported.get((replica, x % clusters, time), x) == x for replica, x in imports)


def schedule(machine: Machine, ops: Sequence[Op]) -> list[Slot]:
    """Every operation at its earliest cycle, in program order."""
    taken = Reservations(machine)
    return [taken.place(op) for op in ops]


def evaluate(machine: Machine, ops: Sequence[Op], memory: dict[int, int]) -> dict[int, int]:
    """The storage after the operations, in program order, by NumPy's IEEE arithmetic."""
    word, real = (np.uint64, np.float64) if machine.fp == 64 else (np.uint32, np.float32)
    sign = 1 << (machine.fp - 1)
    after = dict(memory)

    def number(bits: int) -> Any:
        return np.array(bits, word).view(real)[()]

    def bits_of(value: Any) -> int:
        return machine.canonical_nan() if np.isnan(value) else int(np.array(value, real).view(word))

    def result(name: str, a: int, b: int, c: int) -> int:
        x, y, z = number(a), number(b), number(c)
        match name:
            case "move":
                return a
            case "neg":
                return a ^ sign
            case "abs":
                return a & ~sign
            case "min":
                return b if y < x else a
            case "max":
                return b if x < y else a
            case "compare":
                return 2 * sign - 1 if x < y else 0
            case "and":
                return a & b
            case "select":
                return a if c & 1 else b
            case "mul":
                return bits_of(x * y)
            case "add":
                return bits_of(z + x)
            case "sub":
                return bits_of(z - x)
            case "add_mul":
                return bits_of(z + x * y)
            case "sub_mul":
                return bits_of(z - x * y)
            case "div":
                return bits_of(x / y)
            case _:
                return bits_of(np.sqrt(x))

    with np.errstate(all="ignore"):
        for op in ops:
            after[op.to] = result(op.name, after[op.a], after.get(op.b, 0), after.get(op.c, 0))
    return after


def xorshift(x: int) -> int:
    """The generator of fetch gaps."""
    x ^= x << 13 & 0xFFFF_FFFF
    x ^= x >> 17
    return x ^ (x << 5 & 0xFFFF_FFFF)


def in_order(machine: Machine, slots: Sequence[Slot], *, seed: int, level: int) -> tuple[list[Slot], int]:
    """The in-order sequencer on the words of a schedule: the words without the empty ones, and its busy cycles."""
    numbers = machine.numbers
    times = sorted({slot.time for slot in slots})
    words = [[slot for slot in slots if slot.time == time] for time in times]
    remaining, queue = deque(words), deque[list[Slot]]()
    busy: dict[int, int] = {}  # word address -> first cycle in which it is no longer busy
    taken: set[tuple[str, int, int]] = set()
    dividers: dict[int, int] = {}
    cycle, last = 0, 0
    while remaining or queue:
        fetched = False
        if remaining:
            seed = xorshift(seed)
            fetched = (seed & 255) >= level and len(queue) < numbers["QUEUE_DEPTH"]
        if queue and _may_issue(machine, queue[0], cycle, busy, taken, dividers):
            for slot in queue.popleft():
                end = cycle + machine.latency(slot.op.name)
                busy[slot.op.to] = cycle + machine.distance(slot.op.name)
                taken |= {("result", slot.unit, end), ("bank", slot.op.to % machine.banks, end)}
                dividers[slot.unit] = cycle + machine.interval(slot.op.name)
                last = max(last, busy[slot.op.to] + 1)
        if fetched:
            queue.append(remaining.popleft())
        cycle += 1
    packed = [Slot(slot.op, times.index(slot.time), slot.unit) for slot in slots]
    return packed, numbers["STARTUP_CYCLES"] + last + numbers["FINISH_CYCLES"]


def _may_issue(
    machine: Machine,
    word: list[Slot],
    cycle: int,
    busy: dict[int, int],
    taken: set[tuple[str, int, int]],
    dividers: dict[int, int],
) -> bool:
    for slot in word:
        op, end = slot.op, cycle + machine.latency(slot.op.name)
        if any(busy.get(address, 0) > cycle for address in [*op.reads, op.to]):
            return False
        if {("result", slot.unit, end), ("bank", op.to % machine.banks, end)} & taken:
            return False
        if op.divides and dividers.get(slot.unit, 0) > cycle:
            return False
    return True


def random_program(
    machine: Machine, count: int, seed: int, *, words: int = 96, names: Sequence[str] = MIXTURE
) -> tuple[list[Op], dict[int, int]]:
    """Operations on `words` words of storage (every fourth a constant that stays), and their contents before."""
    draw = random.Random(seed)
    ones = 2 * (1 << (machine.fp - 1)) - 1
    exp, man = (11, 52) if machine.fp == 64 else (8, 23)
    bias = (1 << (exp - 1)) - 1
    specials = [0, 1, 1 << man, ((1 << exp) - 1) << man, machine.canonical_nan(), ones, ones >> 1]

    def content() -> int:
        if draw.random() < 0.1:
            return draw.choice(specials)
        exponent = bias + draw.randint(-3, 3) if draw.random() < 0.9 else draw.randrange(1 << exp)
        return draw.getrandbits(1) << (exp + man) | exponent << man | draw.getrandbits(man)

    addresses = draw.sample(range(machine.words), words)
    memory = {address: content() for address in addresses}
    targets = [address for i, address in enumerate(addresses) if i % 4]

    def operation() -> Op:
        name = draw.choice(names)
        a, b, c = draw.choices(addresses, k=3)
        return Op(name, draw.choice(targets), a, b if name in READS_B else 0, c if name in READS_C else 0)

    return [operation() for _ in range(count)], memory


def full_words(machine: Machine, seed: int = 0) -> tuple[list[Slot], dict[int, int]]:
    """Every lane begins an operation in every cycle, from far-away addresses, and the divider whenever it can: words so long
    that the decoder falls behind, with divisions in flight."""
    random_ = random.Random(seed)
    rows = (1 << machine.address_bits) // machine.banks
    memory: dict[int, int] = {}
    slots: list[Slot] = []

    def read(bank: int) -> int:
        address = random_.randrange(rows // 2) * machine.banks + bank
        memory[address] = 0x3FF0_0000_0000_0000 + random_.getrandbits(52)
        return address

    written = iter(range(rows // 2, rows))
    for time in range(60):
        for unit in range(machine.lanes + machine.dividers):
            divides = unit >= machine.lanes
            if divides and time % machine.interval("div"):
                continue
            banks = [(unit + time) % machine.banks] * 3
            to = next(written) * machine.banks + unit + machine.lanes * divides
            slots.append(Slot(Op("div" if divides else "add_mul", to, *map(read, banks)), time, unit))
    return slots, memory
