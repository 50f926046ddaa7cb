/* The device of an export for a test in Python, which plays the PL: accesses go to functions of its own. */
#include "pl_program.h"

uint32_t (*read_hook)(uintptr_t);
void (*write_hook)(uintptr_t, uint32_t);
static orbsoc_pl_device device;

uint32_t orbsoc_pl_read(uintptr_t address) { return read_hook(address); }
void orbsoc_pl_write(uintptr_t address, uint32_t value) { write_hook(address, value); }

int pl_attach(orbsoc_solver *solver, uint32_t polls, uint32_t patience) {
  const int found =
      (int)orbsoc_pl_attach(solver, &device, &orbsoc_pl_program, 0x40000000u, 0x80000000u);
  device.polls = polls;
  solver->device.patience = patience;
  return found;
}

void pl_limit(uint32_t clocks) { device.limit = clocks; }

uint32_t pl_limit_of_program(void) { return orbsoc_pl_program.limit; }

void pl_bus_error(void) { orbsoc_pl_on_bus_error(&device.pl); }

int pl_place(const orbsoc_solver *solver) { return (int)solver->solution.place; }

uint32_t pl_event(const orbsoc_solver *solver, int one) { return solver->solution.event[one]; }

void pl_ask(orbsoc_solver *solver, orbsoc_ask ask) { solver->ask = ask; }
