"""What a console is read as, and how runs are compared; no simulation."""

from __future__ import annotations

from pathlib import Path

import pytest

from orbsoc.commands.hw_soc import _chosen, _window
from orbsoc.hw.workload import solves_of
from orbsoc.soc.counted import parsed
from orbsoc.soc.errors import SocError
from orbsoc.soc.runs import stage_names
from orbsoc.soc.table import REST, Comparison, summed, table
from orbsoc.soc.timeline import CORE, ENGINE, LINK, Span, document, segment_names, spans

ALONE = [
    "stage 0 1 100 40",
    "stage 4 9 900 300",
    "solve 1100 400",
    "SOLVED in 9 iterations: the recorded bits",
]
SPLIT = [
    "load 1 50 12", "put 4 30 8", "get 2 20 5", "segment 34 1 400 60 66", "solve 520 90",
    "SOLVED in 9 iterations: the recorded bits", "  place 1; first try: none; second try: none",
]  # fmt: skip


def test_parts_and_the_rest_make_the_whole() -> None:
    found = parsed(ALONE, stage_names())
    rows = summed([found, found])
    assert [row.name for row in rows] == ["equilibrate", "factorize", REST]
    assert [row.core_cycles for row in rows] == [200, 1800, 200]
    assert sum(row.core_cycles for row in rows) == 2 * found.core_cycles
    assert sum(row.instructions for row in rows) == 800


def test_speedup_is_without_loading_the_program() -> None:
    compared = Comparison((parsed(ALONE, stage_names()),), (parsed(SPLIT, stage_names()),))
    assert compared.loaded_cycles == 50
    assert compared.speedup == pytest.approx(1100 / 470)
    assert compared.same_bits


def test_an_attempt_is_a_part_on_the_pl() -> None:
    attempt = next(row for row in summed([parsed(SPLIT, stage_names())]) if row.where == "PL")
    assert (attempt.name, attempt.core_cycles, attempt.instructions, attempt.pl_cycles) == (
        "attempt",
        400,
        60,
        66,
    )
    rest = summed([parsed(SPLIT, stage_names())])[-1]
    assert (rest.name, rest.core_cycles, rest.instructions) == (REST, 20, 5)
    assert any(
        "attempt" in line and "76.9 %" in line for line in table([parsed(SPLIT, stage_names())], "split")
    )


def test_other_bits_are_told() -> None:
    other = [line.replace("the recorded bits", "OTHER BITS") for line in ALONE]
    assert not parsed(other, stage_names()).same_bits


def test_a_program_that_ends_early_is_an_error() -> None:
    with pytest.raises(SocError, match="before its first solve"):
        parsed(["refused: error 3"], stage_names())


@pytest.mark.parametrize("solves", ["0", "5", "1,x", "", "last"])
def test_wrong_numbers_of_solves_name_what_is_allowed(solves: str) -> None:
    with pytest.raises(ValueError, match="allowed is first, all, or numbers from 1 to 4"):
        _chosen(solves, 4)


def test_numbers_of_solves() -> None:
    assert (_chosen("first", 4), _chosen("all", 4), _chosen("1,3", 4)) == ([1], [1, 2, 3, 4], [1, 3])


def test_each_solve_has_the_settings_of_its_plan() -> None:
    plan = solves_of(Path(__file__).parents[2] / "scenarios" / "rec1.toml")
    assert [posed.settings.tol for posed in plan] == [1e-8, 1e-8, 1e-8, 1e-10]


def test_both_halves_stand_on_one_timeline() -> None:
    lines = [
        "pl 690 77", "pl 700 4", "pl 790 -1", "pl 800 5", "pl 850 0", "pl 860 -1",
        "solve 5 5", "event s 0 100 200", "event p 1 300 350", "event w 34 460 690", "event b 0 695 699",
    ]  # fmt: skip
    names, segments = stage_names(), segment_names()
    assert segments[4] == names[3]
    assert max(segments) > len(names)  # streams of several stages
    found = list(spans(lines, names, segments, 224, ("point", "slack")))
    assert found == [
        Span(ENGINE, names[3], 700, 790),
        Span(ENGINE, names[4], 800, 850),
        Span(CORE, "equilibrate", 324, 424),
        Span(LINK, "put slack", 524, 574),
        Span(CORE, "waits for the PL: attempt", 684, 914),
        Span(LINK, "publish", 919, 923),
    ]
    events = [event for event in document(found)["traceEvents"] if event["ph"] == "X"]
    assert [event["ts"] for event in events] == sorted(span.begin / 1000 for span in found)
    assert events[0]["dur"] == 0.1


@pytest.mark.parametrize("text", ["", "5", "1:0", "a:b", "-1:5"])
def test_a_wrong_window_of_waveforms_names_what_is_allowed(text: str) -> None:
    with pytest.raises(SocError, match="allowed is FIRST:COUNT"):
        _window(text)
