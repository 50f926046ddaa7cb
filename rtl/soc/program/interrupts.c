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

launch_state launched __attribute__((aligned(64)));
static volatile uint64_t stack[32] __attribute__((aligned(64)));

void on_interrupt(void); /* vector.S */

/* An interrupt by the controller's word of claims. */
__attribute__((noinline)) static void serve(volatile uint32_t *claim, launch_state *launch) {
  __asm__ volatile("fence rw, rw" ::: "memory"); /* what the trap has saved is there */
  const counters since = now();
  const uint32_t line = *claim;
  if (line == BUS) {
    orbsoc_pl_on_bus_error(&launch->device->pl);
    BUS_ERROR = 0;
  }
  if (line == PL) {
    launch->taken += 1;
    if (launch->device->pl.out == 0 || orbsoc_pl_on_interrupt(&launch->device->pl) != ORBSOC_PL_OK)
      ENABLED = 1u << BUS; /* it stays up */
  }
  __asm__ volatile("fence iorw, iorw" ::: "memory"); /* the line has fallen */
  if (line != 0) *claim = line;
  if (line == PL) add(&launch->spent, since);
}

void serve_interrupt(void) { serve(&CLAIM, &launched); }

void interrupts_rehearse(void) {
  static uint32_t registers[16]; /* all 0, as after a launch of segment 0 without a number */
  static orbsoc_pl_device device;
  static launch_state launch = {.device = &device};
  uint32_t claim = PL;
  const volatile uint64_t *state = (const volatile uint64_t *)&launched.device->pl;
  for (size_t k = 0; k < sizeof(orbsoc_pl) / sizeof *state; k += 8) (void)state[k];
  for (size_t k = 0; k < sizeof stack / sizeof *stack; k += 8) stack[k] = 0;
  device.pl.registers = (uintptr_t)registers;
  device.pl.flag_words = 1;
  device.pl.out = 1;
  serve(&claim, &launch);
}

void interrupts_begin(orbsoc_pl_device *device) {
  launched.device = device;
  __asm__ volatile("csrw mscratch, %0" ::"r"(stack + sizeof stack / sizeof *stack));
  __asm__ volatile("csrw mtvec, %0" ::"r"(on_interrupt));
  PRIORITY(PL) = 1;
  PRIORITY(BUS) = 1;
  THRESHOLD = 0;
  ENABLED = 1u << PL | 1u << BUS;
  __asm__ volatile("csrs mie, %0" ::"r"(EXTERNAL));
  __asm__ volatile("csrs mstatus, %0" ::"r"(ALL));
}
