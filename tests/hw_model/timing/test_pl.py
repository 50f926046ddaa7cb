"""Bounds and estimate of the PL: by hand, against a prototype's schedules, and as laws."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hw_model.errors import TraceError
from hw_model.platform.platform import Platform, load_platform
from hw_model.timing import pl
from hw_model.timing.trace import Stage
from tests.hw_model.random_traces import platforms, stages
from tests.hw_model.synthetic import stage
from tests.hw_model.tiny import tiny_platform


def made(raw: dict[str, Any]) -> Stage:
    """A stage from plain data."""
    return Stage.model_validate(raw)


def test_bounds_by_hand(tmp_path: Path) -> None:
    platform = tiny_platform(tmp_path)
    floor = pl.bounds(
        made(stage("cone_ops", "", "", 90, mul=5, mul_add=3, move=1, div=2, sqrt=1)), platform.pl, "f64"
    )
    # ⌈9/2⌉ on lanes; divisions and roots on the divider only: (2 + 1) · 4.
    assert (floor.issue, floor.dependency, floor.divider) == (5, 90, 12)
    assert (floor.cycles, floor.bottleneck) == (90, "dependency")


@pytest.mark.parametrize(
    ("counts", "chain", "bottleneck"),
    [
        ({"add": 1000}, 300, "issue"),
        ({"add": 100}, 300, "dependency"),
        ({"add": 100, "div": 100}, 300, "divider"),
    ],
)
def test_the_bottleneck_is_named(tmp_path: Path, counts: dict[str, int], chain: int, bottleneck: str) -> None:
    floor = pl.bounds(made(stage("cone_ops", "", "", chain, **counts)), tiny_platform(tmp_path).pl, "f64")
    assert floor.bottleneck == bottleneck


def test_a_chain_is_at_least_its_slowest_operation(tmp_path: Path) -> None:
    platform = tiny_platform(tmp_path)
    for counts, latency in (
        ({"div": 1}, 35),
        ({"mul": 1}, 8),
        ({"mul_sub": 1}, 15),
        ({"sub": 1}, 7),
        ({"select": 1}, 0),
    ):
        assert (
            pl.bounds(made(stage("cone_ops", "", "", 0, **counts)), platform.pl, "f64").dependency == latency
        )


def test_the_estimate_by_hand(tmp_path: Path) -> None:
    platform = tiny_platform(tmp_path).with_value("pl.overlap_exponent", 2.0)
    # issue 300, chain 400: √(300² + 400²) = 500, of which 200 wait for operands; drain 8 + 7 + 4.
    found = pl.estimate(made(stage("cone_ops", "", "", 400, add=600)), platform.pl, "f64")
    assert (found.issue, found.dependency, found.divider, found.drain) == (300, 200, 0, 19)
    assert found.cycles == 519


def test_a_stage_of_nothing_only_drains(tmp_path: Path) -> None:
    found = pl.estimate(made(stage("cone_ops", "", "", 0)), tiny_platform(tmp_path).pl, "f64")
    assert (found.bounds.cycles, found.cycles, found.drain) == (0, 19, 19)


@pytest.mark.parametrize(
    ("lanes", "scheduled"), [(1, 95_990), (2, 48_199), (4, 25_334), (8, 14_639), (16, 11_416)]
)
def test_the_estimate_meets_the_schedules_it_was_fitted_to(lanes: int, scheduled: int) -> None:
    """A prototype's LDLᵀ and two solves: 96 138 operations, 277 of them divisions, chain 6799.

    Its divider was held for 32 cycles, eight times as long as the RTL's is now.
    """
    platform = load_platform("zu9eg").with_value("pl.lanes", lanes)
    kkt = made(stage("factorization", "", "", 6799, mul_sub=96_138 - 277, div=8 * 277))
    found = pl.estimate(kkt, platform.pl, "f64")
    assert found.bounds.cycles <= scheduled
    assert found.cycles == pytest.approx(scheduled, rel=0.02)


@settings(max_examples=200, deadline=None)
@given(raw=stages("any"), platform=platforms(), datapath=st.sampled_from(("f64", "f32")))
def test_the_bound_is_never_above_the_estimate_and_causes_sum(raw, platform, datapath) -> None:  # type: ignore[no-untyped-def]
    found = pl.estimate(made(raw), platform.pl, datapath)
    assert found.bounds.cycles <= found.cycles - found.drain
    assert found.cycles == found.issue + found.dependency + found.divider + found.drain
    assert min(found.issue, found.dependency, found.divider, found.drain) >= 0
    assert found.issue == found.bounds.issue


@settings(max_examples=100, deadline=None)
@given(
    raw=stages("any"),
    platform=platforms(),
    key=st.sampled_from(("pl.lanes", "pl.dividers", "pl.overlap_exponent")),
    fewer=st.integers(1, 31),
    more=st.integers(1, 32),
)
def test_more_of_a_resource_is_never_slower(raw, platform, key, fewer, more) -> None:  # type: ignore[no-untyped-def]
    def cycles(value: int) -> tuple[int, int]:
        amount = float(value) if key.endswith("exponent") else value
        found = pl.estimate(made(raw), platform.with_value(key, amount).pl, "f64")
        return found.bounds.cycles, found.cycles

    small, large = cycles(fewer), cycles(fewer + more)
    assert large[0] <= small[0]
    assert large[1] <= small[1]


def test_a_chain_longer_than_all_operations_is_refused(tmp_path: Path) -> None:
    platform = tiny_platform(tmp_path)
    counts = {"mul": 2, "sub": 1, "mul_add": 1, "div": 1, "neg": 3}
    longest = 2 * 8 + 7 + 15 + 35 + 3 * 7
    assert (
        pl.bounds(made(stage("cone_ops", "", "", longest, **counts)), platform.pl, "f64").dependency
        == longest
    )
    says = r"`stages\.s\.critical_path\.orbsoc_rtl` = 95: longer than its 8 operations one after another \(94 cycles\)"
    with pytest.raises(TraceError, match=says):
        pl.bounds(made(stage("cone_ops", "", "", longest + 1, **counts)), platform.pl, "f64", "s")


def test_a_missing_critical_path_names_stage_and_preset() -> None:
    platform: Platform = load_platform("zu9eg").with_value("pl.latency_preset", "vendor_ip")
    with pytest.raises(TraceError, match=r"stages\.factor\.critical_path.*'vendor_ip'.*it has: orbsoc_rtl"):
        pl.bounds(
            made(stage("factorization", "", "", {"orbsoc_rtl": 5}, mul=1)), platform.pl, "f64", "factor"
        )
