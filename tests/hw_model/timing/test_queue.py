"""Problems that follow one another through cores, engines and sets of buffers."""

from __future__ import annotations

import pytest

from hw_model.timing.queue import Line, Resource, period

Chain = list[tuple[Resource, int]]
BOTH: Chain = [("ps", 10), ("pl", 10), ("ps", 10)]


def test_one_at_a_time_takes_the_whole_chain() -> None:
    assert period(BOTH, Line(sets=1), 4) == 30.0


def test_the_ps_works_ahead_until_the_engine_is_always_busy() -> None:
    """Of 8 problems for each that is under way, the first waits for its 10 before the engine, the last for those after it."""
    assert period(BOTH, Line(sets=1, ahead=3), 4) == pytest.approx((10 + 32 * 10 + 10) / 32)


def test_one_core_bounds_two_engines() -> None:
    assert period(BOTH, Line(sets=2, engines=2, ahead=2), 1) == pytest.approx(20.0, rel=0.05)


@pytest.mark.parametrize("engines", [1, 2, 3])
def test_engines_share_the_work(engines: int) -> None:
    assert period([("pl", 12)], Line(engines, engines), 1) == 12.0 / engines


def test_a_set_is_held_while_the_ps_works_between_two_segments() -> None:
    between: Chain = [("pl", 10), ("ps", 10), ("pl", 10)]
    assert period(between, Line(sets=1, ahead=4), 4) == 30.0
    assert period(between, Line(sets=2), 4) == pytest.approx(20.0, rel=0.05)


def test_a_set_that_is_not_free_yet_is_not_taken_early() -> None:
    """The second problem is ready at 3, while the first holds the only set to 104."""
    late: Chain = [("ps", 3), ("dma", 1), ("pl", 100)]
    assert period(late, Line(sets=1, ahead=1), 2) >= 101.0


def test_nothing_takes_no_time() -> None:
    assert period([], Line(sets=1), 1) == 0.0
