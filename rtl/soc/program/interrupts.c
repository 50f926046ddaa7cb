/* The core's interrupt controller: line 1 is the PL's end of a launch, line 3 an error on the bus to it. This core takes no
 * trap from an access that its bus refuses, so the board raises a line (soc_board.sv). */
#include "interrupts.h"

#define PRIORITY(line) (*(volatile uint32_t *)(0x0c000000 + 4 * (line)))
#define ENABLED (*(volatile uint32_t *)0x0c002000)
#define THRESHOLD (*(volatile uint32_t *)0x0c200000)
#define CLAIM (*(volatile uint32_t *)0x0c200004)
#define BUS_ERROR (*(volatile uint64_t *)0x11000038)
#define EXTERNAL 0x800u
#define ALL 8u

enum { PL = 1, BUS = 3 };

uint64_t interrupts_taken;
counters interrupts_spent;
static orbsoc_pl_device *of;

void serve_interrupt(void) {
  const counters since = now();
  const uint32_t line = CLAIM;
  if (line == BUS) {
    orbsoc_pl_on_bus_error(&of->pl);
    BUS_ERROR = 0;
  }
  if (line == PL) {
    interrupts_taken += 1;
    if (of->pl.out == 0 || orbsoc_pl_on_interrupt(&of->pl) != ORBSOC_PL_OK) ENABLED = 1u << BUS; /* it stays up */
  }
  __asm__ volatile("fence iorw, iorw" ::: "memory"); /* the line has fallen */
  if (line != 0) CLAIM = line;
  if (line == PL) add(&interrupts_spent, since);
}

void interrupts_begin(orbsoc_pl_device *device) {
  of = device;
  PRIORITY(PL) = 1;
  PRIORITY(BUS) = 1;
  THRESHOLD = 0;
  ENABLED = 1u << PL | 1u << BUS;
  __asm__ volatile("csrs mie, %0" ::"r"(EXTERNAL));
  __asm__ volatile("csrs mstatus, %0" ::"r"(ALL));
}
