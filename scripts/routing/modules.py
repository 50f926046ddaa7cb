"""What is placed and routed: modules with their parameters, the files they are made of, and the rows of the record."""

from __future__ import annotations

import hashlib
import importlib.util
from dataclasses import dataclass
from pathlib import Path

from scripts.record_synthesis import FORMATS, ROOT, digest

TILES = ("-DPRODUCT_WIDE=18", "-DPRODUCT_NARROW=18")
"""The multiplier block takes 18 by 18 bits."""


def _engine(fp: int, lanes: int, sequencer: int, clusters: int | None = None) -> str:
    """`clusters`: one a lane by default."""
    clusters = clusters or lanes
    split = f" CLUSTERS={clusters}" if clusters > 1 else ""
    store = f"BANKS={4 * lanes}{split} ADDRESS_BITS=12 CODE_BITS=10"
    return f"FP={fp} LANES={lanes} {store} SEQUENCER={sequencer} CHECKS=0"


UNITS = [(unit, width) for width in FORMATS for unit in ("fp_add", "fp_mul", "fp_divsqrt")]
LANES = [("lane", width) for width in FORMATS]
FLAT, COMPRESSED = 0, 1
ENGINES = [
    ("engine", _engine(*shape))
    for shape in ((64, 1, FLAT), (32, 1, FLAT), (32, 4, FLAT), (64, 1, COMPRESSED))
]
"""Bits of a word, lanes, each in a cluster of its own, microcode. The default store of 2^17 flat words fits no such part."""
SHAPES = [
    ("engine", _engine(*shape))
    for shape in (
        (64, 4, FLAT),
        (32, 2, FLAT),
        (64, 2, FLAT),
        (32, 2, FLAT, 1),
        (32, 4, COMPRESSED),
        (32, 8, FLAT),
    )
]
"""For the clock as a function of the shape, from one seed each, as four lanes of f64 take nextpnr three quarters of an hour. Clusters
are one a lane but where the fourth figure says another number."""
UNFINISHED_MIN = {_engine(64, 4, COMPRESSED): 81, _engine(64, 4, COMPRESSED, 1): 70}
"""Engines on the ECP5 that nextpnr was given these minutes of a processor for, seed 1, without an end (29 November 2026). The
second is the default engine of the model."""
ROWS = [
    *(("ecp5_85_8", *unit, seed) for unit in (*UNITS, *LANES) for seed in range(1, 6)),
    *(("ecp5_85_8", *engine, seed) for engine in ENGINES for seed in range(1, 4)),
    *(("ecp5_85_8", *engine, 1) for engine in SHAPES),
    ("ecp5_85_8", "sequencer_compressed", "LANES=1 ADDRESS_BITS=12 CODE_BITS=10 FETCH=64", 1),
    *(
        ("ecp5_85_8", "sequencer_compressed", "LANES=4 ADDRESS_BITS=12 CODE_BITS=10 FETCH=128", seed)
        for seed in range(1, 4)
    ),
    ("ecp5_85_8", "axi_stream", "PORTS=2 FETCH=128 BEAT=64 CODE_BITS=17", 1),
    *(("ecp5_85_8", "picorv32_axi", "TWO_CYCLE_ALU=1", seed) for seed in range(1, 6)),
    *(("lifcl_40_9", *unit, seed) for unit in (*UNITS, *LANES) for seed in range(1, 6)),
    ("lifcl_40_9", *ENGINES[1], 1),
    *(("lifcl_40_9", "picorv32_axi", "TWO_CYCLE_ALU=1", seed) for seed in range(1, 6)),
]
"""Part, module, parameters, seed. On the Nexus one engine, f32 with flat microcode. `picorv32_axi` is no module of ours: its authors
print its clocks on the vendor's parts."""


@dataclass(frozen=True, slots=True)
class Source:
    """What a module is made of: the folder of its files, yosys' command, a digest, and the name of its clock."""

    folder: Path
    read: str
    digest: str
    clock: str = "clock"


_SHARED = tuple(f"fpu/fp_{part}.sv" for part in ("delay", "leading_zeros", "round", "shift_sticky"))
_ADD, _MULTIPLY = "fpu/fp_add.sv", ("fpu/fp_mul.sv", "fpu/fp_product.sv")
MADE_OF = {
    "engine": ("fpu/*.sv", "engine/*.sv*"),
    "lane": (*_SHARED, _ADD, *_MULTIPLY, "fpu/fp_less.sv", "engine/lane.sv", "engine/operations.svh"),
    "fp_add": (*_SHARED, _ADD),
    "fp_mul": (*_SHARED, *_MULTIPLY),
    "fp_divsqrt": (*_SHARED, "fpu/fp_divsqrt.sv"),
    "axi_stream": ("axi/axi_stream*.sv",),
    "sequencer_compressed": (
        "engine/sequencer_compressed.sv", "engine/compressed_*.sv", "engine/window.sv", "engine/operations.svh",
    ),
}  # fmt: skip
"""The files of a module beside the parameters. Tools read no others: the names that they invent, and with them the placement,
would follow those too."""


def source_of(module: str) -> Source:
    """Ours are of rtl/; the foreign core is of the package that requirements/route.txt pins."""
    if module == "picorv32_axi":
        package = importlib.util.find_spec("pythondata_cpu_picorv32")
        if package is None or package.origin is None:
            raise SystemExit("pythondata-cpu-picorv32 is not there: pip install -r requirements/route.txt")
        folder = Path(package.origin).parent / "verilog"
        state = hashlib.sha256((folder / "picorv32.v").read_bytes()).hexdigest()[:16]
        return Source(folder, "read_verilog picorv32.v", state, clock="clk")
    files = (pattern.removesuffix("*") for pattern in MADE_OF[module] if not pattern.endswith(".svh"))
    read = f"read_verilog -sv {' '.join(TILES)} -I. contract.sv {' '.join(files)}"
    return Source(ROOT / "rtl", read, digest("*.sv*", *MADE_OF[module]))
