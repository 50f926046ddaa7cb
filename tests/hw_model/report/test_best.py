"""The partition "best", what would hold an engine, and many problems of one pattern."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

import pytest

from hw_model import PartitionError, load_partition, load_platform, parse_trace, simulate, speedup
from hw_model.area.budget import budget
from hw_model.platform.partition import all_partitions
from hw_model.report.best import best_partition
from hw_model.report.remedies import remedies
from hw_model.report.throughput import LINES, throughputs
from hw_model.timing.actions import Work, actions_of
from hw_model.timing.groups import grouped
from hw_model.timing.stage_cycles import Microcode, PlCycles, StageCycles, estimated
from tests.hw_model.synthetic import synthetic_trace

TRACE = parse_trace(synthetic_trace(iterations=3, solves=2))
ALL_PS, PAPER = load_partition("all_ps"), load_partition("paper")
DEVICES = ("zu9eg", "zu7ev", "xc7z045", "xc7z020", "fmql45t900")


def scheduled(bits_per_cycle: float, storage_words: int | None = None) -> StageCycles:
    """The estimate's cycles as if they came from schedules, with microcode of `bits_per_cycle`."""

    def look_up(*asked: object) -> PlCycles:
        found = estimated(*asked)  # type: ignore[arg-type]
        bits = round(found.cycles * bits_per_cycle)
        code = Microcode(found.cycles, 4 * bits, bits)
        causes = found.causes | {"fetch": 0}
        return PlCycles(causes, found.lower_bound, found.bottleneck, "schedule", code, storage_words)

    return look_up


@pytest.mark.parametrize("device", DEVICES)
def test_the_best_partition_fits_and_no_partition_that_fits_is_faster(device: str) -> None:
    platform = load_platform(device)
    found = best_partition(TRACE, platform, estimated)
    report = speedup(TRACE, platform, "best")
    assert report.partition == found.name
    assert report.speedup.nominal >= 1.0
    assert budget(TRACE, platform, found).fits
    for other in all_partitions():
        if budget(TRACE, platform, other).fits:
            assert simulate(TRACE, platform, other).makespan_picoseconds >= report.makespan_picoseconds


def test_best_is_all_on_the_ps_where_the_pl_only_costs() -> None:
    slow = load_platform("zu9eg").with_value("pl.clock_mhz", 1.0)
    report = speedup(TRACE, slow, "best")
    assert (report.partition, report.speedup.nominal) == ("best (all_ps)", 1.0)
    assert report.modules_on_pl == ()


def test_best_needs_a_run_to_be_chosen_for() -> None:
    with pytest.raises(PartitionError, match="is chosen for one run on one platform"):
        load_partition("best")


def test_an_engine_that_fits_needs_no_remedy() -> None:
    assert remedies(TRACE, load_platform("zu9eg"), PAPER, scheduled(10.0)) == []


def test_microcode_that_does_not_fit_is_streamed_for_more_time() -> None:
    platform, dense = load_platform("zu7ev"), scheduled(2000.0)
    assert not budget(TRACE, platform, PAPER, dense).fits
    ways = remedies(TRACE, platform, PAPER, dense)
    assert {"pl.microcode_memory": "streamed"} in [way.settings for way in ways]
    plain = speedup(TRACE, platform, PAPER, cycles=dense).makespan_ms.nominal
    for way in ways[:-1]:
        changed = platform.with_values(way.settings)
        assert budget(TRACE, changed, PAPER, dense).fits
        assert speedup(TRACE, changed, PAPER, cycles=dense).makespan_ms.nominal == way.time_ms >= plain
        for key, value in way.settings.items():  # nothing is changed that need not be
            rest = {k: v for k, v in way.settings.items() if k != key}
            assert not budget(TRACE, platform.with_values(rest), PAPER, dense).fits, (key, value)
    assert ways[-1].settings == {}
    assert ways[-1].time_ms <= speedup(TRACE, platform, "all_ps").makespan_ms.nominal


def test_exact_depth_takes_the_rows_that_the_schedules_need() -> None:
    platform = load_platform("zu9eg").with_value("pl.storage_depth", "exact")
    few, many = (
        budget(TRACE, platform, PAPER, scheduled(10.0, words)).of("bram36").used for words in (4096, 40000)
    )
    power = budget(TRACE, load_platform("zu9eg"), PAPER, scheduled(10.0, 40000))
    assert few < many
    assert (
        power.of("bram36").used
        == budget(TRACE, load_platform("zu9eg"), PAPER, scheduled(10.0)).of("bram36").used
    )


@pytest.mark.parametrize("partition", [PAPER, load_partition("factor_only")])
def test_more_in_flight_is_no_slower_and_never_above_its_bound(partition: object) -> None:
    platform = load_platform("zu9eg")
    rows = throughputs(TRACE, platform, partition, ALL_PS, estimated)  # type: ignore[arg-type]
    assert tuple(row.in_flight for row in rows) == tuple(line.sets for line in LINES)
    rates = [row.solves_per_s for row in rows]
    assert rates == sorted(rates)
    assert rates[0] < rates[-1] <= rows[0].most_per_s
    assert rows[0].solves_per_s == pytest.approx(2 * 1e3 / rows[0].latency_ms, rel=1e-12)


def test_the_ps_alone_solves_a_problem_a_core() -> None:
    platform = load_platform("zu9eg")
    (row,) = throughputs(TRACE, platform, ALL_PS, ALL_PS, estimated)
    alone = simulate(TRACE, platform, ALL_PS).makespan_picoseconds / 1e9
    assert row.solves_per_s == pytest.approx(4 * 2 * 1e3 / alone, rel=1e-12)
    assert row.gain == pytest.approx(1.0, rel=1e-12)


def test_interleaved_copies_run_what_the_longest_of_them_needs_and_cross_the_link_one_by_one() -> None:
    long, other = TRACE.solves
    short = other.model_copy(update={"events": other.events[: len(other.events) // 2]})
    alone = actions_of(TRACE.model_copy(update={"solves": (long,)}), PAPER)
    pair = TRACE.model_copy(update={"solves": (short, long)})
    both = actions_of(pair, PAPER)
    together = Counter(grouped(both, pair, 2))

    def of(works: Iterable[Work], kind: str, side: str) -> Counter[Work]:
        return Counter(work for work in works if (work.kind, work.side) == (kind, side))

    assert of(together.elements(), "compute", "pl") == of((each.work for each in alone), "compute", "pl")
    for kind in ("build", "copy", "launch"):
        assert of(together.elements(), kind, "ps") == of((each.work for each in both), kind, "ps")
