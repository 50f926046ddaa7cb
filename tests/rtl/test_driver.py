"""The driver in C against the PS that Python plays: the same accesses in the same order, and the same error for each write that
goes wrong."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from orbsoc import _core
from orbsoc.hw.emulation import resident_program
from orbsoc.hw.schedules import Engine, pl_program
from orbsoc.ps.driver import Driver
from orbsoc.ps.events import Kind, PsRecord
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.program import BusyClocks
from orbsoc.ps.registers import (
    BUFFERS,
    INSTRUCTIONS,
    SEGMENTS,
    TEMPLATES,
    Fault,
    Module,
    Parity,
    ProtocolError,
    Region,
    Register,
)
from orbsoc.ps.segments import Method, Segment
from orbsoc.rtl.digest import program_digest
from orbsoc.rtl.session import RtlSession
from orbsoc.rtl.validation import Format
from tests.integration.small_problem import small_problem
from tests.ps.fake_engine import METHOD, FakeEngine, prepare
from tests.ps.test_faults import FaultyRegisters, Perturbation, drop, flip, overtaken_by, repeat, untouched
from tests.rtl.c_driver import (
    BUS_ERROR,
    DRIVER,
    ERRORS,
    IDENTITY,
    LAUNCH_TIMEOUT,
    LOST_INTERRUPT,
    LOST_WRITE,
    NOT_AT_REST,
    OK,
    OUT_OF_RANGE,
    WRONG_ENGINE,
    WRONG_PROGRAM,
    Board,
    CAttempt,
    CInstruction,
    CSegment,
    c_segment,
    library,
)
from tests.rtl.engine_sources import RTL
from tests.rtl.verilator import require_verilator

BUDGET = 5


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return library(tmp_path_factory.mktemp("driver"))


# ---- the protocol ----


def c_run(board: Board, steps: list[tuple[Kind, Segment]], *, polls: bool = False) -> int:
    """What the Python PS did, by the driver in C; the first error, or that of the rest at the end."""
    for kind, segment in steps:
        error = c_step(board, kind, segment, polls=polls)
        if error != OK:
            return error
    return board.call("require_rest")


def c_step(board: Board, kind: Kind, segment: Segment, *, polls: bool) -> int:
    one = ctypes.byref(c_segment(segment))
    if kind is Kind.RUN:
        if error := board.call("readable", one):
            return error
        board.engine_runs(segment)
        return board.call("publish", segment.number, one)
    if error := board.call("launch", segment.number, one):
        return error
    return waited(board, polls=polls)


def waited(board: Board, *, polls: bool) -> int:
    """For the end of a launch: by STATUS, of which each read lets the PL go on; or until the line is up, then the handler."""
    if polls:
        return board.call("poll", BUDGET)
    for _ in range(BUDGET):
        if board.port.interrupt:
            board.call("on_interrupt")
            break
        board.port.tick()
    return board.call("await", 1)


class EngineBoard(Board):
    """A board whose PS can run stages of the small engine."""

    def __init__(
        self, made: Path, perturb: Perturbation = untouched, hit: int = 0, *, ticks: bool = False
    ) -> None:
        self.engine = FakeEngine()
        self.emulated = ProgrammableLogic(METHOD, self.engine.run, busy_ticks=2)
        super().__init__(made, FaultyRegisters(self.emulated, hit, perturb))
        self._ticks = ticks
        assert self.open(len(METHOD.buffers)) == OK
        self.accesses.clear()

    def _read(self, address: int) -> int:
        if self._ticks:
            self.emulated.tick()
        return super()._read(address)

    def engine_runs(self, segment: Segment) -> None:
        if segment.number:
            self.engine.run(segment.stage)


def python_run(perturb: Perturbation = untouched, hit: int = 0) -> tuple[PsRecord, ProtocolError | None]:
    run = prepare(between=lambda pl: FaultyRegisters(pl, hit, perturb), busy_ticks=2, poll_budget=BUDGET)
    try:
        run.driver.run()
    except ProtocolError as error:
        return run.record, error
    return run.record, None


BY_STAGE = {segment.stage: segment for segment in METHOD.segments}
RECORD, _ = python_run()
STEPS = [
    (Kind.RUN, METHOD.segments[0]),
    *((event.kind, BY_STAGE[event.name]) for event in RECORD if event.kind in (Kind.RUN, Kind.LAUNCH)),
]
ACCESSES = [
    ("write" if event.kind is Kind.WRITE else "read", int(Register[event.name]), event.value)
    for event in RECORD
    if event.kind in (Kind.WRITE, Kind.READ)
]
WRITES = sum(kind == "write" for kind, _, _ in ACCESSES)


def test_the_driver_makes_the_accesses_of_the_python_ps(made: Path) -> None:
    board = EngineBoard(made)
    assert c_run(board, STEPS) == OK
    assert board.accesses == ACCESSES
    launches = sum(kind is Kind.LAUNCH for kind, _ in STEPS)
    assert board.memory_reads == launches > 10  # what was written to the memories is there before a launch


def test_by_polling_it_reads_more_of_status_and_nothing_else(made: Path) -> None:
    board = EngineBoard(made, ticks=True)
    assert c_run(board, STEPS, polls=True) == OK
    status = [access for access in board.accesses if access[1] == Register.STATUS]
    assert [access for access in board.accesses if access[1] != Register.STATUS] == [
        access for access in ACCESSES if access[1] != Register.STATUS
    ]
    assert len(status) > sum(access[1] == Register.STATUS for access in ACCESSES)


def test_a_limit_is_set_where_the_pl_has_one_and_ends_a_launch(made: Path) -> None:
    without = EngineBoard(made)
    assert without.call("limit", 5) == LOST_WRITE
    segment = BY_STAGE["scale"]
    for limit, error in ((101, OK), (100, Fault.CYCLE_LIMIT)):
        clocks = BusyClocks({(segment.stage,): 100}, launch=1, run=3, branch=7, end=2)
        board = Board(made, ProgrammableLogic(METHOD, FakeEngine().run, clocks=clocks))
        assert board.open(len(METHOD.buffers)) == OK
        assert board.call("limit", limit) == OK
        assert board.call("publish", 0, ctypes.byref(c_segment(METHOD.segments[0]))) == OK
        assert c_step(board, Kind.LAUNCH, segment, polls=False) == error
        assert board.call("spent") == 101


def test_parity_is_reported_of_a_launch_and_of_words_that_are_read(made: Path) -> None:
    class Upset(FakeEngine):
        def run(self, stage: str) -> int:
            logic.upset()
            return super().run(stage)

    logic = ProgrammableLogic(METHOD, Upset().run)
    board = Board(made, logic)
    assert board.open(len(METHOD.buffers)) == OK
    assert board.call("publish", 0, ctypes.byref(c_segment(METHOD.segments[0]))) == OK
    assert c_step(board, Kind.LAUNCH, BY_STAGE["scale"], polls=False) == Fault.PARITY
    assert ERRORS[Fault.PARITY] is Parity
    address, word = (ctypes.c_uint32 * 1)(5), (ctypes.c_uint64 * 1)()
    for parity in (
        True,
        False,
    ):  # a driver of an engine without parity does not look, which is an access less
        logic = ProgrammableLogic(METHOD, FakeEngine().run)
        board = Board(made, logic, parity=parity)
        assert board.open(len(METHOD.buffers)) == OK
        assert board.call("get_words", address, word, ctypes.c_size_t(1)) == OK
        logic.upset()
        assert board.call("get_words", address, word, ctypes.c_size_t(1)) == (Fault.PARITY if parity else OK)


def test_words_behind_the_last_row_are_refused_before_the_bus(made: Path) -> None:
    for words in (0, 40):
        board = Board(made, ProgrammableLogic(METHOD, FakeEngine().run), words=words)
        assert board.open(len(METHOD.buffers)) == OK
        last, word = words or 1 << 6, (ctypes.c_uint64 * 1)(7)
        for address, code in ((last - 1, OK), (last, OUT_OF_RANGE)):
            place = (ctypes.c_uint32 * 1)(address)
            for act in ("set_words", "get_words"):
                assert board.call(act, place, word, ctypes.c_size_t(1)) == code


def drop_frame(number: int, write: tuple[int, int]) -> list[tuple[int, int]]:
    return [] if 0 <= number < 4 else [write]


PERTURBATIONS = {"dropped": lambda: drop, "dropped with the next three": lambda: drop_frame, "doubled": lambda: repeat} | {
    f"overtaken by {count}": lambda count=count: overtaken_by(count) for count in (1, 2, 3)
} | {f"bit {bit} flipped": lambda bit=bit: flip(bit) for bit in (0, 1, 2, 7, 8, 15, 31)}  # fmt: skip


def differences(made: Path) -> list[str]:
    """Perturbed writes at which the driver in C does not report what the Python PS raises."""
    found = []
    for name, perturbation in PERTURBATIONS.items():
        for hit in range(WRITES):
            _, error = python_run(perturbation(), hit)
            code = c_run(EngineBoard(made, perturbation(), hit), STEPS)
            if ERRORS.get(code) is not type(error):
                found.append(f"write {hit} {name}: {code}, not {type(error).__name__}")
    return found


def test_each_write_that_goes_wrong_is_the_error_that_the_python_ps_raises(made: Path) -> None:
    assert differences(made) == []


def attempt_accesses(made: Path) -> tuple[list[tuple[str, int, int]], list[tuple[str, int, int]]]:
    """Of an attempt under resident control, by Python and by C."""
    method, program = Method.from_core(_core, resident=True), resident_program()

    def pl() -> ProgrammableLogic:
        ran: list[str] = []

        def execute(stage: str) -> int:
            ran.append(stage)
            return int(stage == "statistics" and ran.count(stage) == 3)

        return ProgrammableLogic(method, execute, program=program)

    record = PsRecord()
    words = dict.fromkeys(method.buffers, 1)
    Driver(method, FakeEngine(), pl(), words=words, record=record, program=program).run()
    python = [
        ("write" if event.kind is Kind.WRITE else "read", int(Register[event.name]), event.value)
        for event in record
        if event.kind in (Kind.WRITE, Kind.READ)
    ]
    board = Board(made, pl())
    assert board.open(len(method.buffers)) == OK
    board.accesses.clear()
    first = ctypes.byref(c_segment(method.segments[0]))
    _, written = method.attempt(warm=False)
    closing = 0
    for (stage,) in method.closing:
        closing |= next(segment.writes for segment in method.segments if segment.stage == stage)
    assert board.call("publish", 0, first) == OK
    assert board.call("launch_attempt", ctypes.byref(CAttempt(program.cold, closing, written))) == OK
    while not board.port.interrupt:
        board.port.tick()
    assert board.call("on_interrupt") == OK
    assert board.call("await", 1) == OK
    assert board.call("require_rest") == OK
    return python, board.accesses


def test_an_attempt_under_resident_control_makes_the_accesses_of_the_python_ps(made: Path) -> None:
    python, c = attempt_accesses(made)
    assert [(kind, min(address, int(Register.DATA_VALID)), value) for kind, address, value in c] == python


def test_an_interrupt_that_is_lost_and_a_segment_without_end_are_told_apart(made: Path) -> None:
    launch = next(segment for kind, segment in STEPS if kind is Kind.LAUNCH)
    for ticks, error in ((2, LOST_INTERRUPT), (1, LAUNCH_TIMEOUT)):
        board = EngineBoard(made)
        assert c_step(board, *STEPS[0], polls=False) == OK
        assert board.call("launch", launch.number, ctypes.byref(c_segment(launch))) == OK
        for _ in range(ticks):
            board.emulated.tick()
        assert board.call("await", BUDGET) == error
    board = EngineBoard(made)
    assert c_step(board, *STEPS[0], polls=False) == OK
    assert board.call("launch", launch.number, ctypes.byref(c_segment(launch))) == OK
    assert board.call("poll", BUDGET) == LAUNCH_TIMEOUT


# ---- memories and tables ----


class Recorder(RtlSession):
    """The writes of a session to its registers, in order."""

    def __init__(self) -> None:
        self.tables: list[tuple[int, int]] = []

    def write(self, address: int, value: int) -> None:
        self.tables.append((address, value))


class CImage(ctypes.Structure):
    """orbsoc_pl_image."""

    _fields_ = [
        ("binary64", ctypes.c_uint32), ("address_bits", ctypes.c_uint32), ("code_width", ctypes.c_uint32),
        ("microcode", ctypes.POINTER(ctypes.c_uint32)), ("lines", ctypes.c_uint32),
        ("templates", ctypes.POINTER(ctypes.c_uint32)), ("template_count", ctypes.c_uint32),
        ("literal_addresses", ctypes.POINTER(ctypes.c_uint32)), ("literals", ctypes.POINTER(ctypes.c_uint64)),
        ("literal_count", ctypes.c_size_t),
        ("segments", ctypes.POINTER(CSegment)), ("segment_count", ctypes.c_uint32),
        ("instructions", ctypes.POINTER(CInstruction)), ("instruction_count", ctypes.c_uint32),
        ("identity", ctypes.c_uint32), ("digest", ctypes.c_uint32),
    ]  # fmt: skip


LINES = [[10 * line + piece for piece in range(4)] for line in range(5)]
LITERALS = {3: 0x3FF0_0000_1234_5678, 63: 0x4000_0000_0000_0001}


def image(lines: list[list[int]] = LINES, **other: int) -> CImage:
    """A small image for the board of the tests."""
    segments = (CSegment * len(METHOD.segments))(*(c_segment(each, each.number) for each in METHOD.segments))
    fields = {"binary64": 1, "address_bits": 6, "code_width": 100, "identity": IDENTITY} | other
    pieces = [piece for line in lines for piece in line]
    return CImage(
        fields["binary64"], fields["address_bits"], fields["code_width"],
        (ctypes.c_uint32 * len(pieces))(*pieces), len(lines),
        (ctypes.c_uint32 * 3)(7, 8, 9), 3,
        (ctypes.c_uint32 * len(LITERALS))(*LITERALS), (ctypes.c_uint64 * len(LITERALS))(*LITERALS.values()), len(LITERALS),
        segments, len(segments),
        (CInstruction * 2)(CInstruction(0x0100_0001, 5), CInstruction(0, 6)), 2,
        fields["identity"], program_digest([7, 8, 9], lines),
    )  # fmt: skip


def loads(made: Path) -> bool:
    """Whether an image comes to be in the memories and tables as the Python session loads them."""
    recorder = Recorder()
    for segment in METHOD.segments:
        recorder.write_segment(segment, segment.number)
    recorder.write_instruction(0, 0x0100_0001, 5)
    recorder.write_instruction(1, 0, 6)
    board = EngineBoard(made)
    if board.call("load", ctypes.byref(image())) != OK:
        return False
    lines = {
        line: sum(piece << 32 * k for k, piece in enumerate(pieces)) for line, pieces in enumerate(LINES)
    }
    return (
        board.words(Region.MICROCODE) == lines
        and board.words(Region.TEMPLATES) == {0: 7, 1: 8, 2: 9}
        and board.words(Region.STORAGE) == LITERALS
        and board.get_words(LITERALS) == list(LITERALS.values())
        and board.tables == recorder.tables
        and not board.refused
    )


def test_an_image_is_loaded_as_the_python_session_loads_it(made: Path) -> None:
    assert loads(made)


SHAPES: tuple[tuple[dict[str, Any], Format], ...] = (
    ({}, "flat"), ({}, "compressed"), ({"banks": 4}, "flat"), ({"banks": 8}, "flat"), ({"lanes": 2}, "flat"),
    ({"lanes": 3}, "compressed"), ({"clusters": 4}, "compressed"), ({"dividers": 2}, "flat"), ({"fp": 32}, "flat"),
    ({"address_bits": 11}, "flat"), ({"rows": 255}, "flat"), ({"rows": 254}, "flat"),
)  # fmt: skip
"""Twelve engines, of which no two take each other's programs; some have lines of one width."""


@pytest.fixture(scope="module")
def identities() -> list[int]:
    """Of the programs of one problem for each."""
    return [own.identity for own in images()]


def images() -> list[_core.ProgramImage]:
    engines = [(Engine(**{"address_bits": 12, **shape}), form) for shape, form in SHAPES]
    return [
        _core.program_image(pl_program(small_problem(), None, engine).core, form) for engine, form in engines
    ]


def test_a_program_of_another_engine_is_refused_by_driver_and_host_before_anything_is_written(
    made: Path,
) -> None:
    """Every pair of twelve shapes."""
    programs = images()
    for here, engine in enumerate(programs):
        board = Board(made, ProgrammableLogic(METHOD, FakeEngine().run), identity=engine.identity)
        assert board.open() == OK
        for there, program in enumerate(programs):
            found = board.call("load", ctypes.byref(image(identity=program.identity)))
            assert found == (OK if here == there else WRONG_ENGINE)
            if here == there:
                program.require_identity(engine.identity)
                board.memories = {region: {} for region in Region}
                board.tables = []
            else:
                with pytest.raises(_core.HardwareError, match="the program is of an engine of binary"):
                    program.require_identity(engine.identity)
                assert (board.tables, any(board.memories.values())) == ([], False)


def test_the_rtl_has_the_same_identities(identities: list[int], tmp_path: Path) -> None:
    require_verilator()
    names = ("fp", "lanes", "dividers", "banks", "clusters", "address_bits")
    own = {"fp": 64, "lanes": 4, "dividers": 1, "banks": 16, "clusters": 1, "address_bits": 12}
    engines = [(own | shape, int(form == "compressed")) for shape, form in SHAPES]
    rows = [shape.get("rows", (1 << shape["address_bits"]) // shape["banks"]) for shape, _ in engines]
    shows = "".join(
        f'    $display("%h", axi_contract::identity({", ".join(str(shape[name]) for name in names)}, {there}, {compressed}));\n'
        for (shape, compressed), there in zip(engines, rows, strict=True)
    )
    (tmp_path / "shown.sv").write_text(
        f"module shown;\n  initial begin\n{shows}    $finish;\n  end\nendmodule\n"
    )
    command = [
        "verilator",
        "--binary",
        "-Wno-fatal",
        f"-I{RTL}",
        "--top-module",
        "shown",
        "--Mdir",
        tmp_path / "made",
    ]
    subprocess.run(
        [*command, RTL / "contract.sv", RTL / "axi" / "axi_contract.sv", tmp_path / "shown.sv"],
        check=True,
        capture_output=True,
    )
    done = subprocess.run([tmp_path / "made" / "Vshown"], check=True, capture_output=True, text=True)
    assert [int(line, 16) for line in done.stdout.split() if len(line) == 8] == identities


def flipped(at: int, bit: int) -> Callable[[int, int], tuple[int, int]]:
    """A bit of what is written to one byte address."""
    return lambda offset, value: (offset, value ^ (1 << bit if offset == at else 0))


@pytest.mark.parametrize(
    "spoil",
    [
        flipped(Region.MICROCODE + 16, 3), flipped(Region.MICROCODE + 16 * 4 + 12, 31), flipped(Region.TEMPLATES + 4, 0),
        flipped(Region.STORAGE + 8 * 3, 5),
        lambda offset, value: (offset ^ (0x30 if Region.MICROCODE <= offset < Region.TEMPLATES else 0), value),
    ],
    ids=["a line", "its last piece", "a template", "a literal", "lines that change places"],
)  # fmt: skip
def test_a_program_that_is_not_what_was_sent_is_noticed(
    made: Path, spoil: Callable[[int, int], tuple[int, int]]
) -> None:
    board = EngineBoard(made)
    board.spoil = spoil
    assert board.call("load", ctypes.byref(image())) == WRONG_PROGRAM
    assert board.tables == []  # nothing can be launched
    board.spoil = lambda offset, value: (offset, value)
    assert board.call("load", ctypes.byref(image())) == OK


def test_an_image_that_is_damaged_in_memory_is_noticed(made: Path) -> None:
    board, damaged = EngineBoard(made), image()
    damaged.microcode[7] ^= 1 << 20
    assert board.call("load", ctypes.byref(damaged)) == WRONG_PROGRAM


def test_a_load_ends_at_the_first_store_that_the_bus_refuses(made: Path) -> None:
    board, stores = EngineBoard(made), list[int]()

    def refused(offset: int, value: int) -> tuple[int, int]:
        stores.append(offset)
        board.call("on_bus_error")
        return offset, value

    board.spoil = refused
    assert board.call("load", ctypes.byref(image())) == BUS_ERROR
    assert stores == [int(Region.TEMPLATES)]


def test_words_of_binary32_lie_side_by_side(made: Path) -> None:
    board = Board(made, ProgrammableLogic(METHOD, FakeEngine().run), binary64=False)
    assert board.open() == OK
    assert board.set_words({1: 0x3F80_0000, 2: 0x4000_0000}) == OK
    assert board.words(Region.STORAGE) == {1: 0x3F80_0000, 2: 0x4000_0000}
    assert board.get_words([2, 1]) == [0x4000_0000, 0x3F80_0000]


def test_what_the_engine_would_refuse_never_reaches_the_bus(made: Path) -> None:
    board = EngineBoard(made)
    for wrong in ({"binary64": 0}, {"address_bits": 7}, {"code_width": 99}, {"identity": IDENTITY ^ 1}):
        assert board.call("load", ctypes.byref(image(**wrong))) == WRONG_ENGINE
    line = (ctypes.c_uint32 * 4)()
    segment, instruction = ctypes.byref(CSegment()), ctypes.byref(CInstruction())
    assert board.call("load_line", 8, line) == OUT_OF_RANGE
    assert board.call("load_template", TEMPLATES, 0) == OUT_OF_RANGE
    assert board.call("load_segment", SEGMENTS, segment) == OUT_OF_RANGE
    assert board.call("load_instruction", INSTRUCTIONS, instruction) == OUT_OF_RANGE
    assert board.set_words({64: 1}) == OUT_OF_RANGE
    assert board.open(BUFFERS + 1) == OUT_OF_RANGE
    assert board.call("poll", 1) == board.call("await", 1) == board.call("stop") == NOT_AT_REST
    assert c_step(board, *STEPS[0], polls=False) == OK
    launch = next(one for kind, one in STEPS if kind is Kind.LAUNCH)
    assert board.call("launch", launch.number, ctypes.byref(c_segment(launch))) == OK
    before = list(board.accesses)
    one = ctypes.byref(c_segment(launch))
    assert board.set_words({1: 1}) == board.call("load_line", 0, line) == NOT_AT_REST
    assert board.call("launch", launch.number, one) == board.call("publish", 0, one) == NOT_AT_REST
    assert board.call("load_segment", 1, segment) == board.call("load_template", 1, 1) == NOT_AT_REST
    assert (board.accesses, board.memories[Region.STORAGE], board.tables) == (before, {}, [])
    no_control = Board(made, ProgrammableLogic(METHOD, FakeEngine().run), resident=False)
    assert no_control.open() == OK
    assert no_control.call("launch_attempt", ctypes.byref(CAttempt())) == OUT_OF_RANGE
    assert no_control.call("load_instruction", 0, instruction) == OUT_OF_RANGE


def test_after_a_fault_only_a_reset_leads_on(made: Path) -> None:
    """The PL may still be busy with the segment: its memories are not touched."""
    board = EngineBoard(made)
    assert c_step(board, *STEPS[0], polls=False) == OK
    launch = next(one for kind, one in STEPS if kind is Kind.LAUNCH)
    assert board.call("launch", launch.number, ctypes.byref(c_segment(launch))) == OK
    board.port.write(Register.MODULE, int(Module.PS))
    assert board.call("poll", BUDGET) == Fault.LAUNCH_WHILE_BUSY
    assert board.call("on_interrupt") == Fault.LAUNCH_WHILE_BUSY
    assert board.set_words({1: 1}) == NOT_AT_REST
    board.port = ProgrammableLogic(METHOD, board.engine.run)
    assert board.resets == 1
    assert board.call("reset") == OK
    assert board.resets == 2
    assert board.set_words({1: 1}) == OK


# ---- a driver that is wrong in one place ----

MUTATIONS = {
    "identity not compared": ("image->identity == pl->identity && ", ""),
    "digest not compared": ("if (read_register(pl, ORBSOC_REG_DIGEST) != digest) return ORBSOC_PL_WRONG_PROGRAM;", "(void)digest;"),
    "literals not read back": ("if (word != image->literals[i]) return ORBSOC_PL_WRONG_PROGRAM;", ""),
    "a digest that is not begun anew": ("  write_register(pl, ORBSOC_REG_DIGEST, 0u);\n", ""),
    "SEQUENCE before SEGMENT": (
        "  write_register(pl, ORBSOC_REG_SEGMENT, segment);\n  write_register(pl, ORBSOC_REG_SEQUENCE, pl->sequence);\n",
        "  write_register(pl, ORBSOC_REG_SEQUENCE, pl->sequence);\n  write_register(pl, ORBSOC_REG_SEGMENT, segment);\n",
    ),
    "no acknowledgement": ("  write_register(pl, ORBSOC_REG_IRQ_ACK, pl->sequence);\n", ""),
    "sequence not checked": ("!= (pl->sequence & 0xffu)) return ORBSOC_PL_LOST_WRITE", "!= (pl->sequence & 0xffu)) return ORBSOC_PL_OK"),
    "fault overlooked": (": (orbsoc_pl_error)FIELD(*status, ORBSOC_STATUS_FAULT)", ": (orbsoc_pl_error)(FIELD(*status, ORBSOC_STATUS_FAULT) & 7u)"),
    "one flag register too few": ("word < pl->flag_words", "word + 1u < pl->flag_words"),
    "segments launched as the PS's": ("start(pl, segment->module,", "start(pl, ORBSOC_MODULE_PS,"),
    "high half first": ("addresses[i], low(words[i]));\n      orbsoc_pl_write(storage + (uintptr_t)8u * addresses[i] + 4u, high(words[i]));", "addresses[i] + 4u, high(words[i]));\n      orbsoc_pl_write(storage + (uintptr_t)8u * addresses[i], low(words[i]));"),
    "lines side by side": ("while (bytes < 4u * count) bytes *= 2u;", "bytes = 4u * count - 4u;"),
    "a segment exists before it is whole": ("  write_register(pl, entry + ORBSOC_ENTRY_START, segment->start);\n", "  write_register(pl, entry + ORBSOC_ENTRY_MODULE, segment->module);\n  write_register(pl, entry + ORBSOC_ENTRY_START, segment->start);\n"),
    "masks swapped": ("ORBSOC_ENTRY_READS, segment->reads", "ORBSOC_ENTRY_READS, segment->writes"),
}  # fmt: skip


def conforms(made: Path) -> bool:
    """Whether a driver passes what the right one does."""
    board = EngineBoard(made)
    whole = c_run(board, STEPS) == OK and board.accesses == ACCESSES and loads(made) and not differences(made)
    return whole and refuses(made)


def refuses(made: Path) -> bool:
    """Whether a driver takes no program of another engine and no spoilt one, and after that the right one."""
    board = EngineBoard(made)
    found = [board.call("load", ctypes.byref(image(identity=1)))]
    for spoil in (flipped(Region.MICROCODE + 16, 3), flipped(Region.STORAGE + 8 * 3, 5)):
        board.spoil = spoil
        found.append(board.call("load", ctypes.byref(image())))
    board.spoil = lambda offset, value: (offset, value)
    return [*found, board.call("load", ctypes.byref(image()))] == [
        WRONG_ENGINE,
        WRONG_PROGRAM,
        WRONG_PROGRAM,
        OK,
    ]


@pytest.mark.parametrize("name", MUTATIONS)
def test_a_mutation_of_the_driver_is_caught(name: str, tmp_path: Path) -> None:
    right, wrong = MUTATIONS[name]
    source = (DRIVER / "orbsoc.c").read_text()
    assert source.count(right) == 1
    assert not conforms(library(tmp_path, source.replace(right, wrong)))


def test_the_driver_as_it_is_conforms(made: Path) -> None:
    assert conforms(made)
