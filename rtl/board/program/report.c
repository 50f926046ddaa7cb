/* The self-test of an export (docs/flight-code.md) with what a board should tell. The linker puts these functions around its own and
 * the flight library's (--wrap), which are not changed by it. Lines, for one solve:
 *   engine IDENTITY: …            as the engine's registers say
 *   STATUS in COUNT iterations: the recorded bits | OTHER BITS, and where it was solved   (selftest.c)
 *   clocks: …                     of the engine, for the launch; of the core, for the whole solve with the load of the program
 *   answer HASH                   FNV-1a of the bits of x, y, z, s, low bytes first
 *   PASS | FAIL                   PASS: the recorded bits, from the engine at its first try, and no access refused
 * Then it waits for a byte, and begins anew. LEDs: 1 it runs, 2 PASS, 4 FAIL. */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "orbsoc_device.h"
#include "pattern.h"

#define SERIAL (*(volatile uint32_t *)0x10000000)
#define LEDS (*(volatile uint32_t *)0x10000004)
#define REFUSED (*(volatile uint32_t *)0x10000004)
#define CAME 0x100u

static const orbsoc_pl_device *device;
static const orbsoc_solution *found;
static uint32_t core_clocks;

static uint32_t now(void) {
  uint32_t clocks;
  __asm__ volatile("rdcycle %0" : "=r"(clocks)::"memory");
  return clocks;
}

static uint32_t hashed(uint32_t hash, const double *words, size_t count) {
  const uint8_t *bytes = (const uint8_t *)words;
  for (size_t k = 0; k < count * sizeof *words; ++k) hash = (hash ^ bytes[k]) * 16777619u;
  return hash;
}

orbsoc_error __real_orbsoc_attach(orbsoc_solver *solver, const orbsoc_partition *partition, const orbsoc_device *hook);
orbsoc_error __wrap_orbsoc_attach(orbsoc_solver *solver, const orbsoc_partition *partition, const orbsoc_device *hook) {
  device = (const orbsoc_pl_device *)hook->context;
  return __real_orbsoc_attach(solver, partition, hook);
}

orbsoc_error __real_orbsoc_solve(orbsoc_solver *solver);
orbsoc_error __wrap_orbsoc_solve(orbsoc_solver *solver) {
  const uint32_t since = now();
  const orbsoc_error error = __real_orbsoc_solve(solver);
  core_clocks = now() - since;
  found = &solver->solution;
  const orbsoc_pl *pl = &device->pl;
  printf("engine %08lx: %u lane, binary%s, 2^%u words, 2^%u lines of %u bits\n", (unsigned long)pl->identity,
         (unsigned)(pl->engine & 0x7fu), pl->binary64 ? "64" : "32", (unsigned)pl->address_bits, (unsigned)pl->code_bits,
         (unsigned)pl->code_width);
  return error;
}

int __real_main(void);
int __wrap_main(void) {
  LEDS = 1;
  found = NULL;
  const int failed = __real_main();
  if (found != NULL) {
    uint32_t hash = hashed(2166136261u, found->x, ORBSOC_N);
    hash = hashed(hash, found->y, ORBSOC_ROWS);
    hash = hashed(hash, found->z, ORBSOC_M);
    hash = hashed(hash, found->s, ORBSOC_M);
    printf("clocks: %lu of the engine, %lu of the core\n", (unsigned long)orbsoc_pl_spent(&device->pl), (unsigned long)core_clocks);
    printf("answer %08lx\n", (unsigned long)hash);
  }
  const int passed = failed == 0 && found != NULL && found->place == ORBSOC_ON_DEVICE && REFUSED == 0;
  LEDS = passed ? 2 : 4;
  printf(passed ? "PASS\n" : "FAIL\n");
  while ((SERIAL & CAME) == 0) {
  }
  return 0;
}
