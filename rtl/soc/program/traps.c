/* Where the core goes from a trap: an interrupt is served; anything else is told, and ends the program. Of a program with a PL, whose
 * vector.S keeps its interrupts, only the latter. */
#include <stdint.h>
#include <stdio.h>

#define EXIT (*(volatile uint64_t *)0x11000008)
#define INTERRUPT ((uint64_t)1 << 63)
#define TRAPPED 101u

void serve_interrupt(void) __attribute__((weak));

__attribute__((interrupt("machine"), aligned(4))) void on_trap(void) {
  uint64_t cause, place, value;
  __asm__ volatile("csrr %0, mcause" : "=r"(cause));
  if ((cause & INTERRUPT) != 0 && serve_interrupt) {
    serve_interrupt();
    return;
  }
  __asm__ volatile("csrr %0, mepc" : "=r"(place));
  __asm__ volatile("csrr %0, mtval" : "=r"(value));
  printf("trap: cause %llu at 0x%llx, value 0x%llx\n", (unsigned long long)cause, (unsigned long long)place, (unsigned long long)value);
  EXIT = TRAPPED;
  for (;;) {
  }
}
