"""NG-Ultra: the area formula, in its cells, against what open synthesis makes of the RTL there."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import pytest

from hw_model.area.engine import decoder_luts, engine_area, fabric_of, line_bits, stream_area
from hw_model.area.fabric import multiplier_dsp
from hw_model.area.synthesis import Synthesis, is_resident, recorded, shape_of
from hw_model.platform.platform import load_platform
from scripts.record_synthesis import NG_ULTRA, rtl_digest
from tests.rtl.verilator import require_route_tools

ROOT = Path(__file__).resolve().parents[3]
PLATFORM = load_platform("ng_ultra")
AREA = PLATFORM.area
FABRIC = fabric_of(AREA)
ROWS = recorded(NG_ULTRA.record)
ENGINES = [row for row in ROWS if row.module == "engine"]
LUT_ERROR, FF_ERROR = 0.10, 0.03


def _text(row: Synthesis) -> str:
    return " ".join(f"{key}={value}" for key, value in row.parameters.items())


def test_the_record_is_of_the_rtl_as_it_stands() -> None:
    record = json.loads(NG_ULTRA.record.read_text())
    assert (record["rtl"], record["family"]) == (rtl_digest(), "ultra"), (
        "the RTL has changed: run `make route`"
    )
    assert [(row.module, _text(row)) for row in ROWS] == NG_ULTRA.modules


def test_a_unit_synthesised_anew_has_the_cells_on_record() -> None:
    (row,) = (row for row in ROWS if row.module == "fp_add" and row.parameters["MAN"] == 23)
    chosen = os.environ | {"FAMILY": "ultra", "YOSYS": str(require_route_tools())}
    command = [str(ROOT / "rtl" / "synthesize.sh"), "fp_add", *_text(row).split()]
    made = json.loads(subprocess.run(command, check=True, capture_output=True, text=True, env=chosen).stdout)
    assert (made["lut"], made["ff"], made["dsp"]) == (row.lut, row.ff, row.dsp)


@pytest.mark.parametrize("row", ENGINES, ids=_text)
def test_the_formula_says_what_synthesis_found(row: Synthesis) -> None:
    said = engine_area(shape_of(row), AREA, row.parameters["CODE_BITS"], resident=is_resident(row))
    assert said["dsp"] == row.dsp
    assert said["bram36"] == pytest.approx(row.bram36, abs=1e-3)
    assert abs(said["ff"] / row.ff - 1) <= FF_ERROR
    assert abs(said["lut"] / row.lut - 1) <= LUT_ERROR


def test_engines_that_nothing_was_fitted_to_are_on_record() -> None:
    held_out = [row for row in ENGINES if not row.fitted]
    assert {shape_of(row).lanes for row in held_out} >= {2, 4}
    assert any(shape_of(row).clusters > 1 for row in held_out)
    assert {shape_of(row).datapath for row in held_out} == {"f64", "f32"}


@pytest.mark.parametrize(("mantissa", "bits"), [(52, 53), (23, 24)])
def test_a_product_takes_as_many_blocks_as_on_7_series(mantissa: int, bits: int) -> None:
    (row,) = (row for row in ROWS if row.module == "fp_mul" and row.parameters["MAN"] == mantissa)
    assert row.dsp == multiplier_dsp(bits)


@pytest.mark.parametrize(
    ("rows", "bits", "blocks"), [(1024, 64, 3), (2048, 48, 2), (4096, 64, 6), (2049, 24, 2), (8192, 7, 2)]
)
def test_a_memory_takes_blocks_of_48_kbit_in_its_best_shape(rows: int, bits: int, blocks: int) -> None:
    assert FABRIC.bram36(rows, bits) == pytest.approx(blocks * 2 / 3)


@pytest.mark.parametrize("lanes", [2, 4])
def test_a_decoder_takes_what_synthesis_found(lanes: int) -> None:
    (row,) = (r for r in ROWS if r.module == "sequencer_compressed" and r.parameters["LANES"] == lanes)
    (four,) = (shape_of(r) for r in ENGINES if shape_of(r).lanes == 4 and shape_of(r).datapath == "f64")
    shape = shape_of(next(r for r in ENGINES if shape_of(r).lanes == lanes))
    more = line_bits(four) - line_bits(
        shape
    )  # the decoder on record has the longer lines with two lanes, too
    luts = decoder_luts(shape, AREA) + more * AREA.lut_decoder_per_line_bit.value
    assert abs(luts / row.lut - 1) <= LUT_ERROR


def test_what_streams_microcode_takes_what_synthesis_found() -> None:
    rows = [row for row in ROWS if row.module == "axi_stream"]
    assert [row.parameters["PORTS"] for row in rows] == [1, 2, 4]
    for row in rows:
        said = stream_area(row.parameters["PORTS"], row.parameters["FETCH"], AREA)
        assert said["lut"] == pytest.approx(row.lut, rel=0.01)
        assert said["ff"] == pytest.approx(row.ff, rel=0.01)
        assert said["bram36"] == pytest.approx(row.bram36)


def test_the_device_has_what_the_open_database_lists() -> None:
    """1316 tiles of 384 LUT and 384 flip-flops, half as many RAM blocks as DSP; the wider LUTs beside them are not counted."""
    there = PLATFORM.resources
    assert there.lut.value == there.ff.value == 1316 * 384
    assert (there.dsp.value, there.bram36.value) == (1344, 1344 // 2 * 2 // 3)
