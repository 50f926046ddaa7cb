"""The insertion's outer loop in C: its data, its plans and its exits are those of the sequence in Python."""

from __future__ import annotations

import re
import subprocess
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from typer.testing import CliRunner

import orbsoc
from orbsoc import _core
from orbsoc.commands.app import app
from orbsoc.flight import FlightError
from orbsoc.flight.bounds import STACK_BYTES
from orbsoc.flight.mission import AGREES, checksum, mission_source
from orbsoc.guidance.powered_flight import Trajectory, commanded
from orbsoc.guidance.scp import Rules
from orbsoc.missions.reachable_insertion import Scenario, load_scenario, plan
from orbsoc.missions.reachable_insertion.model.problems import Iterate
from orbsoc.missions.reachable_insertion.on_board import OnBoard, on_board
from orbsoc.missions.reachable_insertion.search.run import Attempt, Search, verified
from orbsoc.missions.reachable_insertion.search.setup import InsertionSetup
from tests.flight.c_library import FLIGHT, ROOT, STRICT, need
from tests.flight.c_mission import CMission, CPlan

Array = NDArray[np.float64]
Exported = dict[str, tuple[Scenario, OnBoard, Path]]
Missions = dict[str, CMission]
MISSIONS = FLIGHT / "missions"
NAMES = ("rec1", "rec2")
FAILURES = ("|ΔH|/|H|", "|ΔL|/μ", "plane error", "max‖u‖ − 1", "depth below")
"""Beginnings of what `verify` objects to, in the order of the bits in C."""


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """Both scenarios with their missions and folders."""
    found = {}
    for name in NAMES:
        scenario = load_scenario(ROOT / "scenarios" / f"{name}.toml")
        mission = on_board(scenario, orbsoc.solve)
        folder = tmp_path_factory.mktemp("mission") / name
        orbsoc.export_c(mission.problem, folder, mission=mission)
        found[name] = (scenario, mission, folder)
    return found


@pytest.fixture(scope="module")
def missions(exported: Exported) -> Missions:
    return {name: CMission(folder, folder / "mission.so") for name, (_, _, folder) in exported.items()}


def starts(scenario: Scenario) -> list[Array]:
    """The scenario's state, ten up to 500 m and 5 m/s off it, axis by axis, and two out of reach."""
    own = InsertionSetup.of(scenario).start_si
    random = np.random.default_rng(len(scenario.name) + int(own[0]))
    moved = [own + random.uniform(-1.0, 1.0, 6) * np.repeat([500.0, 5.0], 3) for _ in range(10)]
    return [own, *moved, *(own * np.repeat([1.0, factor], 3) for factor in (0.5, 1.2))]


def from_state(scenario: Scenario, start_si: Array) -> InsertionSetup:
    vectors = {"position_m": start_si[:3].tolist(), "velocity_m_s": start_si[3:].tolist()}
    return InsertionSetup.of(scenario.with_changes(initial=vectors))


def planned(setup: InsertionSetup) -> Attempt:
    """The sequence in Python, on one grid."""
    rules = Rules(max_iterations=setup.scenario.method.max_iterations)
    search = Search(orbsoc.solve, rules)
    return verified(setup, search.sequence(setup, setup.cold_start(), "as on board"))


def flat(arc: Trajectory) -> Array:
    return np.concatenate([arc.states.ravel(), arc.controls.ravel(), arc.end, [arc.duration]])


def objections(attempt: Attempt) -> int:
    if attempt.verification is None:
        return 32
    failed = attempt.verification.failures
    return sum(
        1 << bit for bit, words in enumerate(FAILURES) if any(each.startswith(words) for each in failed)
    )


@pytest.mark.parametrize("name", NAMES)
def test_plans_are_those_of_the_sequence_bit_for_bit(
    name: str, exported: Exported, missions: Missions
) -> None:
    scenario, _, _ = exported[name]
    exits = set()
    for start in starts(scenario):
        setup = from_state(scenario, start)
        attempt, found = planned(setup), missions[name].plan(start)
        arc, last = attempt.trajectory, attempt.outcome.iterations[-1]
        assert (found.error, found.exit) == (0, attempt.outcome.reason.name)
        assert found.subproblems == len(attempt.outcome.iterations)
        assert found.iterations == sum(each.solution.iterations for each in attempt.outcome.iterations)
        assert found.objections == objections(attempt)
        np.testing.assert_array_equal(found.controls, arc.controls)
        np.testing.assert_array_equal(found.states, arc.states)
        assert found.duration_s == arc.duration * setup.units.time_s
        assert (found.numbers[1], found.numbers[2]) == (last.change, last.slack)
        np.testing.assert_array_equal(found.numbers[8:], [value for _, value in attempt.iterate.slack])
        exits.add(found.exit)
    assert exits == {"CONVERGED", "INFEASIBLE", "MAX_ITERATIONS"}


@pytest.mark.parametrize("name", NAMES)
def test_plans_are_the_shipped_planners(name: str, exported: Exported, missions: Missions) -> None:
    scenario, _, _ = exported[name]
    for start in starts(scenario)[:11]:
        shipped, found = plan(from_state(scenario, start).scenario), missions[name].plan(start)
        assert shipped.status.value == "verified"
        assert found.objections == 0
        assert found.subproblems == len(shipped.subproblems)
        assert found.duration_s == shipped.time_of_flight_s
        np.testing.assert_array_equal(found.controls, shipped.trajectory.controls)


@pytest.mark.parametrize("name", NAMES)
def test_data_about_any_reference_have_the_bits_of_python(
    name: str, exported: Exported, missions: Missions
) -> None:
    setup = InsertionSetup.of(exported[name][0])
    lines = setup.subproblem(soft=False)
    random = np.random.default_rng(0)

    def moved(values: Array) -> Array:
        return np.asarray(values * (1.0 + 1e-2 * random.standard_normal(np.shape(values))))

    arc = setup.cold_start().trajectory
    for _ in range(20):
        reference = Trajectory(
            arc.grid,
            moved(arc.states),
            moved(arc.controls),
            moved(arc.end),
            float(moved(np.array(arc.duration))),
        )
        problem = lines(Iterate(reference)).problem
        sizes = (problem.A.nnz, problem.p, problem.m)
        a, b, h = missions[name].data(setup.burn.start, flat(reference), sizes)
        np.testing.assert_array_equal(a, problem.A.data)
        np.testing.assert_array_equal(b, problem.b)
        np.testing.assert_array_equal(h, problem.h)


def test_the_first_guess_has_the_bits_of_the_cold_start_and_is_flown_right(
    exported: Exported, missions: Missions
) -> None:
    scenario, mission, _ = exported["rec1"]
    for start in starts(scenario)[:4]:
        setup = from_state(scenario, start)
        found = missions["rec1"].guess(setup.burn.start)
        np.testing.assert_array_equal(found, flat(setup.cold_start().trajectory))
        independent = setup.flown(
            lambda _t_s, state: state[3:], scenario.burn.guess_s, mission.sizes["nodes"]
        )
        np.testing.assert_allclose(found, flat(independent), rtol=1e-10, atol=1e-10)


def test_the_flight_that_judges_is_the_independent_one(exported: Exported, missions: Missions) -> None:
    """Where the thrust turns fast DOP853 is 4e-11 off at its tolerances; the flight in C does not move with four times the steps."""
    scenario, _, _ = exported["rec1"]
    for start in starts(scenario)[:4]:
        found, made = missions["rec1"].plan(start), planned(from_state(scenario, start)).verification
        assert made is not None
        momentum, laplace, excess, lowest = found.numbers[3:7]
        assert momentum == pytest.approx(made.angular_momentum_rel, abs=1e-10)
        assert laplace == pytest.approx(made.laplace_rel, abs=1e-10)
        assert excess == pytest.approx(made.thrust_excess, abs=1e-12)
        radius = np.linalg.norm(made.flight.propagated[:, :3], axis=1).min()
        assert lowest == pytest.approx(radius / scenario.constants.earth_radius_m, rel=1e-10)


def test_a_coarse_grid_is_objected_to(exported: Exported, missions: Missions) -> None:
    """A state from which the burn turns faster than twelve nodes follow."""
    scenario, _, _ = exported["rec1"]
    start = InsertionSetup.of(scenario).start_si
    found: list[CPlan] = []
    random = np.random.default_rng(3)
    for _ in range(12):
        moved = start + random.uniform(-1.0, 1.0, 6) * np.repeat([5000.0, 50.0], 3)
        attempt = planned(from_state(scenario, moved))
        found.append(missions["rec1"].plan(moved))
        assert found[-1].objections == objections(attempt)
    assert {0} < {each.objections for each in found if each.exit == "CONVERGED"}


def test_the_attitude_is_what_is_commanded(exported: Exported, missions: Missions) -> None:
    scenario, _, _ = exported["rec1"]
    setup = InsertionSetup.of(scenario)
    found = missions["rec1"].plan(setup.start_si)
    grid = planned(setup).trajectory.grid
    steering = commanded(grid, found.controls, found.duration_s)
    nodes_s = (0.5 * found.duration_s * (grid.nodes + 1.0)).tolist()
    for time_s in [*np.linspace(0.0, found.duration_s, 40).tolist(), *nodes_s]:
        wanted = np.asarray(steering(time_s, np.zeros(6)))
        error, got = missions["rec1"].direction(time_s)
        assert error == 0
        np.testing.assert_allclose(got, wanted / np.linalg.norm(wanted), atol=1e-12)


def test_beside_the_burn_and_before_a_plan_there_is_no_attitude(exported: Exported, tmp_path: Path) -> None:
    scenario, _, folder = exported["rec1"]
    fresh = CMission(folder, tmp_path / "fresh.so")
    assert fresh.direction(0.0)[0] == 7, "ORBSOC_NO_DATA"
    found = fresh.plan(InsertionSetup.of(scenario).start_si)
    beside = (-1e-9, found.duration_s + 1e-9, float("nan"))
    assert [fresh.direction(time_s)[0] for time_s in beside] == [5] * 3, "ORBSOC_BAD_VALUE"


def test_on_the_target_orbit_there_is_nothing_to_burn(exported: Exported, missions: Missions) -> None:
    scenario, _, _ = exported["rec1"]
    there = scenario.launch_inertial(scenario.target)
    found = missions["rec1"].plan(there)
    assert (found.error, found.exit, found.objections, found.subproblems) == (0, "NOTHING_TO_BURN", 0, 0)
    assert found.duration_s == 0.0
    shipped = plan(from_state(scenario, there).scenario)
    assert (shipped.status.value, shipped.time_of_flight_s) == ("verified", 0.0)
    np.testing.assert_allclose(
        missions["rec1"].direction(0.0)[1], there[3:] / np.linalg.norm(there[3:]), atol=1e-12
    )


def test_bad_states_and_interrupts_end_with_a_type(exported: Exported, missions: Missions) -> None:
    scenario, mission, _ = exported["rec1"]
    own = InsertionSetup.of(scenario).start_si
    for wrong in (own * np.nan, np.zeros(6), own * [1, 1, np.inf, 1, 1, 1], own * [1, 1, 1, 0, 0, 0]):
        found = missions["rec1"].plan(np.asarray(wrong))
        assert (found.error, found.objections) == (5, 32), "ORBSOC_BAD_VALUE, not flown"
    missions["rec1"].library.mission_ask(1)
    stopped = missions["rec1"].plan(own)
    missions["rec1"].library.mission_ask(0)
    assert (stopped.error, stopped.exit, stopped.objections) == (0, "INTERRUPTED", 32)
    random = np.random.default_rng(1)
    for _ in range(10):
        wild = own * (1.0 + random.uniform(-0.9, 3.0, 6))
        found = missions["rec1"].plan(wild)
        assert found.subproblems <= mission.sizes["max_subproblems"]
        assert found.error in (0, 5)
        assert found.objections == 0 or found.exit != "NOTHING_TO_BURN"
    assert missions["rec1"].plan(own).objections == 0, "nothing is left of what went wrong"


def test_a_changed_table_is_refused(exported: Exported, missions: Missions) -> None:
    assert [missions["rec1"].library.mission_change(which) for which in range(8)] == [3] * 8
    _, mission, _ = exported["rec1"]
    assert f"0x{checksum(mission):08x}u" in mission_source(mission)
    other = replace(mission, numbers={**mission.numbers, "flow": mission.numbers["flow"] * (1.0 + 2.0**-52)})
    assert checksum(other) != checksum(mission)


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("level", ["-O0", "-O3"])
def test_no_compiler_changes_a_plan(
    compiler: str, level: str, exported: Exported, missions: Missions,
    tmp_path: Path,
) -> None:  # fmt: skip
    scenario, _, folder = exported["rec1"]
    other = CMission(folder, tmp_path / "other.so", compiler, level)
    for start in starts(scenario)[:3]:
        assert other.plan(start).bits == missions["rec1"].plan(start).bits


def selftest(folder: Path, compiler: tuple[str, ...], emulator: tuple[str, ...], *options: str) -> str:
    """Build the mission's self-test with the README's line and run it."""
    text = (folder / "README.md").read_text().replace("\\\n", " ")
    line = re.search(r"^ {4}cc (.*mission_selftest\.c.*) -o mission_selftest", text, re.MULTILINE)
    assert line
    words = [word for word in line[1].split() if word != "-O2"]
    expanded = [
        str(path) for word in words for path in (sorted(folder.glob(word)) if "*" in word else [word])
    ]
    made = folder / f"mission_selftest{len(list(folder.iterdir()))}"
    command = [*compiler, *STRICT[1:], *options, *expanded, "-o", str(made)]
    built = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    done = subprocess.run([*emulator, str(made)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_selftest_finds_the_recorded_plans_on_every_machine(exported: Exported) -> None:
    _, mission, folder = exported["rec1"]
    assert len(mission.plans) == 2
    here = selftest(folder, ("gcc",), (), "-O2")
    assert here.count("the recorded plan") == 2
    checked = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    assert selftest(folder, ("gcc",), (), *checked) == here
    need("aarch64-linux-gnu-gcc", "qemu-aarch64")
    assert selftest(folder, ("aarch64-linux-gnu-gcc",), ("qemu-aarch64",), "-static", "-O2") == here


def test_the_selftest_notices_another_plan(exported: Exported, tmp_path: Path) -> None:
    _, mission, _ = exported["rec1"]
    first = mission.plans[0]
    wrong = replace(first, controls=first.controls + 2.0 * AGREES)
    orbsoc.export_c(mission.problem, tmp_path / "c", mission=replace(mission, plans=(first, wrong)))
    with pytest.raises(AssertionError, match="ANOTHER PLAN"):
        selftest(tmp_path / "c", ("gcc",), (), "-O1")


def test_the_missions_text_and_stack_are_as_stated(tmp_path: Path) -> None:
    need("aarch64-linux-gnu-gcc", "aarch64-linux-gnu-size")
    compile_ = ["aarch64-linux-gnu-gcc", *STRICT, "-O2", f"-I{FLIGHT}", "-fstack-usage", "-c"]
    sources = [*MISSIONS.glob("*.c"), *FLIGHT.glob("*.c")]
    subprocess.run([*compile_, *map(str, sources)], cwd=tmp_path, check=True)
    objects = [str(tmp_path / f"{path.stem}.o") for path in MISSIONS.glob("*.c")]
    size = subprocess.run(["aarch64-linux-gnu-size", *objects], capture_output=True, text=True, check=True)
    text = sum(int(line.split()[0]) for line in size.stdout.splitlines()[1:])
    assert text < 12_000
    frames = [line.split("\t") for path in tmp_path.glob("*.su") for line in path.read_text().splitlines()]
    assert all(kind == "static" for _, _, kind in frames), "no frame grows"
    largest = {name.rpartition(":")[2]: int(size_) for name, size_, _ in frames}
    above = ("orbsoc_insertion_plan", "run_sequence", "advance", "solve_subproblem")
    stage = ("orbsoc_solve_from", "solve_with_restarts", "follow", "orbsoc_run", "solve_sides", "refine_sides",
             "orbsoc_refine", "orbsoc_measure", "orbsoc_statistics", "substitute", "residual")  # fmt: skip
    assert sum(largest.get(name, 0) for name in (*above, *stage)) < STACK_BYTES
    flight = (
        "orbsoc_insertion_plan",
        "orbsoc_insertion_fly_plan",
        "fly",
        "rate_of",
        "orbsoc_insertion_programme",
    )
    assert sum(largest.get(name, 0) for name in flight) < STACK_BYTES


def test_the_sources_are_as_the_librarys() -> None:
    every = {path.name: path.read_text() for path in MISSIONS.iterdir()}
    assert _core.flight_mission_sources() == every
    text = "\n".join(every.values())
    assert not re.search(r"\b(malloc|calloc|realloc|free|alloca)\(", text)
    assert not re.search(r"^static (?!const|inline)[^(]*=", text, re.MULTILINE)
    assert set(re.findall(r"#include <(.*?)>", text)) == {"math.h", "string.h"}
    of_libm = r"\b(sin|cos|tan|atan2?|asin|acos|exp|log|pow|cbrt|hypot|fmod|fma|floor|ceil)f?\("
    assert set(re.findall(of_libm, text)) == set(), "of the mathematics roots and magnitudes alone"
    assert [line for line in text.splitlines() if len(line) > 100] == []


def test_a_state_on_the_target_has_no_mission() -> None:
    scenario = load_scenario(ROOT / "scenarios" / "rec1.toml")
    there = scenario.launch_inertial(scenario.target)
    with pytest.raises(ValueError, match="there is nothing to burn"):
        on_board(from_state(scenario, there).scenario, orbsoc.solve)


REFUSED = (
    ({"problem": "max_energy"}, "problem = 'max_energy'"),
    ({"burn": {"count": 2}}, "burn.count = 2"),
    ({"burn": {"ignition": "free"}}, "burn.ignition = 'free'"),
    ({"limits": {"attitude_rate_deg_s": 5.0}}, "limits.attitude_rate_deg_s = 5.0"),
    ({"burn": {"duration_s": 1.0}, "method": {"max_iterations": 1}}, "leads to no verified plan"),
)


@pytest.mark.parametrize(("changes", "words"), REFUSED)
def test_what_the_program_has_not_is_named(changes: dict[str, object], words: str) -> None:
    scenario = load_scenario(ROOT / "scenarios" / "rec1.toml").with_changes(**changes)
    with pytest.raises(ValueError, match=re.escape(words)):
        on_board(scenario, orbsoc.solve)


def test_the_command_exports_the_mission_or_says_why_not(tmp_path: Path) -> None:
    export = partial(CliRunner().invoke, app)
    rec1 = ROOT / "scenarios" / "rec1.toml"
    done = export(["export", "c", str(rec1), "--out", str(tmp_path / "whole")])
    assert done.exit_code == 0, done.output
    assert "the whole mission is among them" in done.output
    assert "# The whole mission" in (tmp_path / "whole" / "BOUNDS.md").read_text()
    largest = tmp_path / "largest.toml"
    largest.write_text(rec1.read_text().replace('problem = "min_time"', 'problem = "max_energy"'))
    for name, more, words in (
        (largest, [], "problem = 'max_energy'"), (rec1, ["--fp", "32"], "fp = 32"),
    ):  # fmt: skip
        out = tmp_path / f"solves{len(more)}"
        done = export(["export", "c", str(name), "--out", str(out), *more])
        assert done.exit_code == 0, done.output
        assert "the solves alone, without the whole mission;" in done.output
        assert words in done.output
        assert not (out / "mission.c").exists()
        assert (out / "pattern.c").exists()


def test_a_mission_is_in_binary64(exported: Exported, tmp_path: Path) -> None:
    _, mission, _ = exported["rec1"]
    with pytest.raises(FlightError, match="exported in 64 alone"):
        orbsoc.export_c(mission.problem, tmp_path / "c", fp=32, mission=mission)
    assert not (tmp_path / "c").exists()
