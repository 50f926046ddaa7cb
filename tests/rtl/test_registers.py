"""The register file in RTL against the one that Python plays, access by access: answers, status, flags, faults."""

from __future__ import annotations

import random
import subprocess
from dataclasses import dataclass

import pytest

from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.registers import Control, Fault, Register, Status
from orbsoc.ps.segments import Method
from tests.rtl.engine_sources import build
from tests.rtl.verilator import require_verilator

TABLE, ENTRY = 0x1000, 64
BUFFERS = [
    f"b{i}" for i in range(64)
]  # as many flags as the RTL has, so that every DATA_VALID word is on both sides


@dataclass(frozen=True)
class Row:
    """A stage of a dataflow table."""

    module: str
    reads: tuple[str, ...] = ()
    writes: tuple[str, ...] = ()
    stales: tuple[str, ...] = ()
    flag: tuple[str, str] | None = None


def method(draw: random.Random) -> Method:
    """Five stages with random buffers; the first declares all buffers, so that their order is theirs."""
    modules = ["factorization", "linear_solve", "ps", "line_search", "cone_ops"]

    def some(most: int) -> tuple[str, ...]:
        return tuple(draw.sample(BUFFERS, draw.randint(0, most)))

    stages = {"all": Row("matrix_update", writes=tuple(BUFFERS[:40]), stales=tuple(BUFFERS[40:]))}
    stages |= {f"s{i}": Row(module, some(3), some(4), some(2)) for i, module in enumerate(modules)}
    return Method.from_tables(startup=[("all",)], iteration=[("s0",)], stages=stages, repeat=1, done=2)


def table_writes(m: Method) -> list[str]:
    """What the PS writes into the table of segments."""
    lines = []
    for segment in m.segments:
        base = TABLE + ENTRY * segment.number
        lines.append(f"write {base + 4:x} {segment.number * 100:x}")
        for column, mask in ((8, segment.reads), (16, segment.writes), (24, segment.stales)):
            lines += [f"write {base + column + 4 * i:x} {mask >> 32 * i & 0xFFFFFFFF:x}" for i in range(2)]
        lines.append(f"write {base:x} {int(segment.module):x}")
    return lines


class Session:
    """Random accesses: mostly a correct protocol, now and then something else."""

    def __init__(self, seed: int) -> None:
        self.draw = random.Random(seed)
        self.upsets = random.Random(seed)
        self.upset_share = 0.0 if seed % 10 else 0.1
        self.method = method(self.draw)
        self.pl = ProgrammableLogic(self.method, lambda _: 0)
        self.script = ["reset", *table_writes(self.method)]
        self.skip = len(self.script)
        self.expected: list[tuple[int, int, int]] = []
        self.sequence = 0

    def step(self, line: str, *, address: int = 0, value: int = 0) -> None:
        answer = 0
        if line == "write":
            self.pl.write(address, value)
            self.script.append(f"write {address:x} {value:x}")
        elif line == "read":
            answer = self.pl.read(address)
            self.script.append(f"read {address:x}")
        elif line == "upset":
            self.pl.upset()
            self.script.append("upset")
        else:
            self.pl.tick()
            self.script.append("end")
        self.expected.append((answer, self.pl.read(Register.STATUS), int(self.pl.interrupt)))

    def stray(self) -> None:
        """An access that may be out of place."""
        address = self.draw.choice([*Register, 0x24, 0x28, 0x1C, 0x13, 0x400])
        value = self.draw.choice([0, 1, 2, 3, self.sequence, self.draw.getrandbits(32)])
        self.step(self.draw.choice(["write", "write", "read"]), address=address, value=value)

    def frame(self) -> None:
        """One stage as the PS announces it, with at most one thing wrong."""
        draw = self.draw
        segment = draw.choice(self.method.segments)
        wrong = draw.choice([None] * 14 + ["module", "segment", "sequence", "command"])
        command = Control.PUBLISH if segment.module == 0 else Control.START
        self.sequence += 1
        self.step("write", address=Register.MODULE, value=segment.module + (wrong == "module"))
        number = segment.number if wrong != "segment" else draw.choice([6, 63, 64, 70, 1 << 31])
        self.step("write", address=Register.SEGMENT, value=number)
        self.step("write", address=Register.SEQUENCE, value=self.sequence + (wrong == "sequence"))
        self.step("write", address=Register.CONTROL, value=3 - command if wrong == "command" else command)
        if draw.random() < 0.05:
            self.stray()
        if self.upsets.random() < self.upset_share:
            self.step("upset")
        self.step("end")
        for address in (Register.STATUS, Register.DATA_VALID, Register.DATA_VALID + 4):
            self.step("read", address=address)
        if command == Control.START and draw.random() > 0.05:
            self.step("write", address=Register.IRQ_ACK, value=self.sequence + (draw.random() < 0.05))

    def run(self, frames: int) -> None:
        for _ in range(frames):
            if self.draw.random() < 0.02:
                self.stray()
            self.frame()


@pytest.fixture(scope="module")
def sessions() -> list[Session]:
    made = [Session(seed) for seed in range(300)]
    for session in made:
        session.run(12)
    return made


def test_rtl_and_python_register_files_agree_access_by_access(sessions: list[Session]) -> None:
    require_verilator()
    script = "\n".join(line for session in sessions for line in session.script) + "\n"
    done = subprocess.run([build("registers")], input=script, capture_output=True, text=True, check=True)
    rows = iter(done.stdout.splitlines())
    for session in sessions:
        found = [next(rows).split() for _ in session.script][session.skip :]
        answers = [(int(row[0], 16), int(row[1], 16), int(row[2])) for row in found]
        for i, (rtl, python) in enumerate(zip(answers, session.expected, strict=True)):
            assert rtl == python, (
                session.script[session.skip + i],
                Status.decode(rtl[1]),
                Status.decode(python[1]),
            )


def test_the_sessions_reach_every_fault(sessions: list[Session]) -> None:
    reached = {Status.decode(session.expected[-1][1]).fault for session in sessions}
    of_the_wrapper = {Fault.CYCLE_LIMIT, Fault.STREAM_ERROR}  # test_limit.py, test_streamed.py
    assert reached == set(Fault) - of_the_wrapper


def test_a_launch_gives_the_sequencer_the_segments_first_word() -> None:
    require_verilator()
    m = method(random.Random(0))
    frame = [(Register.MODULE, 1), (Register.SEGMENT, 1), (Register.SEQUENCE, 1), (Register.CONTROL, 1)]
    script = ["reset", *table_writes(m), *(f"write {address:x} {value:x}" for address, value in frame)]
    done = subprocess.run(
        [build("registers")], input="\n".join(script), capture_output=True, text=True, check=True
    )
    starts = [line.split()[3:] for line in done.stdout.splitlines()]
    assert starts[-1] == ["1", f"{100:x}"]
    assert {start for start, _ in starts[:-1]} == {"0"}
