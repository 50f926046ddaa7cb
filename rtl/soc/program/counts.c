/* Cycles of a solve, stage by stage, by the core's own counters. The linker puts these functions around the flight library's
 * (--wrap), which is not changed by it. A line a part, after the solve:
 *   stage NUMBER RUNS CYCLES INSTRUCTIONS      run on the core, NUMBER as in method.h
 *   solve CYCLES INSTRUCTIONS
 * What reading the counters costs is in the figures of the stages: about ten cycles a run. */
#include <stdint.h>
#include <stdio.h>

#include "counters.h"
#include "method.h"

#define STAGES 64

static uint64_t runs[STAGES];
static counters spent[STAGES];

static void print(const counters *sum) {
  printf("%llu %llu\n", (unsigned long long)sum->cycles, (unsigned long long)sum->instructions);
}

orbsoc_outcome __real_orbsoc_run(orbsoc_solver *solver, orbsoc_stage stage, int whole);
orbsoc_outcome __wrap_orbsoc_run(orbsoc_solver *solver, orbsoc_stage stage, int whole) {
  const counters since = now();
  const orbsoc_outcome outcome = __real_orbsoc_run(solver, stage, whole);
  add(&spent[stage], since);
  runs[stage] += 1;
  return outcome;
}

orbsoc_error __real_orbsoc_solve(orbsoc_solver *solver);
orbsoc_error __wrap_orbsoc_solve(orbsoc_solver *solver) {
  counters all = {0, 0};
  const counters since = now();
  const orbsoc_error error = __real_orbsoc_solve(solver);
  add(&all, since);
  for (int stage = 0; stage < STAGES; ++stage) {
    if (runs[stage] == 0) continue;
    printf("stage %d %llu ", stage, (unsigned long long)runs[stage]);
    print(&spent[stage]);
  }
  if (print_device) print_device();
  printf("solve ");
  print(&all);
  return error;
}
