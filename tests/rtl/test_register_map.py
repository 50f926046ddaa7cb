"""One register map: `orbsoc.ps.registers` for Python, the driver's header and the RTL's constants; and the driver compiles."""

from __future__ import annotations

import enum
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from orbsoc.ps.registers import (
    BUFFERS,
    INSTRUCTIONS,
    PROGRAM,
    SEGMENTS,
    TABLE,
    TEMPLATES,
    Control,
    Fault,
    Op,
    Region,
    Register,
    Wrapper,
)
from scripts import write_registers
from tests.rtl.c_driver import DRIVER, STRICT
from tests.rtl.engine_sources import RTL, parameters

COMPILERS = ("gcc", "aarch64-linux-gnu-gcc", "arm-linux-gnueabihf-gcc")


def test_the_header_is_the_one_that_the_map_gives() -> None:
    assert write_registers.HEADER.read_text() == write_registers.header(), "run scripts/write_registers.py"


def constants(file: str) -> dict[str, int]:
    """Constants of a module of the RTL that are numbers."""
    text = (RTL / file).read_text()
    found = re.findall(
        r"^  localparam logic \[\d+:0\] (\w+) = \d+'([dhb])([0-9A-Fa-f]+);", text, re.MULTILINE
    )
    return {name: int(number, {"d": 10, "h": 16, "b": 2}[base]) for name, base, number in found}


def defaults(file: str) -> dict[str, int]:
    """Default values of a module's parameters."""
    text = (RTL / file).read_text()
    return {
        name: int(value) for name, value in re.findall(r"parameter int (\w+) (?:/\*.*?\*/ )?= (\d+)", text)
    }


def wanted(of: type[enum.IntEnum]) -> dict[str, int]:
    return {name: int(member) for name, member in of.__members__.items()}


def test_the_rtls_constants_are_the_maps() -> None:
    registers, wrapper, attempt = (
        constants(f"{file}.sv") for file in ("engine/registers", "axi/axi_registers", "engine/attempt")
    )
    faults = wanted(Fault)
    its_own = {name: faults.pop(name) for name in ("CYCLE_LIMIT", "STREAM_ERROR")}
    assert wanted(Register).items() <= registers.items()
    assert wanted(Control).items() <= registers.items()
    assert faults.items() <= registers.items()
    assert {"TABLE": TABLE, "PROGRAM": PROGRAM}.items() <= registers.items()
    assert wrapper == wanted(Wrapper) | its_own | {"STATUS": int(Register.STATUS)}
    assert {"END": Op.END, "RUN": Op.RUN, "IF": Op.IF}.items() <= attempt.items()
    sizes = {"SEGMENTS": SEGMENTS, "BUFFERS": BUFFERS, "INSTRUCTIONS": INSTRUCTIONS}
    assert sizes.items() <= defaults("engine/registers.sv").items()
    assert 1 << parameters()["TEMPLATE_BITS"] == TEMPLATES
    region = 1 << defaults("axi/axi_engine.sv")["REGION_BITS"]
    assert [int(each) for each in Region] == [0, region, 2 * region]


@pytest.mark.parametrize("external", ["", "-DORBSOC_EXTERNAL_ACCESS"], ids=["accesses", "external"])
@pytest.mark.parametrize("compiler", COMPILERS)
def test_the_driver_compiles_without_a_warning_and_needs_no_library(
    compiler: str, external: str, tmp_path: Path
) -> None:
    if shutil.which(compiler) is None:
        missing = f"{compiler} is not installed"
        if "ORBSOC_REQUIRE_ARM" in os.environ:
            pytest.fail(missing)
        pytest.skip(missing)
    made = tmp_path / "orbsoc.o"
    command = [compiler, *STRICT, "-O2", *filter(None, [external]), "-c", DRIVER / "orbsoc.c", "-o", made]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    undefined = subprocess.run(
        [compiler.replace("gcc", "nm") if "-" in compiler else "nm", "-u", made],
        capture_output=True, text=True, check=True,
    ).stdout.split()  # fmt: skip
    assert set(undefined) <= ({"U", "orbsoc_pl_read", "orbsoc_pl_write"} if external else set())
