"""The reports' cycles, and what each unit executes, are the schedules', which the RTL runs."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

import numpy as np
import pytest

from benchmarks.guidance import rendezvous
from hw_model import HwModelError, load_partition, load_platform, parse_trace, speedup
from hw_model.area.budget import budget
from hw_model.area.engine import MOST
from hw_model.errors import NoSuchEngineError
from hw_model.timing.schedules import engine_of
from hw_model.timing.unit_schedules import coarse_slices, exact_slices
from orbsoc import Cones, Problem, PsScheduler
from orbsoc.conic.settings import Settings
from orbsoc.hw.exact_cycles import exact_cycles, exact_units
from orbsoc.hw.representative_solves import RepresentativeSolves
from orbsoc.hw.schedules import MODEL_MICROCODE_WORDS, Engine, EngineError, PlProgram, pl_program
from orbsoc.missions.reachable_domain.record.cost import DomainCost
from orbsoc.missions.reachable_domain.search.continuation.table import subproblems_on

if TYPE_CHECKING:
    from orbsoc.missions.reachable_domain.search.query.results import ReachableDomain

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
@pytest.mark.parametrize("microcode", ["flat", "compressed"])
def test_a_report_has_the_cycles_of_the_schedules(
    recorded: PsScheduler, lanes: int, banks: int, microcode: str
) -> None:
    machine = load_platform("zu9eg").with_values(
        {"pl.lanes": lanes, "pl.banks": banks, "pl.microcode_format": microcode}
    )
    report = speedup(recorded.trace, machine, "paper", cycles=exact_cycles(recorded.patterns))
    segments = pl_program(PROBLEM, None, Engine(lanes=lanes, banks=banks)).segments
    rows = {row.stage: row for row in report.stages if row.side == "pl"}
    assert rows
    for name, row in rows.items():
        found = segments[name]
        cycles = found.cycles if microcode == "flat" else found.compressed_cycles
        assert (row.cycles_each, row.lower_bound_each) == (cycles, found.lower_bound)
        assert sum(row.causes_each.values()) == row.cycles_each
        assert row.origin == "schedule"
    assert sum(report.causes_picoseconds.values()) == report.makespan_picoseconds


def test_schedules_of_the_expected_engines_are_made_once_each_with_the_first(
    recorded: PsScheduler, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[int] = []

    def counted(problem: Problem, settings: None, engine: Engine, *program: object) -> PlProgram:
        made.append(engine.lanes)
        assert program == (None, (), 1)
        return pl_program(problem, settings, engine)

    monkeypatch.setattr("orbsoc.hw.exact_cycles.pl_program", counted)
    machines = [load_platform("zu9eg").with_value("pl.lanes", lanes) for lanes in (1, 2, 4)]
    expected = [engine_of(machine, "f64") for machine in machines]
    cycles = exact_cycles(recorded.patterns, [*expected, expected[0]._replace(compressed=False)])
    assert made == []
    for machine in machines:
        found = speedup(recorded.trace, machine, "paper", cycles=cycles)
        assert sorted(made) == [1, 2, 4]
        alone = speedup(recorded.trace, machine, "paper", cycles=exact_cycles(recorded.patterns))
        made[-1:] = []
        assert found.makespan_picoseconds == alone.makespan_picoseconds


def test_single_precision_has_schedules_of_its_own(recorded: PsScheduler) -> None:
    trace = recorded.trace | {"datapath": "f32"}
    report = speedup(trace, "zu9eg", "paper", cycles=exact_cycles(recorded.patterns))
    segments = pl_program(PROBLEM, None, Engine(fp=32)).segments
    rows = [row for row in report.stages if row.side == "pl"]
    assert all(row.cycles_each == segments[row.stage].compressed_cycles for row in rows)


def test_other_latencies_have_no_schedule_and_no_estimate_takes_its_place(recorded: PsScheduler) -> None:
    machine = load_platform("zu9eg").with_value("pl.latency_preset", "vendor_ip")
    with pytest.raises(HwModelError, match=r"`pl\.latency_preset` = 'vendor_ip': .*ask for --estimate"):
        speedup(recorded.trace, machine, "paper", cycles=exact_cycles(recorded.patterns))
    with pytest.raises(HwModelError, match="ask for --estimate"):
        exact_units(recorded.patterns)(parse_trace(recorded.trace), machine, 0, "factorize")
    assert speedup(recorded.trace, machine, "paper").stages  # the estimate, asked for, prices them


def test_the_budgets_microcode_is_what_the_schedules_take(recorded: PsScheduler) -> None:
    trace, cycles = parse_trace(recorded.trace), exact_cycles(recorded.patterns)
    segments = pl_program(PROBLEM, None, Engine()).segments.values()
    found = budget(trace, load_platform("zu9eg"), load_partition("paper"), cycles)
    assert found.microcode_bits == sum(segment.compressed_bits for segment in segments)
    assert found.microcode_flat_bits == sum(segment.flat_bits for segment in segments)
    assert found.microcode_words == sum(segment.words for segment in segments)


@pytest.mark.parametrize("microcode", ["flat", "compressed"])
def test_units_execute_the_operations_of_the_schedule_one_at_a_time(
    recorded: PsScheduler, microcode: str
) -> None:
    """A lane begins one operation a cycle, a divider none before the last is done, and all end within the segment."""
    machine = load_platform("zu9eg").with_values({"pl.lanes": 2, "pl.microcode_format": microcode})
    trace = parse_trace(recorded.trace)
    look_up, cycles = exact_units(recorded.patterns), exact_cycles(recorded.patterns)
    latencies = machine.pl.latencies.f64
    for name, segment in pl_program(PROBLEM, None, Engine(lanes=2)).segments.items():
        schedule = look_up(trace, machine, 0, name)
        length = cycles(trace, machine, 0, name).cycles
        for found in (exact_slices(schedule, latencies), coarse_slices(schedule, latencies, length)):
            assert sum(item.operations for item in found) == segment.operations
            on_lanes = [item for item in found if item.unit < 2]
            assert sum(item.busy for item in on_lanes) == segment.lane_operations
            assert sum(count for item in found for _, count in item.mix) == segment.operations
            assert all(0 <= item.begin < item.end <= length for item in found)
            for one, two in pairwise(sorted(found)):
                assert one.unit != two.unit or one.end <= two.begin
        assert all(item.busy == item.end - item.begin for item in exact_slices(schedule, latencies))


def test_an_engine_that_cannot_exist_is_refused(recorded: PsScheduler) -> None:
    machine = load_platform("zu9eg").with_value("pl.lanes", 17)
    with pytest.raises(NoSuchEngineError, match=r"`pl\.lanes` = 17"):
        speedup(recorded.trace, machine, "paper", cycles=exact_cycles(recorded.patterns))


@pytest.mark.parametrize("microcode", ["flat", "compressed"])
def test_a_segment_ends_when_the_last_of_its_units_operations_is_stored(
    recorded: PsScheduler, microcode: str
) -> None:
    """READ + U + WRITE after it began, as docs/pl-machine.md has it, whatever froze the datapath in between."""
    machine = load_platform("zu9eg").with_values({"pl.lanes": 2, "pl.microcode_format": microcode})
    trace, units = parse_trace(recorded.trace), machine.pl.latencies.f64
    add, mul = units.add_cycles.value, units.mul_cycles.value
    latency = {"add": add, "sub": add, "mul": mul, "add_mul": mul + add, "sub_mul": mul + add} | {
        "div": units.div_cycles.value, "sqrt": units.sqrt_cycles.value,
    }  # fmt: skip
    after: set[int] = set()
    for name in pl_program(PROBLEM, None, Engine(lanes=2)).segments:
        schedule = exact_units(recorded.patterns)(trace, machine, 0, name)
        takes = np.array([latency.get(operation, SIMPLE) for operation in schedule.names])
        stored = (schedule.began + takes[schedule.operations]).max()
        after.add(int(exact_cycles(recorded.patterns)(trace, machine, 0, name).cycles - stored))
    assert after == {READ + WRITE + 1 + FINISH}


READ, SIMPLE, WRITE, FINISH = 4, 2, 1, 1  # docs/pl-machine.md


def test_points_of_a_reachable_domain_are_priced_by_schedules(recorded: PsScheduler) -> None:
    points = {"status": np.zeros(1), subproblems_on(12): np.array([1])}
    solves = RepresentativeSolves(
        (parse_trace(recorded.trace),), (recorded.trace["solves"][0]["iterations"],), (recorded.patterns,)
    )
    found = DomainCost.of(
        cast("ReachableDomain", SimpleNamespace(points=points)),
        "zu9eg",
        "paper",
        {12: solves.price("zu9eg", "paper")},
    )
    report = speedup(recorded.trace, "zu9eg", "paper", cycles=exact_cycles(recorded.patterns))
    own = 1e3 * report.makespan_ms.nominal * report.pl_clock_mhz
    assert found.prices[12].most_cycles == pytest.approx(own, rel=1e-12)
    assert found.speedup == pytest.approx(report.speedup.nominal, rel=1e-12)
    assert ("SLOWER" if found.speedup < 1.0 else "faster") in found.words
    assert own != 1e3 * speedup(recorded.trace, "zu9eg", "paper").makespan_ms.nominal * report.pl_clock_mhz


@pytest.mark.parametrize("name", MOST)
def test_the_largest_engine_of_an_estimate_is_the_schedulers(name: str, recorded: PsScheduler) -> None:
    def priced(value: int) -> None:
        platform = load_platform("zu9eg").with_value(f"pl.{name}", value)
        budget(parse_trace(recorded.trace), platform, load_partition("paper"))

    most = MOST[name]
    largest, larger = (dict[str, Any]({name: value}) for value in (most, 2 * most))
    pl_program(PROBLEM, engine=replace(Engine(), **largest))
    priced(most)
    with pytest.raises(EngineError, match=f"`{name}`"):
        pl_program(PROBLEM, engine=replace(Engine(), **larger))
    with pytest.raises(HwModelError, match=rf"`pl\.{name}` = {2 * most}"):
        priced(2 * most)


def test_an_order_of_elimination_has_schedules_of_its_own() -> None:
    problem = rendezvous(12, 0, approach_cone=False)
    cycles = {}
    for ordering in ("amd", "nested_dissection"):
        ps = PsScheduler(every_ordering=ordering)
        assert ps(problem, Settings(tol=1e-7)).status.name == "SOLVED"
        (settings,) = ps.pattern_settings
        assert (settings.ordering, settings.tol) == (ordering, 1e-7)
        source = exact_cycles(ps.patterns, settings=ps.pattern_settings)
        trace = parse_trace(ps.trace)
        found = source(trace, load_platform("zu9eg"), 0, "factorize")
        program = pl_program(problem, Settings(ordering=ordering), MODELLED)
        assert found.cycles == program.segments["factorize"].compressed_cycles
        cycles[ordering] = found.cycles
        counted = trace.patterns[0].stages["factorize"].operations
        assert counted["div"] == problem.n + problem.p + problem.m
    assert cycles["amd"] != cycles["nested_dissection"]


MODELLED = Engine(microcode_words=MODEL_MICROCODE_WORDS)


def test_the_best_partition_may_control_itself(recorded: PsScheduler) -> None:
    """Where an interrupt costs as much as under Linux, control on the PL beats every partition that the PS controls."""
    trace, cycles = parse_trace(recorded.trace), exact_cycles(recorded.patterns)
    linux = load_platform("zu9eg").with_values({"runtime.preset": "linux", "ps.clock_mhz": 20.0})
    assert speedup(trace, linux, "best", cycles=cycles).partition == "best (resident)"
