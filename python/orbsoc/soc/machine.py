"""The simulated computer: built once by rtl/build.sh, run on an image."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from orbsoc.hw.schedules import Engine
from orbsoc.rtl.validation import SEQUENCERS, Format

from .errors import SocError

if TYPE_CHECKING:
    from .faults import Fault

REGISTERS, MEMORIES = 0x2000_0000, 0x3000_0000
"""Where the core sees the engine's two ports (rtl/soc/soc.sv)."""
_SMALLEST = {"LANES": 1, "BANKS": 4, "ADDRESS_BITS": 4, "CODE_BITS": 4}
"""An engine for the core alone: it is there and never launched."""
_CODE_BITS = 17
"""Room for microcode at least, 2^17 lines, so that programs share a model: no clock depends on it."""


@dataclass(frozen=True, slots=True)
class Waveform:
    """Wires of our RTL and the core's ports, from a clock of the core on, for `clocks`; an FST file, for GTKWave or Surfer."""

    file: Path
    first: int
    clocks: int

    @property
    def arguments(self) -> list[str]:
        """As the harness takes them."""
        return [f"+trace={self.file}", f"+trace_from={self.first}", f"+trace_clocks={self.clocks}"]


@dataclass(frozen=True, slots=True)
class Machine:
    """An executable of the simulation."""

    harness: Path

    @classmethod
    def built(
        cls, rtl: Path, engine: Engine | None, form: Format, code_lines: int, *, traced: bool = False
    ) -> Machine:
        """From the cache of rtl/build.sh, which takes minutes the first time. `traced`: it can write waveforms. Raises SocError."""
        parameters = dict(_SMALLEST)
        if engine is not None:
            parameters = {
                "FP": engine.fp, "LANES": engine.lanes, "DIVIDERS": engine.dividers, "BANKS": engine.banks,
                "CLUSTERS": engine.clusters, "ADDRESS_BITS": engine.address_bits or 0, "SEQUENCER": SEQUENCERS[form],
                "CODE_BITS": max(_CODE_BITS, (code_lines - 1).bit_length()),
            }  # fmt: skip
        done = subprocess.run(
            ["sh", rtl / "build.sh", "soc_trace" if traced else "soc", *(f"-G{name}={value}" for name, value in parameters.items())],
            env=os.environ | {"ORBSOC_ROCKET": str(core_sources())}, capture_output=True, text=True, check=False,
        )  # fmt: skip
        if done.returncode != 0:
            raise SocError(f"the computer does not build: {done.stderr.strip()[-2000:]}")
        return cls(Path(done.stdout.strip().splitlines()[-1]))

    @staticmethod
    def reset_clocks(ratio: float) -> int:
        """Clocks of the core before its own counter starts (rtl/harness/soc.cpp)."""
        return int(64 * ratio) + 1

    def run(
        self,
        image: Path,
        *,
        ratio: float,
        latency: int,
        limit: int = 0,
        fault: Fault | None = None,
        waveform: Waveform | None = None,
    ) -> Iterator[str]:
        """The lines of the program's console, as they come. `ratio`: core clocks a clock of the engine, from 1; `latency` of
        memory in core clocks; `limit` on core clocks, 0 for none. Raises SocError when the program fails or the limit is met."""
        command = [
            str(self.harness),
            f"+image={image}",
            repr(ratio),
            str(latency),
            str(limit),
            *(fault.arguments if fault else []),
            *(waveform.arguments if waveform else []),
        ]
        last = ""
        with subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        ) as process:
            assert process.stdout is not None
            try:
                for line in process.stdout:
                    last = line.rstrip()
                    yield last
                process.wait()
            finally:
                process.kill()
        if process.returncode != 0:
            ended = "its limit of clocks" if process.returncode == 124 else f"code {process.returncode}"
            raise SocError(f"the program ended with {ended}; its last line: {last}")


def core_sources() -> Path:
    """Folder of the core's generated Verilog. Raises SocError where its package is missing."""
    try:
        import pythondata_cpu_rocket
    except ImportError:
        raise SocError("the core's RTL is not installed: pip install 'orbsoc[soc]'") from None
    return Path(pythondata_cpu_rocket.data_location)
