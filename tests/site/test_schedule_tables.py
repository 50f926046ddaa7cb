"""The modelled tables of docs/pl-schedules.md and docs/pl-machine.md are those of today's scheduler, to the cycle.

Schedules depend on patterns alone, so that every machine makes the same.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from hw_model import load_partition, load_platform, parse_trace
from hw_model.area.budget import budget
from hw_model.area.engine import Shape, decoder_luts, logic_luts
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.hw.emulation import PsScheduler, resident_program
from orbsoc.hw.exact_cycles import exact_cycles
from orbsoc.hw.schedules import KKT_SOLVES, Engine, PlProgram, pl_program
from orbsoc.hw.workload import load_workload
from orbsoc.rtl.tables import WITH_RESIDUALS, tables
from orbsoc.rtl.validation import mission_004

ROOT = Path(__file__).resolve().parents[2]
SCENARIOS = ROOT / "scenarios"


@cache
def problem_of(letter: str) -> Problem:
    return mission_004(SCENARIOS / "rec1.toml", free_perigee=letter == "C")


def rows(page: str, head: str) -> list[list[str]]:
    """The cells of the table whose head begins so."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    lines = text[text.index(head) :].lstrip().splitlines()[2:]
    table = lines[: next(k for k, line in enumerate(lines) if not line.startswith("|"))]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table]


@cache
def printed(letter: str) -> list[list[list[str]]]:
    """The cells of the three tables that `orbsoc hw validate --tables` prints of a problem."""
    _, lines = tables({letter: problem_of(letter)})
    found = re.split(r"\n\n", "\n".join(lines[2:]))
    return [
        [[cell.strip() for cell in line.strip("|").split("|")] for line in one.splitlines()[2:]]
        for one in found
    ]


def test_streams_and_modules_of_problem_c() -> None:
    streams, modules, _ = printed("C")
    assert rows("pl-schedules.md", "| lanes | dividers | L, D and two solutions") == streams
    assert rows("pl-schedules.md", "| module, 4 lanes |") == modules


def test_operations_that_a_sentence_counts() -> None:
    """Of C's stream without and with residuals, and solves alone, on 4 lanes."""
    text = (ROOT / "docs" / "pl-schedules.md").read_text(encoding="utf-8")
    segments = pl_program(problem_of("C"), engine=Engine(lanes=4)).segments
    one, two = segments["solve_kkt"], segments["solve_pair"]
    (alone,), (whole,) = (
        pl_program(problem_of("C"), engine=Engine(lanes=4), stream=stream).segments.values()
        for stream in (KKT_SOLVES, WITH_RESIDUALS)
    )
    said = (
        f"The lanes have {thousands(alone.lane_operations)},", f"against {thousands(whole.lane_operations)},",
        f"({thousands(one.lower_bound)} of {thousands(one.cycles)} cycles, lanes busy for {one.utilisation:.0%})",
        f"two right-hand sides take {thousands(two.cycles)}",
        f"{thousands(whole.cycles)} cycles, not {thousands(segments['factorize'].cycles)} + {thousands(two.cycles)}",
    )  # fmt: skip
    assert one.bottleneck == "dependency"
    assert [sentence for sentence in said if sentence.replace("%", " %") not in " ".join(text.split())] == []


def test_savings_of_both_problems() -> None:
    made = [[f"{letter}, {row[0]}", *row[1:]] for letter in "CA" for row in printed(letter)[2]]
    assert rows("pl-schedules.md", "| problem, lanes |") == made


def thousands(number: float) -> str:
    return f"{number:,.0f}".replace(",", " ")


@cache
def _workload(name: str) -> tuple[Problem, Settings]:
    found = load_workload(SCENARIOS / name, "nested_dissection")
    return found.problems[0], found.settings[0]


@cache
def program(name: str, engine: Engine) -> PlProgram:
    """Of the first problem, resident, in the order of nested dissection."""
    problem, settings = _workload(name)
    return pl_program(problem, settings, engine, None, resident_program().streams)


LONGEST = "nt_scaling_scaling_blocks_factorize_predictor_rhs_solve_pair_check_pair"
STREAMS = {
    "scaling, factorization, two solves": LONGEST,
    "both refined": "refine_pair_check_pair",
    "predictor, corrector's solve": "store_pair_embedding_pivot_tau_step_direction_step_length_centering_cone_product_corrector_rhs_solve_kkt_check_solve",
    "refined": "refine_kkt_check_solve",
    "step, statistics": "store_step_tau_step_direction_slack_step_step_length_advance_statistics",
}
NAMES = ("rec1.toml", "rendezvous_40.json")


def test_chains_of_the_streams_on_many_lanes() -> None:
    engine = Engine(lanes=16, dividers=4, banks=32, clusters=8)
    for what, *cells in rows("pl-schedules.md", "| stream | `rec1`"):
        segments = [program(name, engine).segments[STREAMS[what]] for name in NAMES]
        assert all(segment.bottleneck == "dependency" for segment in segments)
        assert cells == [thousands(n) for one in segments for n in (one.compressed_cycles, one.lower_bound)]


def test_what_clusters_cost_and_save() -> None:
    area, shape = load_platform("zu9eg").area, ""
    for name, clusters, luts, *cycles in rows("pl-machine.md", "| lanes, dividers, banks | clusters"):
        shape = name or shape
        lanes, dividers, banks = map(int, shape.split(", "))
        engine = Engine(lanes=lanes, dividers=dividers, banks=banks, clusters=int(clusters))
        assert cycles == [thousands(program(each, engine).segments[LONGEST].cycles) for each in NAMES]
        made = Shape("f64", lanes, dividers, banks, 16, int(clusters))
        assert luts == thousands(round(logic_luts(made, area) + decoder_luts(made, area), -2))


def test_what_holds_the_program_of_problem_a() -> None:
    scheduler = PsScheduler()
    scheduler(problem_of("A"))
    trace = parse_trace(scheduler.trace)
    cycles = exact_cycles(scheduler.patterns, settings=scheduler.pattern_settings)
    stated, form = rows("pl-schedules.md", "| microcode | partition |"), ""
    for name, partition, *cells in stated:
        form = name or form
        settings = {"pl.microcode_format": form}
        found = [
            budget(trace, load_platform(device).with_values(settings), load_partition(partition.strip("`")), cycles)
            for device in ("zu9eg", "xc7z045", "xc7z020")
        ]  # fmt: skip
        used = next(use.used for use in found[0].uses if use.kind == "bram36")
        assert cells == [
            str(found[0].microcode_bram36), str(used), *("fits" if one.fits else "no" for one in found)
        ]  # fmt: skip
    assert len(stated) == 4
