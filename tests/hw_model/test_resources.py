"""The budget: monotonic in the engine, and nothing taken without a PL."""

from __future__ import annotations

import pytest

from hw_model.area import KINDS
from hw_model.partition import load_partition
from hw_model.platform import load_platform
from hw_model.resources import budget
from hw_model.trace import parse_trace
from tests.hw_model.synthetic import synthetic_trace

TRACE = parse_trace(synthetic_trace(iterations=2))


def test_nothing_is_taken_when_nothing_is_on_the_pl() -> None:
    found = budget(TRACE, load_platform("xc7z020"), load_partition("all_ps"))
    assert [use.used for use in found.uses] == [0, 0, 0, 0]
    assert found.fits


@pytest.mark.parametrize("key", ["pl.lanes", "pl.dividers", "pl.banks"])
def test_more_of_anything_takes_no_less(key: str) -> None:
    split = load_partition("paper")
    counts = [budget(TRACE, load_platform("zu9eg").with_value(key, n), split) for n in (1, 2, 4, 8)]
    for kind in ("lut", "ff", "dsp"):
        used = [found.of(kind).used for found in counts]
        assert used == sorted(used)
    assert counts[0].of("lut").used < counts[-1].of("lut").used


def test_single_precision_takes_less_of_everything() -> None:
    single = parse_trace(synthetic_trace(iterations=2, datapath="f32"))
    wide, narrow = (
        budget(trace, load_platform("zu9eg"), load_partition("paper")) for trace in (TRACE, single)
    )
    for kind in KINDS:
        assert narrow.of(kind).used < wide.of(kind).used, kind
    assert (wide.of("dsp").used, narrow.of("dsp").used) == (4 * 12, 4 * 2)


def test_a_small_device_overflows_and_the_tightest_resource_is_named() -> None:
    platform = load_platform("xc7z020").with_value("pl.lanes", 16)
    found = budget(TRACE, platform, load_partition("paper"))
    assert not found.fits
    assert found.tightest.share / found.tightest.ceiling == max(use.share / use.ceiling for use in found.uses)
    assert not found.tightest.fits
    assert found.of("dsp").used == 192


def test_fewer_modules_need_less_storage_and_microcode() -> None:
    machine = load_platform("zu9eg")
    whole, part = (budget(TRACE, machine, load_partition(name)) for name in ("paper", "factor_only"))
    assert part.storage_words < whole.storage_words
    assert part.microcode_words < whole.microcode_words


def test_a_decoder_saves_block_ram_and_takes_lookup_tables() -> None:
    machine, split = load_platform("zu9eg"), load_partition("paper")
    packed, flat = (
        budget(TRACE, machine.with_value("pl.microcode_compression", by), split) for by in (4.0, 1.0)
    )
    assert packed.microcode_bram36 <= flat.microcode_bram36
    assert packed.of("lut").used > flat.of("lut").used
    assert packed.of("ff").used > flat.of("ff").used
