/* Reset to main: floating point on, round to nearest, traps to traps.c, the program's zeros; main's result is the exit code. */
  .section .text.init
  .globl _start
_start:
  li t0, 0x6000
  csrs mstatus, t0
  csrw fcsr, zero
  la sp, __stack_top
  la t0, on_trap
  csrw mtvec, t0
  la t0, __bss_start
  la t1, __bss_end
1:
  bgeu t0, t1, 2f
  sd zero, 0(t0)
  addi t0, t0, 8
  j 1b
2:
  call main
  li t0, 0x11000008
  sw a0, 0(t0)
3:
  j 3b
