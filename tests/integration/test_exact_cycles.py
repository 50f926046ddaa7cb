"""The reports' cycles are the schedules', which the RTL runs; a bare trace and other latencies fall back on the estimate."""

from __future__ import annotations

import numpy as np
import pytest

from hw_model import load_platform, speedup
from orbsoc import Cones, Problem, PsScheduler
from orbsoc.exact_cycles import exact_cycles
from orbsoc.pl_program import Engine, EngineError, pl_program

PROBLEM = Problem(
    P=np.eye(4), c=[1.0, -2.0, 0.5, 1.0], A=[[1.0, 1.0, 0.0, 0.0]], b=[1.0],
    G=np.vstack([-np.eye(4), np.eye(4)[1:]]), h=[1.0, 1.0, 1.0, 1.0, 4.0, 0.0, 0.0], cones=Cones(l=4, q=[3]),
)  # fmt: skip


@pytest.fixture(scope="module")
def recorded() -> PsScheduler:
    ps = PsScheduler()
    assert ps(PROBLEM).status.name == "SOLVED"
    return ps


@pytest.mark.parametrize("lanes", [1, 4])
@pytest.mark.parametrize("banks", [4, 16])
def test_a_report_has_the_cycles_of_the_schedules(recorded: PsScheduler, lanes: int, banks: int) -> None:
    machine = load_platform("zu9eg").with_values({"pl.lanes": lanes, "pl.banks": banks})
    report = speedup(recorded.trace, machine, "paper", cycles=exact_cycles(recorded.patterns))
    segments = pl_program(PROBLEM, None, Engine(lanes=lanes, banks=banks)).segments
    rows = {row.stage: row for row in report.stages if row.side == "pl"}
    assert rows
    for name, row in rows.items():
        assert (row.cycles_each, row.lower_bound_each) == (segments[name].cycles, segments[name].lower_bound)
        assert sum(row.causes_each.values()) == row.cycles_each
        assert row.origin == "schedule"
    assert sum(report.causes_picos.values()) == report.makespan_picos


def test_single_precision_has_schedules_of_its_own(recorded: PsScheduler) -> None:
    trace = recorded.trace | {"datapath": "f32"}
    report = speedup(trace, "zu9eg", "paper", cycles=exact_cycles(recorded.patterns))
    segments = pl_program(PROBLEM, None, Engine(fp=32)).segments
    assert all(row.cycles_each == segments[row.stage].cycles for row in report.stages if row.side == "pl")


def test_other_latencies_fall_back_on_the_estimate_and_say_so(recorded: PsScheduler) -> None:
    machine = load_platform("zu9eg").with_value("pl.latency_preset", "vendor_ip")
    report = speedup(recorded.trace, machine, "paper", cycles=exact_cycles(recorded.patterns))
    assert {row.origin for row in report.stages if row.side == "pl"} == {"estimate"}


def test_an_engine_that_cannot_exist_is_refused(recorded: PsScheduler) -> None:
    machine = load_platform("zu9eg").with_value("pl.banks", 3)
    with pytest.raises(EngineError, match="`banks` = 3"):
        speedup(recorded.trace, machine, "paper", cycles=exact_cycles(recorded.patterns))
