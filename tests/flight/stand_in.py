"""An export with a partition on this machine, beside a PL that Python plays: registers, storage, and stages run on its words.

The stand-in runs a stage by the exact engine, on words that it takes from its storage and nowhere else, and puts back into
it. So words that the program forgets to move, or that a test changes there, have their effect.
"""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import orbsoc
from hw_model import load_partition
from hw_model.platform.partition import Partition
from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.flight.tables import tables_of
from orbsoc.hw.busy_clocks import clocks_of
from orbsoc.hw.emulation import resident_program
from orbsoc.hw.schedules import Engine, pl_program
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.registers import (
    BUFFERS,
    ENGINE_FIELDS,
    SIZES_FIELDS,
    TABLE,
    Fault,
    Region,
    Register,
    Wrapper,
)
from orbsoc.rtl.c_image import placed
from tests.flight.c_library import ROOT, STRICT, CSolver
from tests.rtl.written_program import WrittenProgram

REGISTERS, MEMORIES = 0x4000_0000, 0x8000_0000
_READ = ctypes.CFUNCTYPE(ctypes.c_uint32, ctypes.c_size_t)
_WRITE = ctypes.CFUNCTYPE(None, ctypes.c_size_t, ctypes.c_uint32)
Trouble = Callable[["StandIn", str], None]
"""Called after each stage that the PL ran, with its name."""


class StandIn:
    """The PL behind both ports. Register and memory accesses of the driver end here."""

    def __init__(self, problem: Problem, settings: Settings, engine: Engine, partition: Partition) -> None:
        resident = partition.control == "pl"
        self.control = resident_program() if resident else None
        modules = {name for name, side in partition.modules.items() if side == "pl"}
        self.method = placed(None if resident else modules, resident=resident)
        alone = tuple((stage,) for stage, info in _core.stages().items() if info.module in modules)
        streams = self.control.streams if self.control else alone
        program = pl_program(problem, settings, engine, None, streams)
        image = _core.program_image(program.core, "flat")
        self.clocks = clocks_of({stages: image.entries["_".join(stages)][1] for stages in streams})
        self.homes = image.homes
        self.fp = engine.fp
        self.numbers = _core.ExactEngine(problem, settings, engine.fp)
        self.storage: dict[int, int] = {}
        self.trouble: Trouble | None = None
        self.silent = False
        """STATUS never says that a launch has ended."""
        self.accesses = self.loads = self.tries = self.ran = 0
        self.bus_error: Callable[[], None] | None = None
        self.error_at = -1
        self._low = 0
        engine_word = ENGINE_FIELDS["binary64"].put(self.fp == 64) | ENGINE_FIELDS["resident"].put(resident)
        width = _width(program.engine)
        sizes = {"address_bits": program.engine.address_bits or 0, "code_bits": 17, "code_width": width}
        self.constants = {
            int(Wrapper.ENGINE): engine_word,
            int(Wrapper.SIZES): sum(SIZES_FIELDS[name].put(value) for name, value in sizes.items()),
            int(Wrapper.CYCLES): 0,
            int(Wrapper.IDENTITY): image.identity,
        }
        self._pieces = -(-width // 32)
        self._program = WrittenProgram()
        self.reset()

    def reset(self) -> None:
        """A try begins."""
        self.tries += 1
        self.ran = 0
        self.silent = False
        self.port = ProgrammableLogic(self.method, self._run, program=self.control, clocks=self.clocks)

    def _run(self, stage: str) -> int:
        """A stage on the words of the storage."""
        self.ran += 1
        info = _core.stages()[stage]
        for buffer in info.reads:
            if buffer in self.homes:
                indices, addresses = self.homes[buffer]
                words = [self.storage.get(int(at), 0) for at in addresses]
                self.numbers.set_words(buffer, indices, np.array(words, np.uint64))
        outcome = self.numbers.run(stage)
        for buffer in info.writes:
            if buffer in self.homes:
                indices, addresses = self.homes[buffer]
                words = self.numbers.words(buffer, indices).tolist()
                self.storage.update(zip(addresses.tolist(), words, strict=True))
        if self.trouble is not None:
            self.trouble(self, stage)
        return outcome

    def read(self, address: int) -> int:
        self._count()
        if address >= MEMORIES:
            offset = address - MEMORIES
            if self.fp == 32:
                return self.storage.get(offset // 4, 0)
            return self.storage.get(offset // 8, 0) >> 32 * (offset // 4 % 2) & 0xFFFF_FFFF
        address -= REGISTERS
        if address in self.constants:
            return self.constants[address]
        if address == Wrapper.DIGEST:
            return self._program.digest
        if address == Register.STATUS and not self.silent:
            self.port.tick()
        return self.port.read(address)

    def write(self, address: int, value: int) -> None:
        self._count()
        if address >= MEMORIES:
            self._write_memory(address - MEMORIES, value)
        elif address - REGISTERS == Wrapper.RESET:
            self.reset()
        elif address - REGISTERS == Wrapper.DIGEST:
            self._program.clear()
        elif not TABLE <= address - REGISTERS < Wrapper.RESET:
            self.port.write(address - REGISTERS, value)

    def _write_memory(self, offset: int, value: int) -> None:
        if offset >= Region.MICROCODE:
            self.loads += offset == Region.MICROCODE
            line, piece = divmod((offset - Region.MICROCODE) // 4, 1 << (self._pieces - 1).bit_length())
            self._program.piece(Region.MICROCODE, line, value, last=piece == self._pieces - 1)
        elif self.fp == 32:
            self.storage[offset // 4] = value
        elif offset // 4 % 2 == 0:
            self._low = value
        else:
            self.storage[offset // 8] = value << 32 | self._low

    def _count(self) -> None:
        self.accesses += 1
        if self.accesses == self.error_at and self.bus_error is not None:
            self.bus_error()

    def stop(self, fault: Fault) -> None:
        """Have the operation control report a fault."""
        self.port._stop(fault)  # what the RTL does by itself

    def flip(self, address: int, bit: int) -> None:
        """Change one bit of a word of the storage."""
        self.storage[address] = self.storage.get(address, 0) ^ 1 << bit

    def written(self, stage: str) -> list[int]:
        """Addresses of the words that a stage leaves."""
        lists = [self.homes[name][1].tolist() for name in _core.stages()[stage].writes if name in self.homes]
        return [address for addresses in lists for address in addresses]


def _width(engine: Engine) -> int:
    from orbsoc.rtl.c_image import _code_width

    return _code_width(engine, "flat")


class Partitioned(CSolver):
    """The exported program with a partition, on a stand-in."""

    def __init__(
        self, folder: Path, problem: Problem, settings: Settings, partition: str, fp: int = 64, engine: Engine | None = None,
    ) -> None:  # fmt: skip
        split = load_partition(partition)
        chosen = engine or Engine(fp=fp, lanes=2, banks=8)  # type: ignore[arg-type]
        orbsoc.export_c(problem, folder, settings=settings, fp=fp, partition=split, engine=chosen)
        super().__init__(_built(folder, problem, settings, fp), problem, tables_of(problem, settings), fp)
        self.pl = StandIn(problem, settings, chosen, split)
        self.pl.bus_error = self.library.pl_bus_error
        self._hooks = hooked(self.library, lambda: self.pl)  # another may take its place
        assert self.attach() == 0

    def attach(self, polls: int = 50, patience: int = 400) -> int:
        return int(self.library.pl_attach(self._solver(), polls, patience))

    def _solver(self) -> ctypes.c_void_p:
        return ctypes.c_void_p(self.library.harness_solver())

    @property
    def place(self) -> str:
        names = ("on core", "on device", "second try", "fell back")
        return names[self.library.pl_place(self._solver())]

    @property
    def events(self) -> tuple[int, int]:
        """Why the first and the second try on the device were not believed."""
        first, second = (int(self.library.pl_event(self._solver(), k)) for k in (0, 1))
        return first, second

    def solve(self, start: Any = None) -> dict[str, Any]:
        """As of the core alone; the stand-in counts the tries of this solve."""
        self.pl.tries, self.pl.error_at = 0, -1
        return super().solve(start)


def hooked(library: ctypes.CDLL, pl: Callable[[], StandIn]) -> tuple[Any, Any]:
    """Have the accesses of a driver end at the stand-in of the moment, as long as what is returned is kept."""
    hooks = _READ(lambda address: pl().read(address)), _WRITE(lambda a, v: pl().write(a, v))
    for name, hook in zip(("read_hook", "write_hook"), hooks, strict=True):
        ctypes.c_void_p.in_dll(library, name).value = ctypes.cast(hook, ctypes.c_void_p).value
    return hooks


def _built(folder: Path, problem: Problem, settings: Settings, fp: int) -> Path:
    made = folder / "program.so"
    bits = tables_of(problem, settings).index_bits
    macros = [f"-DORBSOC_FP={fp}", f"-DORBSOC_INDEX_BITS={bits}", "-DORBSOC_EXTERNAL_ACCESS"]
    own = [ROOT / "tests" / "flight" / "harness.c", ROOT / "tests" / "flight" / "pl_harness.c"]
    files = [
        *folder.glob("flight/*.c"),
        *folder.glob("driver/*.c"),
        folder / "pattern.c",
        folder / "pl_program.c",
        *own,
    ]
    command = ["gcc", *STRICT, "-O1", *macros, f"-I{folder}/flight", f"-I{folder}/driver", f"-I{folder}", "-shared",
               "-fPIC", *map(str, files), "-lm", "-o", str(made)]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return made


assert BUFFERS == 64
