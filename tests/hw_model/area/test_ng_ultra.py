"""NG-Ultra: what open synthesis makes of the RTL there, and the lookup tables that the device is given by it."""

from __future__ import annotations

import json

from hw_model.area.synthesis import Synthesis, recorded
from hw_model.platform.platform import load_platform
from scripts.record_synthesis import NG_ULTRA, rtl_digest

LUTS_OF_FOUR_INPUTS = 536_928


def _unit(rows: tuple[Synthesis, ...], module: str, mantissa: int) -> Synthesis:
    (row,) = (row for row in rows if row.module == module and row.parameters["MAN"] == mantissa)
    return row


def test_the_record_is_of_the_rtl_as_it_stands() -> None:
    record = json.loads(NG_ULTRA.record.read_text())
    assert (record["rtl"], record["family"]) == (rtl_digest(), "ultra"), (
        "the RTL has changed: run `make route`"
    )
    said = [(row.module, " ".join(f"{key}={value}" for key, value in row.parameters.items())) for row in ROWS]
    assert said == NG_ULTRA.modules


ROWS = recorded(NG_ULTRA.record)


def test_the_devices_lookup_tables_are_scaled_by_the_adder_of_both_families() -> None:
    here, xc7 = _unit(ROWS, "fp_add", 52), _unit(recorded(), "fp_add", 52)
    lut = load_platform("ng_ultra").resources.lut
    assert (lut.tag, lut.value) == ("scaled", LUTS_OF_FOUR_INPUTS * xc7.lut // here.lut)
    assert abs(here.ff / xc7.ff - 1) <= 0.02  # flip-flops are one for one


def test_open_synthesis_makes_products_of_lookup_tables_and_the_device_says_that_its_dsp_are_assumed() -> (
    None
):
    here, xc7 = _unit(ROWS, "fp_mul", 23), _unit(recorded(), "fp_mul", 23)
    assert (here.dsp, xc7.dsp) == (0, 2)
    assert here.lut > 2 * xc7.lut
    assert load_platform("ng_ultra").resources.dsp.tag == "assumed"
