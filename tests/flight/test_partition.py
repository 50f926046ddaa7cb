"""The program with modules on the PL: the core's bits where all goes well, and after trouble a right answer that says so."""

from __future__ import annotations

import ctypes
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import orbsoc
from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.flight import FlightError
from orbsoc.flight.export import default_settings
from orbsoc.hw.schedules import Engine
from orbsoc.ps.registers import Fault, Wrapper
from orbsoc.rtl.solve_cases import INFEASIBLE, TIGHT, UNBOUNDED
from orbsoc.rtl.validation import problems
from tests.flight.c_library import expected, need
from tests.flight.stand_in import Partitioned, StandIn, Trouble
from tests.rtl.c_driver import WRONG_ENGINE
from tests.solving.restart_problems import STALLED, STALLING, badly_scaled

SMALL = problems()["6 variables, cones 3"]
PARTITIONS = (
    "factor_only", "paper", "resident", "statistics", "factorization+linear_solve", "matrix_scaling+cone_ops+line_search",
    "matrix_update+matrix_scaling+factorization+linear_solve+cone_ops+line_search+statistics",
)  # fmt: skip
REFUSED, LATE, ENDLESS, BUS_ERROR = 256, 257, 258, 22
TIME_IS_UP = 8
UPSETS = 30


@pytest.fixture(scope="module", params=PARTITIONS)
def program(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Partitioned:
    need("gcc")
    return Partitioned(tmp_path_factory.mktemp("c") / "p", SMALL, TIGHT, request.param)


@pytest.fixture(autouse=True)
def untroubled(request: pytest.FixtureRequest) -> Iterator[None]:
    yield
    if "program" in request.fixturenames:
        pl = request.getfixturevalue("program").pl
        pl.trouble = None


@cache
def wanted() -> dict[str, Any]:
    return expected(_core.ExactEngine(SMALL, TIGHT, 64).solve())


def test_a_solve_on_the_device_has_the_bits_of_the_core(program: Partitioned) -> None:
    assert program.solve() == wanted()
    assert (program.place, program.events) == ("on device", (0, 0))
    assert program.pl.ran > 0
    assert program.solve() == wanted(), "a solve leaves nothing behind"


def test_so_has_one_from_a_point_nearby(program: Partitioned) -> None:
    engine = _core.ExactEngine(SMALL, TIGHT, 64)
    cold, random = engine.solve(), np.random.default_rng(4)
    point = tuple(v * (1 + 1e-4 * random.standard_normal(v.size)) for v in (cold.x, cold.y, cold.z, cold.s))
    for start in (point, tuple(-v for v in point)):
        assert program.solve(start) == expected(engine.solve(start))
        assert (program.place, program.events) == ("on device", (0, 0))


def hang(pl: StandIn, stage: str) -> None:
    pl.silent = True


def fault(pl: StandIn, stage: str) -> None:
    pl.stop(Fault.WRONG_SEQUENCE)


def break_bus(pl: StandIn, stage: str) -> None:
    pl.error_at = pl.accesses + 1


def wrong_words(pl: StandIn, stage: str) -> None:
    """The exponent's highest bit of every third word that a stage leaves."""
    for address in pl.written(stage)[::3]:
        pl.flip(address, pl.fp - 2)


def in_first(tries: int, then: Trouble, *, at: int | None) -> Trouble:
    """Trouble after the stage of that number of a try, or after all, in the first tries of a solve."""

    def trouble(pl: StandIn, stage: str) -> None:
        if pl.tries <= tries and at in (None, pl.ran):
            then(pl, stage)

    return trouble


TROUBLES: dict[str, tuple[Trouble, int | None, set[int]]] = {
    "timeout": (hang, 2, {LATE}),
    "fault": (fault, 2, {int(Fault.WRONG_SEQUENCE)}),
    "bus error": (break_bus, 2, {BUS_ERROR}),
    "wrong words": (wrong_words, None, {REFUSED, ENDLESS}),
}
"""What happens, after which stage, and what the program may call it."""


@pytest.mark.parametrize("name", TROUBLES)
@pytest.mark.parametrize("tries", [1, 2])
def test_trouble_is_named_and_the_answer_is_right(program: Partitioned, name: str, tries: int) -> None:
    then, at, named = TROUBLES[name]
    program.pl.trouble = in_first(tries, then, at=at)
    assert program.solve() == wanted()
    assert program.place == ("second try" if tries == 1 else "fell back")
    assert all(event in named for event in program.events[:tries])
    assert program.events[tries:] == (0,) * (2 - tries)
    program.pl.trouble = None
    assert program.solve() == wanted()
    assert (program.place, program.events) == ("on device", (0, 0)), "the next solve tries the device again"


def test_a_launch_beyond_the_limit_is_stopped_and_the_core_has_the_answer(program: Partitioned) -> None:
    """The program's own limit is the most that a launch can take; the caller may ask for less."""
    own = int(program.library.pl_limit_of_program())
    assert own > max(program.pl.clocks.segments.values())
    program.library.pl_limit(program.pl.clocks.launch)
    assert program.solve() == wanted()
    assert (program.place, program.events) == ("fell back", (Fault.CYCLE_LIMIT, Fault.CYCLE_LIMIT))
    program.library.pl_limit(own)
    assert program.solve() == wanted()
    assert (program.place, program.events) == ("on device", (0, 0))


def test_the_program_is_loaded_once_and_afresh_after_trouble(program: Partitioned) -> None:
    program.attach()
    program.pl.loads = 0
    program.solve()
    program.solve()
    assert program.pl.loads == 1
    program.pl.trouble = in_first(1, fault, at=1)
    program.solve()
    assert program.pl.loads == 2


def test_one_bit_anywhere_at_any_time_leaves_no_wrong_answer(program: Partitioned) -> None:
    """An upset of the storage in the first try: a solution within the tolerance, wherever it was found."""
    random = np.random.default_rng(11)
    used = sorted({int(at) for _, addresses in program.pl.homes.values() for at in addresses})
    program.pl.trouble = None
    program.solve()
    stages, places = program.pl.ran, Counter[str]()
    exact = _core.ExactEngine(SMALL, TIGHT, 64).solve()
    for _ in range(UPSETS):
        at, address, bit = (
            int(random.integers(1, stages + 1)),
            int(random.choice(used)),
            int(random.integers(64)),
        )
        program.pl.trouble = in_first(1, lambda pl, _: pl.flip(address, bit), at=at)  # noqa: B023
        found = program.solve()
        assert found["status"] == "SOLVED", (at, address, bit)
        x = np.array(found["numbers"][6 : 6 + exact.x.size], np.uint64).view(np.float64)
        np.testing.assert_allclose(x, exact.x, atol=1e-6)
        if program.place != "on device":
            assert program.events[0] != 0
            assert found == wanted(), "a second try has no upset"
        places[program.place] += 1
    assert places["on device"] + places["second try"] == UPSETS


def test_the_core_alone_solves_where_the_engine_is_another(program: Partitioned) -> None:
    program.attach()
    sizes = program.pl.constants[int(Wrapper.SIZES)]
    program.pl.constants[int(Wrapper.SIZES)] = sizes ^ 1
    assert program.solve() == wanted()
    assert (program.place, program.events) == ("fell back", (WRONG_ENGINE, WRONG_ENGINE))
    program.pl.constants[int(Wrapper.SIZES)] = sizes


@pytest.mark.parametrize("problem", [INFEASIBLE, UNBOUNDED], ids=["infeasible", "unbounded"])
@pytest.mark.parametrize("partition", ["paper", "resident"])
def test_certificates_come_back_from_the_device(problem: Problem, partition: str, tmp_path: Path) -> None:
    program = Partitioned(tmp_path / "c", problem, Settings(), partition)
    assert program.solve() == expected(_core.ExactEngine(problem, Settings(), 64).solve())
    assert (program.place, program.events) == ("on device", (0, 0))


@pytest.mark.parametrize("partition", ["factor_only", "paper", "resident"])
def test_restarts_run_on_the_device_and_an_unsettled_answer_is_checked_on_the_core(
    partition: str, tmp_path: Path
) -> None:
    """Its attempts stall on any machine: the device is not believed, and the core says the same."""
    problem = badly_scaled(STALLED)
    program = Partitioned(tmp_path / "c", problem, STALLING, partition)
    exact = _core.ExactEngine(problem, STALLING, 64).solve()
    assert program.solve() == expected(exact)
    settled = exact.status in ("SOLVED", "PRIMAL_INFEASIBLE", "DUAL_INFEASIBLE")
    assert exact.attempts > 1
    assert program.place == ("on device" if settled else "fell back")
    assert program.events == ((0, 0) if settled else (REFUSED, REFUSED))


@pytest.mark.parametrize("partition", ["paper", "resident"])
def test_binary32_runs_on_a_device_of_binary32(partition: str, tmp_path: Path) -> None:
    settings = default_settings(32)
    program = Partitioned(tmp_path / "c", SMALL, settings, partition, 32)
    assert program.solve() == expected(_core.ExactEngine(SMALL, settings, 32).solve())
    assert (program.place, program.events) == ("on device", (0, 0))


def test_the_clock_stops_an_attempt_of_the_device(tmp_path: Path) -> None:
    program = Partitioned(tmp_path / "c", SMALL, TIGHT, "resident")
    program.attach(polls=1)
    calls = [0]

    @ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p)
    def ask(_: object) -> int:
        calls[0] += 1
        return TIME_IS_UP if calls[0] > 12 else 0

    program.library.pl_ask(ctypes.c_void_p(program.library.harness_solver()), ask)
    found = program.solve()
    assert (found["status"], program.place) == ("MAX_TIME", "on device")
    assert 0 < found["iterations"] < wanted()["iterations"]


def test_an_export_refuses_partitions_and_engines_that_it_has_no_program_for(tmp_path: Path) -> None:
    for options, words in (
        ({"partition": "none"}, "none"),
        ({"partition": "paper_streams"}, '`streams` = "iteration"'),
        ({"partition": "paper", "engine": Engine(lanes=0)}, "lanes"),
        ({"partition": "paper", "engine": Engine(address_bits=6)}, "address_bits"),
    ):
        with pytest.raises(FlightError, match=words):
            orbsoc.export_c(SMALL, tmp_path / "c", **options)
        assert not (tmp_path / "c").exists()
    written = orbsoc.export_c(SMALL, tmp_path / "all_ps", partition="all_ps")
    assert not any("driver" in str(path) for path in written)
