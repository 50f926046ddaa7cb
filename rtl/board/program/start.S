/* Reset to main: the program's words that change from their copy, its zeros, the stack; and again when main returns. */
  .section .text.init
  .globl _start
_start:
  la sp, __stack_top
  la t0, __data_begin
  la t1, __data_end
  la t2, __data_copy
1:
  bgeu t0, t1, 2f
  lw t3, 0(t2)
  sw t3, 0(t0)
  addi t0, t0, 4
  addi t2, t2, 4
  j 1b
2:
  la t1, __bss_end
3:
  bgeu t0, t1, 4f
  sw zero, 0(t0)
  addi t0, t0, 4
  j 3b
4:
  call main
  j _start
