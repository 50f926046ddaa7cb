"""Link times against the published Zynq-7000 measurements, on clocks that the fit saw and on clocks that it did not."""

from __future__ import annotations

from statistics import median

import pytest

from hw_model.platform.platform import load_platform
from hw_model.timing import link, link_fit
from hw_model.vocabulary import Side

LINK = load_platform("xc7z045").link
SIZE = 64 * 1024
LINE = 32


def test_the_preset_is_the_fit() -> None:
    """To the digits that the preset file shows."""
    for name, value in link_fit.fit().items():
        assert getattr(LINK, name).value == pytest.approx(value, rel=4e-3), name


def test_the_figures_are_those_that_were_published() -> None:
    published = {
        "register_read_ns": [272, 202, 171, 149, 137], "register_write_ns": [59] * 5,
        "core_write_mb_s": [96, 191, 273, 382, 477], "core_read_mb_s": [76, 152, 210, 253, 282],
        "dma_to_pl_mb_s": [127, 252, 357, 470], "dma_to_ps_mb_s": [109, 217, 307, 427],
    }  # fmt: skip
    for quantity, values in published.items():
        assert [point.measured for point in link_fit.judge(LINK) if point.quantity == quantity] == values


@pytest.mark.parametrize("held_out", [False, True])
def test_the_link_meets_the_measurements_also_where_it_was_not_fitted(held_out: bool) -> None:
    points = [point for point in link_fit.judge(LINK) if point.held_out == held_out]
    assert {point.pl_clock_mhz for point in points} == ({100, 200} if held_out else {50, 150, 250})
    errors = [abs(point.error) for point in points]
    assert median(errors) <= 0.05
    assert max(errors) <= 0.20


def test_held_out_clocks_take_no_part_in_the_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    before = link_fit.fit()
    figures = link_fit.measurements()
    for quantity in ("register_read_ns", "core_write_mb_s", "core_read_mb_s", "dma_to_pl_mb_s"):
        rows = figures[quantity]
        spoilt = [
            value * (10 if mhz in figures["held_out_mhz"] else 1)
            for mhz, value in zip(rows["mhz"], rows["value"], strict=True)
        ]
        monkeypatch.setitem(rows, "value", spoilt)
    assert link_fit.fit() == before


def test_a_small_buffer_goes_by_a_core_a_large_one_by_dma() -> None:
    write_ns = LINK.core_write_ns_per_byte.value + LINK.core_write_pl_cycles_per_byte.value * 1000 / 150
    assert link.copy(LINK, 150.0, 8, "pl", LINE) == link.Copy("core", 59_000 + round(4000 * write_ns), 0)
    assert link.copy(LINK, 150.0, 7, "pl", LINE) == link.copy(
        LINK, 150.0, 8, "pl", LINE
    )  # a started word is whole
    assert link.copy(LINK, 150.0, 4, "ps", LINE).picoseconds == link.register_read(LINK, 150.0)
    large = link.copy(LINK, 150.0, SIZE, "pl", LINE)
    assert (large.method, large.cache_picoseconds) == ("dma", 2048 * 25_000)
    assert link.copy(LINK, 150.0, SIZE + 1, "ps", LINE).cache_picoseconds == 2049 * 12_000


def test_a_fast_pl_clock_is_held_back_by_the_port() -> None:
    # 1200 MB/s · 0.75 = 0.9 bytes/ns, less than 2.478 bytes a cycle at 1000 MHz.
    assert link.dma(LINK, 1000.0, SIZE, "pl") == round((1960 + SIZE / 0.9) * 1000)


@pytest.mark.parametrize(("to", "cached"), [("pl", 8192), ("ps", 0)])
def test_the_beginning_of_a_transfer_may_take_more(to: Side, cached: int) -> None:
    """Its first burst of 128 bytes either way, to the PL also the first 8 KiB."""
    platform = load_platform("xc7z045")
    dearer = platform.with_values(
        {"link.dma_first_ns_per_byte": 2.0, "link.dma_cached_ns_per_byte": 0.5}
    ).link
    for size in (8, 128, 136, 8192, 8200, SIZE):
        more = link.dma(dearer, 150.0, size, to) - link.dma(LINK, 150.0, size, to)
        assert more == pytest.approx(1000 * (2.0 * min(size, 128) + 0.5 * min(size, cached)), abs=1)


@pytest.mark.parametrize("to", ["pl", "ps"])
def test_a_larger_buffer_never_takes_less(to: Side) -> None:
    copies = [link.copy(LINK, 150.0, size, to, LINE) for size in range(1, 40_000, 37)]
    times = [copy.picoseconds + copy.cache_picoseconds for copy in copies]
    assert times == sorted(times)
    assert {copy.method for copy in copies} == {"core", "dma"}


def test_confirmation_reads_one_flag_word_per_32_buffers() -> None:
    read = link.register_read(LINK, 150.0)
    counts = [link.confirmation(LINK, 150.0, buffers) // read for buffers in (1, 32, 33, 64, 65)]
    assert counts == [2, 2, 3, 3, 4]
