"""selftest.c: recorded inputs, and the bits that the exact engine makes of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings

from .c_source import wrapped

Array = NDArray[np.float64]

STATUSES = (
    "SOLVED", "SOLVED_INACCURATE", "PRIMAL_INFEASIBLE", "DUAL_INFEASIBLE", "MAX_ITERATIONS", "MAX_TIME",
    "NUMERICAL_LIMIT", "INTERRUPTED",
)  # fmt: skip
_SCALARS = ("objective", "dual_objective", "primal_residual", "dual_residual", "gap", "radius")
"""Numbers of a solution before x, as the self-test compares them."""
_APART = 2.0**-20
"""Relative distance of a number of the data from the next, in the last recorded solve."""
_SHIFT = 1e-3
"""Relative size of what the recorded warm start is off."""


@dataclass(frozen=True, slots=True)
class Recorded:
    """A solve of the exact engine: where it started from (x, y, z, s), or nowhere, and its solution."""

    start: tuple[Array, Array, Array, Array] | None
    solution: Any
    moved: bool = False
    """Of data in which no two numbers are the same."""


def record(problem: Problem, settings: Settings, fp: int) -> list[Recorded]:
    """A cold solve, and one from a point near its solution where that is finite."""
    engine = _core.ExactEngine(problem, settings, fp)
    cold = engine.solve()
    out = [Recorded(None, cold)]
    point = [np.asarray(v, np.float64) for v in (cold.x, cold.y, cold.z, cold.s)]
    point[3] = np.where(np.isinf(point[3]), 1.0, point[3])
    if all(np.isfinite(v).all() for v in point) and problem.b.size + problem.h.size:
        random = np.random.default_rng(0)
        x, y, z, s = (v * (1.0 + _SHIFT * random.standard_normal(v.size)) for v in point)
        out.append(Recorded((x, y, z, s), engine.solve((x, y, z, s))))
    out.append(Recorded(None, _core.ExactEngine(moved(problem), settings, fp).solve(), moved=True))
    return out


def moved(problem: Problem) -> Problem:
    """The problem with each number a little larger than the one before, relative to what it was: as selftest.c does it.

    So a table that mistakes a number for another that equals it in the problem does not pass.
    """
    data = {
        name: values * (1.0 + _APART * np.arange(values.size)) for name, values in given_data(problem).items()
    }
    matrices = {}
    for name in "AG":
        matrix = getattr(problem, name)
        matrices[name] = sparse.csc_array((data[name.lower()], matrix.indices, matrix.indptr), matrix.shape)
    cost = problem.P
    columns = np.repeat(np.arange(cost.shape[1]), np.diff(cost.indptr))
    kept = np.asarray(cost.indices) <= columns
    upper = sparse.csc_array((data["p"], (np.asarray(cost.indices)[kept], columns[kept])), cost.shape)
    whole = upper + sparse.triu(upper, 1).T
    return Problem(P=whole, **matrices, c=data["c"], b=data["b"], h=data["h"], cones=problem.cones)


def given_data(problem: Problem) -> dict[str, Array]:
    """The data as the setters take them: P's upper triangle, A and G by columns, c, b, h."""
    cost = problem.P
    columns = np.repeat(np.arange(cost.shape[1]), np.diff(cost.indptr))
    upper = np.asarray(cost.data)[np.asarray(cost.indices) <= columns]
    data = {
        "p": upper,
        "a": problem.A.data,
        "g": problem.G.data,
        "c": problem.c,
        "b": problem.b,
        "h": problem.h,
    }
    return {name: np.ascontiguousarray(values, np.float64) for name, values in data.items()}


def selftest_source(problem: Problem, recorded: Sequence[Recorded]) -> str:
    """selftest.c, which returns how many recorded solves came out otherwise."""
    data = given_data(problem)
    parts = [_HEAD, f"#define ORBSOC_MOST_DATA {max(1, *(values.size for values in data.values()))}\n"]
    for name, values in data.items():
        parts.append(doubles(name, values))
    for k, each in enumerate(recorded):
        found = each.solution
        if each.start is not None:
            for name, values in zip("xyzs", each.start, strict=True):
                parts.append(doubles(f"start{k}_{name}", values))
        scalars = [getattr(found, name) for name in _SCALARS]
        bits = _bits(f"expected{k}", np.concatenate([scalars, found.x, found.y, found.z, found.s]))
        parts.append(_unless_short(bits) if each.moved else bits)
    parts.append(_MAIN_BEGIN)
    parts.extend(
        _unless_short(_call(k, each)) if each.moved else _call(k, each) for k, each in enumerate(recorded)
    )
    parts.append(_MAIN_END)
    return "\n".join(parts)


def _unless_short(text: str) -> str:
    """What ORBSOC_SHORT_SELFTEST leaves out, where a solve takes long."""
    return f"#ifndef ORBSOC_SHORT_SELFTEST\n{text}\n#endif"


def _call(k: int, each: Recorded) -> str:
    found = each.solution
    start = "orbsoc_solve(&solver)"
    if each.start is not None:
        points = ", ".join(f"start{k}_{name}" for name in "xyzs")
        start = f"orbsoc_solve_from(&solver, {points})"
    if each.moved:
        start = "solve_moved()"
    wanted = f"{STATUSES.index(found.status)}, {found.iterations}u, {found.refinements}u, {found.attempts}u"
    return f"  failed += judged({start}, {wanted}, expected{k});"


def doubles(name: str, values: Array) -> str:
    """A constant table of binary64 numbers in C, bit for bit."""
    items = ["(double)INFINITY" if np.isinf(value) else float(value).hex() for value in values.tolist()]
    return _array("double", name, items)


def _bits(name: str, values: Array) -> str:
    numbers = np.where(np.isnan(values), np.nan, values).view(np.uint64)
    return _array("uint64_t", name, [f"0x{word:016x}u" for word in numbers.tolist()])


def _array(kind: str, name: str, items: Iterable[str]) -> str:
    return f"static const {kind} {name}[] = {{\n{wrapped(list(items) or ['0'])}}};\n"


_HEAD = """/* Generated by orbsoc: recorded data, and the bits of their solutions. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "pattern.h"
#ifdef ORBSOC_PL_REGISTERS
#include "pl_program.h"
#endif

static orbsoc_arena arena;
static orbsoc_solver solver;
"""

_MAIN_BEGIN = """/* Whether words have these bits; every NaN counts as one number. */
static int same(const double *found, const uint64_t *expected, size_t count) {
  for (size_t k = 0; k < count; k++) {
    uint64_t word;
    memcpy(&word, &found[k], sizeof word);
    if (found[k] != found[k]) {
      word = 0x7ff8000000000000u;
    }
    if (word != expected[k]) {
      return 0;
    }
  }
  return 1;
}

/* 1 where a solve came out otherwise than recorded. */
static int judged(orbsoc_error error, int status, uint32_t iterations, uint32_t refinements,
                  uint32_t attempts, const uint64_t *expected) {
  const orbsoc_solution *found = &solver.solution;
  const double scalars[] = {found->objective, found->dual_objective, found->primal_residual,
                            found->dual_residual, found->gap, found->radius};
  const uint64_t *x = &expected[sizeof scalars / sizeof scalars[0]];
  const int right =
      error == ORBSOC_OK && same(scalars, expected, sizeof scalars / sizeof scalars[0]) && (int)found->status == status && found->iterations == iterations &&
      found->refinements == refinements && found->attempts == attempts &&
      same(found->x, x, ORBSOC_N) && same(found->y, &x[ORBSOC_N], ORBSOC_ROWS) &&
      same(found->z, &x[ORBSOC_N + ORBSOC_ROWS], ORBSOC_M) &&
      same(found->s, &x[ORBSOC_N + ORBSOC_ROWS + ORBSOC_M], ORBSOC_M);
  printf("%s in %u iterations: %s\\n", orbsoc_status_name(found->status),
         (unsigned)found->iterations, right ? "the recorded bits" : "OTHER BITS");
#ifdef ORBSOC_PL_REGISTERS
  printf("  place %d; first try: %s; second try: %s\\n", (int)found->place,
         orbsoc_pl_event_name(found->event[0]), orbsoc_pl_event_name(found->event[1]));
#endif
  return right ? 0 : 1;
}

#ifndef ORBSOC_SHORT_SELFTEST
/* Each number a little larger than the one before, relative to what it was. */
static const double *moved(size_t count, const double *values) {
  static double out[ORBSOC_MOST_DATA];
  for (size_t k = 0; k < count; k++) {
    out[k] = values[k] * (1.0 + 0x1p-20 * (double)k);
  }
  return out;
}

static orbsoc_error solve_moved(void) {
  const int set = orbsoc_set_p(&solver, moved(ORBSOC_NNZ_P, p)) == ORBSOC_OK &&
                  orbsoc_set_a(&solver, moved(ORBSOC_NNZ_A, a)) == ORBSOC_OK &&
                  orbsoc_set_g(&solver, moved(ORBSOC_NNZ_G, g)) == ORBSOC_OK &&
                  orbsoc_set_c(&solver, moved(ORBSOC_N, c)) == ORBSOC_OK &&
                  orbsoc_set_b(&solver, moved(ORBSOC_ROWS, b)) == ORBSOC_OK &&
                  orbsoc_set_h(&solver, moved(ORBSOC_M, h)) == ORBSOC_OK;
  return set ? orbsoc_solve(&solver) : ORBSOC_NO_DATA;
}
#endif

int main(void) {
  int failed = 0;
  const orbsoc_error error =
      orbsoc_open(&solver, &orbsoc_tables, &orbsoc_defaults, arena.work, ORBSOC_WORK_WORDS,
                  arena.numbers, ORBSOC_NUMBER_WORDS);
  if (error != ORBSOC_OK || orbsoc_set_p(&solver, p) != ORBSOC_OK ||
      orbsoc_set_a(&solver, a) != ORBSOC_OK || orbsoc_set_g(&solver, g) != ORBSOC_OK ||
      orbsoc_set_c(&solver, c) != ORBSOC_OK || orbsoc_set_b(&solver, b) != ORBSOC_OK ||
      orbsoc_set_h(&solver, h) != ORBSOC_OK) {
    printf("refused: error %d\\n", (int)error);
    return 100;
  }
#ifdef ORBSOC_PL_REGISTERS
  static orbsoc_pl_device device;
  (void)orbsoc_pl_attach(&solver, &device, &orbsoc_pl_program, ORBSOC_PL_REGISTERS, ORBSOC_PL_MEMORIES);
#endif"""

_MAIN_END = """  return failed;
}
"""
