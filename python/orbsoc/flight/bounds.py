"""BOUNDS.md: memory and operations of a solve, from the pattern and the settings alone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings

from .instructions import COMPILER, MARGIN, OPTIONS, SETS, list_instructions, solve_instructions
from .tables import Tables

STACK_BYTES = 2048
"""More than the frames on the deepest call path, aarch64 at -O2: tests/flight measures them. There is no recursion."""
TEXT_BYTES = 64_000
"""More than the library's text, aarch64 at -O2: tests/flight measures it."""
WARM_ATTEMPTS, COLD_ATTEMPTS = 5, 4
"""Most attempts of a solve under the restart policy, with and without a warm start."""

_TOTALS = ("| list | operations without refinement | with all refinement allowed |", "|---|---|---|")
Step = tuple[str, ...]


def stage_operations(problem: Problem, settings: Settings) -> dict[str, int]:
    """Floating-point operations of one run of each stage; multiply-adds count twice, moves not at all."""
    counts = _core.operation_counts(problem, settings, {})
    double = ("mul_add", "mul_sub")
    return {
        stage: sum(number * (2 if name in double else 1) for name, number in found["operations"].items())
        for stage, found in counts.items()
    }


def list_operations(steps: Iterable[Step], of: Mapping[str, int], refinements: int) -> int:
    """Operations of a list of steps with this many refinement steps in each repeated one."""
    total = 0
    for step in steps:
        if len(step) == 1:
            total += of[step[0]]
        else:
            stage, until = step
            total += of[until] + refinements * (of[stage] + of[until])
    return total


def worst_operations(of: Mapping[str, int], settings: Settings, attempts: int, *, warm: bool) -> int:
    """Of a whole solve that uses every iteration, refinement step and attempt that the settings allow."""
    most = settings.refinement_max
    cold = list_operations(_core.startup(), of, most)
    start = list_operations(_core.warm_startup(), of, most) if warm else cold
    each = settings.max_iterations * list_operations(_core.iteration(), of, most)
    closing = list_operations(_core.closing(), of, most) + of["statistics"]
    return start + (attempts - 1) * cold + attempts * (each + closing)


def ram_bytes(tables: Tables, fp: int) -> int:
    """Bytes of a solver's arena."""
    return tables.sizes["work_words"] * fp // 8 + tables.sizes["number_words"] * 8


def bounds_page(
    problem: Problem,
    settings: Settings,
    tables: Tables,
    fp: int,
    instructions: Mapping[str, int] | None = None,
) -> str:
    """The page; `instructions` are `instructions.bounds_of` the pattern, where they were counted."""
    of = stage_operations(problem, settings)
    restarts = settings.max_restarts
    cold, warm = min(COLD_ATTEMPTS, 1 + restarts), min(WARM_ATTEMPTS, 1 + restarts)
    lists = {
        "cold start-up": _core.startup(), "warm start-up": _core.warm_startup(), "iteration": _core.iteration(),
    }  # fmt: skip
    most = settings.refinement_max
    rows = [f"| {name} | {count} |" for name, count in of.items()]
    totals = [
        f"| {name} | {list_operations(steps, of, 0)} | {list_operations(steps, of, most)} |"
        for name, steps in lists.items()
    ]
    head, line, total_head, total_line, worst = "| stage | operations |", "|---|---|", *_TOTALS, ""
    if instructions is not None:
        head, line = "| stage | operations | instructions |", "|---|---|---|"
        rows = [f"{row} {instructions[name]} |" for row, name in zip(rows, of, strict=True)]
        total_head, total_line = f"{total_head} instructions | with all refinement |", f"{total_line}---|---|"
        totals = [
            f"{row} {list_instructions(steps, instructions, 0)} | {list_instructions(steps, instructions, most)} |"
            for row, steps in zip(totals, lists.values(), strict=True)
        ]
        around = ", ".join(
            f"{name} {instructions[name]}" for name in ("begin", "load_point", "conclude", "restart")
        )
        worst = (
            f"In instructions: {solve_instructions(instructions, settings, cold, warm=False)} from cold,"
            f" {solve_instructions(instructions, settings, warm, warm=True)} from a given point, with what stands around"
            f" the lists ({around}). Counted under QEMU, {COMPILER} {' '.join(OPTIONS)}, on {SETS} data sets of the"
            f" pattern; {MARGIN:.1%} and one are added to the most that was seen.\n"
        )
    return "\n".join(
        [
            "# Bounds\n",
            "From the pattern and the settings alone; no number of the data moves them.\n",
            "| memory | bytes |",
            "|---|---|",
            f"| tables, in flash | {tables.table_bytes} |",
            f"| library, in flash (aarch64, -O2) | below {TEXT_BYTES} |",
            f"| RAM: the arena | {ram_bytes(tables, fp)} |",
            f"| stack (aarch64, -O2), no recursion | below {STACK_BYTES} |",
            "| heap | 0 |\n",
            f"Allowed: {settings.max_iterations} iterations an attempt, {settings.refinement_max} refinement steps a linear"
            f" solve, {cold} attempts from cold and {warm} from a given point (max_restarts = {restarts}).\n",
            "Operations of one run of each stage (add, subtract, multiply, divide, root, compare, select; one multiply-add"
            " is two). A solve that decides on no residual skips it, and so stays below.\n",
            head,
            line,
            *rows,
            "",
            total_head,
            total_line,
            *totals,
            "",
            f"Worst case of a whole solve: {worst_operations(of, settings, cold, warm=False)} operations from cold,"
            f" {worst_operations(of, settings, warm, warm=True)} from a given point. The certificate on the original data"
            f" comes on top, once an attempt: its sums have fewer terms than three statistics stages.\n",
            worst,
        ]
    )
