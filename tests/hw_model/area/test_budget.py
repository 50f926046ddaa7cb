"""The budget: monotonic in the engine, and nothing taken without a PL."""

from __future__ import annotations

import itertools

import pytest

from hw_model.area.budget import Budget, budget, engine_shape
from hw_model.area.engine import Shape, fabric_of, line_bits, parity_area, parity_logic
from hw_model.area.fabric import FABRICS, KINDS
from hw_model.errors import HwModelError
from hw_model.platform.partition import load_partition
from hw_model.platform.platform import Platform, load_platform
from hw_model.report.assumptions import assumptions
from hw_model.report.loading import Loading, loading
from hw_model.report.usage import BUDGET_USAGE
from hw_model.timing.stage_cycles import Microcode, PlCycles, estimated
from hw_model.timing.trace import Trace, parse_trace
from tests.hw_model.synthetic import synthetic_trace

TRACE = parse_trace(synthetic_trace(iterations=2))


def test_nothing_is_taken_when_nothing_is_on_the_pl() -> None:
    found = budget(TRACE, load_platform("xc7z020"), load_partition("all_ps"))
    assert [use.used for use in found.uses] == [0] * len(KINDS)
    assert found.fits


@pytest.mark.parametrize("key", ["pl.lanes", "pl.dividers", "pl.banks"])
def test_more_of_anything_takes_no_less(key: str) -> None:
    partition = load_partition("paper")
    counts = [budget(TRACE, load_platform("zu9eg").with_value(key, n), partition) for n in (1, 2, 4)]
    for kind in ("lut", "ff", "dsp"):
        used = [found.of(kind).used for found in counts]
        assert used == sorted(used)
    assert counts[0].of("lut").used < counts[-1].of("lut").used


def test_single_precision_takes_less_of_everything() -> None:
    single = parse_trace(synthetic_trace(iterations=2, datapath="f32"))
    wide, narrow = (
        budget(trace, load_platform("zu9eg"), load_partition("paper")) for trace in (TRACE, single)
    )
    for kind in ("lut", "ff", "dsp", "bram36"):
        assert narrow.of(kind).used < wide.of(kind).used, kind
    assert (wide.of("dsp").used, narrow.of("dsp").used) == (4 * 11, 4 * 2)


def test_a_small_device_overflows_and_the_tightest_resource_is_named() -> None:
    platform = load_platform("xc7z020").with_value("pl.lanes", 16)
    found = budget(TRACE, platform, load_partition("paper"))
    assert not found.fits
    assert found.tightest.share / found.tightest.ceiling == max(use.share / use.ceiling for use in found.uses)
    assert not found.tightest.fits
    assert found.of("dsp").used == 176


def test_fewer_modules_need_less_storage_and_microcode() -> None:
    platform = load_platform("zu9eg")
    whole, part = (budget(TRACE, platform, load_partition(name)) for name in ("paper", "factor_only"))
    assert part.storage_words < whole.storage_words
    assert part.microcode_words < whole.microcode_words


def test_a_decoder_saves_block_ram_and_takes_lookup_tables() -> None:
    platform, partition = load_platform("zu9eg"), load_partition("paper")
    packed, flat = (
        budget(TRACE, platform.with_value("pl.microcode_format", name), partition)
        for name in ("compressed", "flat")
    )
    assert packed.microcode_bram36 <= flat.microcode_bram36
    assert packed.of("lut").used > flat.of("lut").used
    assert packed.of("ff").used > flat.of("ff").used


@pytest.mark.parametrize("form", ["compressed", "flat"])
@pytest.mark.parametrize("device", ["zu9eg", "ng_ultra"])
def test_parity_takes_logic_and_the_spare_bits_of_block_ram(form: str, device: str) -> None:
    platform, partition = (
        load_platform(device).with_value("pl.microcode_format", form),
        load_partition("paper"),
    )
    with_parity = platform.with_value("pl.parity", "per_word")
    plain, found = (budget(TRACE, one, partition) for one in (platform, with_parity))
    shape = engine_shape(TRACE, platform, partition)
    wide = line_bits(shape) if form == "compressed" else shape.microcode_bits
    luts, flip_flops = parity_logic(shape, fabric_of(platform.area), wide)
    more = {use.kind: use.used - plain.of(use.kind).used for use in found.uses}
    assert more == {"lut": luts, "ff": flip_flops, "dsp": 0, "bram36": 0, "uram": 0}
    assert (luts, flip_flops) > (400, 60)  # 4 lanes; one lane at binary64 was synthesised: 170 and 26


def test_parity_takes_block_ram_where_a_row_has_no_bit_to_spare() -> None:
    """Lines of 71 and of 72 bits; 512 of them are a block."""
    fabric = FABRICS["xc7"]
    for lanes, dividers, address_bits in itertools.product(range(1, 17), range(1, 5), range(8, 17)):
        shape = Shape("f64", lanes, dividers, 16, address_bits)
        more = parity_area(shape, fabric, 9)["bram36"]
        assert more == (0.5 if shape.microcode_bits % 36 == 0 else 0), shape


def test_counted_microcode_is_stored_as_it_is_and_an_assumed_compression_is_not_asked() -> None:
    """The estimate assumes a compression; schedules count one, and each segment begins at a line of its own."""
    platform, partition = load_platform("zu9eg"), load_partition("factor_only")

    def counted(trace: Trace, platform: Platform, pattern: int, stage: str) -> PlCycles:
        return PlCycles({"issue": 20_000}, 0, "issue", "schedule", Microcode(19_000, 5_000_000, 400_000))

    def both(by: float) -> tuple[Budget, Budget]:
        changed = platform.with_value("pl.microcode_compression", by)
        return budget(TRACE, changed, partition), budget(TRACE, changed, partition, counted)

    (assumed, four), (other, eight) = both(4.0), both(8.0)
    assert assumed.microcode_bits > other.microcode_bits
    assert four == eight
    assert (four.microcode_words, four.microcode_flat_bits, four.microcode_bits) == (
        19_000,
        5_000_000,
        400_000,
    )
    assert (assumed.microcode_origin, four.microcode_origin) == ("estimate", "schedule")


@pytest.mark.parametrize("name", ["paper", "all_ps"])
def test_a_budget_changes_with_what_it_counts_as_used_and_with_nothing_else(name: str) -> None:
    platform, partition = load_platform("zu9eg"), load_partition(name)

    def found(computer: Platform) -> tuple[Budget, Loading]:
        area = budget(TRACE, computer, partition)
        return area, loading(computer, area.programs)

    before = found(platform)
    bind = {"link.port_mb_s": 100.0, "link.ddr_efficiency": 0.01}
    steps = {
        "runtime.completion": "polling", "pl.microcode_format": "flat", "pl.storage_memory": "ultra_ram",
        "pl.storage_depth": "exact", "pl.microcode_memory": "ultra_ram", "ps.price": "executed_instructions",
        "pl.parity": "per_word",
    }  # fmt: skip
    for row in assumptions(platform, BUDGET_USAGE.of(TRACE, partition, platform, estimated)):
        if row.key.startswith("pl.latencies.") or row.key in ("runtime.schedule", "runtime.cores_used"):
            continue
        if row.key == "area.uram_ceiling":  # echoed beside a use of nothing
            continue
        value = row.value
        if isinstance(value, str):
            value = steps[row.key]
        else:
            value = value * 2 if isinstance(value, int) else bind.get(row.key, 0.5 * value + 0.5)
        if row.key == "pl.interleaved" and partition.uses_pl:
            with pytest.raises(
                HwModelError, match=r"`pl\.interleaved` = 2 under partition 'paper': only the PL's own"
            ):
                budget(TRACE, platform.with_value(row.key, value), partition)
        elif value != row.value:
            assert (found(platform.with_value(row.key, value)) == before) == (not row.used), row.key
