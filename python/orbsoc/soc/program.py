"""A problem's flight code as an image for the core's memory."""

from __future__ import annotations

import hashlib
import random
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from orbsoc.flight.export import export_c
from orbsoc.hw.schedules import Engine
from orbsoc.hw.workload import Posed
from orbsoc.rtl.validation import Format

from .errors import SocError
from .machine import MEMORIES, REGISTERS

COMPILER = "riscv64-unknown-elf-gcc"
FLAGS = (
    "--specs=picolibc.specs", "-O3", "-march=rv64gc", "-mabi=lp64d", "-mcmodel=medany", "-nostartfiles",
    "-ffp-contract=off", "-fno-math-errno", "-Wl,--no-warn-rwx-segments",
)  # fmt: skip
"""-fno-math-errno: `sqrt` is the core's instruction. No flag changes a bit."""
_OF_THE_PL = ("dma.c", "device_counts.c", "interrupts.c", "vector.S")
WRAPPED = ("orbsoc_run", "orbsoc_solve", "orbsoc_attach")


@dataclass(frozen=True, slots=True)
class Target:
    """A core that programs are linked for: the compiler's flags, the functions that its board's program is around, bytes of a
    word of its memory's image, and sources whose objects, *.link.o, have a place of their own in its script."""

    flags: tuple[str, ...]
    wrapped: tuple[str, ...]
    word_bytes: int
    of_the_link: tuple[str, ...] = ()


ROCKET = Target(FLAGS, WRAPPED, 8, ("orbsoc.c", "orbsoc_device.c", *_OF_THE_PL))
"""What drives the PL has lines of the caches of its own: what a launch and an interrupt take depends little on where the rest lies."""


@dataclass(frozen=True, slots=True)
class Program:
    """An image and the engine that its partition needs; none for the core alone."""

    image: Path
    key: str
    """Of all that it was made from: the same key, the same run."""
    engine: Engine | None
    form: Format
    code_lines: int


def compiled(
    posed: Posed,
    rtl: Path,
    cache: Path,
    *,
    partition: str | None,
    engine: Engine,
    form: Format = "compressed",
    patience: int | None = None,
    limit_clocks: int | None = None,
    warm: bool = True,
    events: bool = False,
    order: int = 0,
) -> Program:
    """The flight code for a problem with its self-test, compiled; kept in `cache`. `patience`: rounds of about 4000 clocks
    that a launch may take, the driver's own by default; `limit_clocks`: of the PL, the program's own by default. Without `warm`, the solve from a point nearby is left out.
    With `events` it prints when each part ran. `order`: a seed by which its files are linked in another order, so that code and data lie elsewhere.
    Raises SocError without a compiler, and what `export_c` raises."""
    if shutil.which(COMPILER) is None:
        raise SocError(
            f"{COMPILER} is not installed: apt-get install gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf"
        )
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "program"
        export_c(
            posed.problem,
            folder,
            settings=posed.settings,
            fp=engine.fp,
            partition=partition,
            engine=engine,
            form=form,
        )
        on_pl = (folder / "pl_program.c").is_file()
        sources = sorted(folder.glob("*.c")) + sorted(folder.glob("*/*.c"))
        board = [
            rtl / "soc" / "program" / name
            for name in ("start.S", "traps.c", "console.c", "counts.c", *(_OF_THE_PL if on_pl else ()))
        ]
        defines = [
            f"-DORBSOC_FP={engine.fp}",
            "-DORBSOC_SHORT_SELFTEST",
            *([] if warm else ["-DORBSOC_COLD_SELFTEST"]),
            *(["-DEVENTS"] if events else []),
            *([f"-DPATIENCE={patience}u"] if patience and on_pl else []),
            *([f"-DLIMIT={limit_clocks}u"] if limit_clocks is not None and on_pl else []),
        ]
        script = rtl / "soc" / "program" / "link.ld"
        headers = sorted((rtl / "soc" / "program").glob("*.h"))
        files = [*sources, *board]
        if order:
            random.Random(order).shuffle(files)
        key = _digest(defines, [*files, *sorted(folder.glob("**/*.h")), *headers, script])
        image = cache / f"program-{key}.hex"
        if not image.exists():
            linked(folder, files, script, defines, image, on_pl=on_pl)
        if not on_pl:
            return Program(image, key, None, form, 0)
        address_bits, lines = _sizes((folder / "pl_program.c").read_text(encoding="utf-8"))
        return Program(image, key, replace(engine, address_bits=address_bits), form, lines)


def _sizes(source: str) -> tuple[int, int]:
    """Address bits of the engine and lines of microcode, as the program states them."""
    found = re.search(
        r"orbsoc_pl_image program = \{\s*\du, (\d+)u, \d+u,\s*program_microcode, (\d+)u", source
    )
    assert found is not None
    return int(found[1]), int(found[2])


def _digest(defines: list[str], files: list[Path]) -> str:
    digest = hashlib.sha256(" ".join((COMPILER, *FLAGS, *ROCKET.of_the_link, *defines)).encode())
    for file in files:
        digest.update(file.name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


def linked(
    folder: Path,
    sources: list[Path],
    script: Path,
    defines: list[str],
    image: Path,
    *,
    on_pl: bool,
    target: Target = ROCKET,
) -> None:
    """The image of a program from its sources; intermediate files are in `folder`. Raises SocError."""
    binary = folder / "image.bin"
    elf = folder / "image.elf"
    if on_pl:
        defines = [
            *defines,
            f"-DORBSOC_PL_REGISTERS=0x{REGISTERS:x}u",
            f"-DORBSOC_PL_MEMORIES=0x{MEMORIES:x}u",
        ]
    wraps = ",".join(f"--wrap={name}" for name in target.wrapped if on_pl or name != "orbsoc_attach")
    includes = [f"-I{folder / name}" for name in (".", "flight", "driver")]
    apart = ["-ffunction-sections", "-fdata-sections"] if target.of_the_link and on_pl else []
    compiling = [COMPILER, *target.flags, *apart, *defines, *includes]
    inputs = [source for source in sources if source.name not in target.of_the_link]
    for source in sorted(set(sources) - set(inputs), key=lambda source: source.name):
        inputs.append(folder / f"{source.stem}.link.o")
        _run([*compiling, "-c", str(source), "-o", str(inputs[-1])])
    _run([*compiling, f"-Wl,{wraps}", "-T", str(script), *map(str, inputs), "-o", str(elf)])
    _run([COMPILER.replace("gcc", "objcopy"), "-O", "binary", str(elf), str(binary)])
    data = binary.read_bytes()
    size = target.word_bytes
    words = np.frombuffer(data + bytes(-len(data) % size), dtype=f"<u{size}")
    image.parent.mkdir(parents=True, exist_ok=True)
    temporary = image.with_suffix(f".{folder.parent.name}")
    temporary.write_text("".join(f"{word:0{2 * size}x}\n" for word in words.tolist()))
    temporary.replace(image)


def _run(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SocError(f"the program does not compile: {done.stderr.strip()[-2000:]}")
