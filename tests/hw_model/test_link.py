"""Link times against the published Zynq-7000 measurements that they were drawn through."""

from __future__ import annotations

from statistics import median

import pytest

from hw_model import link
from hw_model.platform import load_platform
from hw_model.vocabulary import Side

LINK = load_platform("xc7z045").link
READ_NS = {50: 272, 100: 202, 150: 171, 200: 149, 250: 137}
DMA_MB_S: dict[int, tuple[int, int]] = {50: (127, 109), 100: (252, 217), 150: (357, 307), 200: (470, 427)}
SIZE = 64 * 1024


def _errors() -> list[float]:
    reads = [link.register_read(LINK, mhz) / 1000 / ns - 1 for mhz, ns in READ_NS.items()]
    dma: list[float] = []
    for mhz, measured in DMA_MB_S.items():
        sides: tuple[Side, Side] = ("pl", "ps")
        for to, mb_s in zip(sides, measured, strict=True):
            found = link.copy(LINK, mhz, SIZE, to)
            assert found.method == "dma"
            dma.append(SIZE / (found.picos * 1e-6) / mb_s - 1)
    return reads + dma


def test_registers_and_dma_meet_the_measurements() -> None:
    errors = [abs(error) for error in _errors()]
    assert median(errors) <= 0.03
    assert max(errors) <= 0.05


def test_a_small_buffer_goes_by_registers_a_large_one_by_dma() -> None:
    assert link.copy(LINK, 150.0, 8, "pl") == link.Copy("registers", 2 * 59_000)
    assert link.copy(LINK, 150.0, 7, "pl").picos == 2 * 59_000  # a started word costs a whole one
    assert link.copy(LINK, 150.0, 4096, "pl").method == "dma"


def test_a_fast_pl_clock_is_held_back_by_the_port() -> None:
    # 1200 MB/s · 0.75 = 0.9 bytes/ns, less than 2.47 bytes a cycle at 1000 MHz.
    assert link.copy(LINK, 1000.0, SIZE, "pl").picos == round((1960 + SIZE / 0.9) * 1000)


@pytest.mark.parametrize("to", ["pl", "ps"])
def test_a_larger_buffer_never_takes_less(to: Side) -> None:
    times = [link.copy(LINK, 150.0, size, to).picos for size in range(1, 3000, 7)]
    assert times == sorted(times)


def test_confirmation_reads_one_flag_word_per_32_buffers() -> None:
    read = link.register_read(LINK, 150.0)
    assert [link.confirmation(LINK, 150.0, buffers) // read for buffers in (1, 32, 33, 64, 65)] == [
        2,
        2,
        3,
        3,
        4,
    ]
