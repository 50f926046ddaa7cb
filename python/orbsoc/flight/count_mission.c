/* Plans of a mission between marks, for count_instructions.c: a mark is a seek to a place that no file has.
 *
 *   count_mission FILE     one plan from each state in the file, six doubles each, SI
 *
 * Link with -Wl,--wrap=orbsoc_solve: what runs between two marks is then the outer loop alone, before the first solve, between
 * two, and after the last. After a plan stands its outcome on standard output: subproblems, objections. */
#include <stdio.h>
#include <unistd.h>

#include "mission.h"

#define MARK 0x4f530000L
enum { OUTER = 108, AFTER = 1000 };

orbsoc_error __real_orbsoc_solve(orbsoc_solver *solver);
orbsoc_error __wrap_orbsoc_solve(orbsoc_solver *solver);

static orbsoc_mission_arena arena;
static orbsoc_solver solver;
static orbsoc_planner planner;

static void mark(long number) { (void)lseek(0, MARK + number, SEEK_SET); }

orbsoc_error __wrap_orbsoc_solve(orbsoc_solver *given) {
  mark(AFTER);
  const orbsoc_error error = __real_orbsoc_solve(given);
  mark(OUTER);
  return error;
}

int main(int count, char **names) {
  double state[6];
  FILE *file = (count == 2) ? fopen(names[1], "rb") : NULL;
  if (file == NULL ||
      orbsoc_open(&solver, &orbsoc_tables, &orbsoc_defaults, arena.solver.work, ORBSOC_WORK_WORDS,
                  arena.solver.numbers, ORBSOC_NUMBER_WORDS) != ORBSOC_OK ||
      orbsoc_insertion_open(&planner, &orbsoc_mission, &solver, arena.plan, ORBSOC_PLAN_WORDS) != ORBSOC_OK) {
    return 1;
  }
  while (fread(state, sizeof state, 1, file) == 1u) {
    mark(OUTER);
    const orbsoc_error error = orbsoc_insertion_plan(&planner, state, &state[3]);
    mark(AFTER);
    printf("%u %u %d\n", (unsigned)planner.plan.subproblems, (unsigned)planner.plan.objections, (int)error);
  }
  return 0;
}
