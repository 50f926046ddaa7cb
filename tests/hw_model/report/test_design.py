"""The front of a search, and the paper's place."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from hw_model import load_partition, load_platform
from hw_model.figures.design import design_figure
from hw_model.report.design import Row, Standing, front_of
from hw_model.report.study import Study
from tests.hw_model.report.test_best import TRACE

PLATFORM = load_platform("zu9eg")
(POINT,) = Study(TRACE).points(PLATFORM, [load_partition("paper")])
PAPER = replace(Row.of(POINT, "amd", PLATFORM), baseline_ms=100.0)
PAIRS = st.lists(st.tuples(st.integers(1, 9), st.integers(1, 12)), min_size=1, max_size=20)


@given(PAIRS)
def test_the_front_has_every_design_that_no_other_beats(pairs: list[tuple[int, int]]) -> None:
    rows = [
        replace(PAPER, time_ms=float(time), area_share=area / 10.0, baseline_ms=8.0) for time, area in pairs
    ]
    front = {(row.time_ms, row.area_share) for row in front_of(rows)}
    fitting = {(row.time_ms, row.area_share) for row in rows if row.fits and row.time_ms < 8.0}
    assert front == {
        one for one in fitting if not any(o != one and o[0] <= one[0] and o[1] <= one[1] for o in fitting)
    }


def test_the_papers_design_is_judged_against_the_front() -> None:
    faster = replace(PAPER, time_ms=0.5 * PAPER.time_ms)
    smaller = replace(PAPER, area_share=0.5 * PAPER.area_share)
    beaten = Standing.of(PAPER, front_of([faster, smaller]))
    assert not beaten.on_the_front
    assert (beaten.fastest, beaten.smallest) == (faster, smaller)
    assert f"with no more area {faster.time_ms:.3f} ms are possible" in beaten.words
    alone = Standing.of(PAPER, front_of([PAPER]))
    assert alone.on_the_front
    assert alone.words.endswith(": on the front")
    slow = Standing.of(replace(PAPER, baseline_ms=0.9 * PAPER.time_ms), [])
    assert "SLOWER than the PS alone" in slow.words
    assert not slow.on_the_front
    assert "does NOT FIT" in Standing.of(replace(PAPER, area_share=1.5), []).words


def test_the_figure_is_drawn(tmp_path: Path) -> None:
    design_figure([PAPER], [PAPER], PAPER, "Designs", tmp_path / "design.png")
    assert (tmp_path / "design.png").read_bytes().startswith(b"\x89PNG")
