# The traps of a program with a PL: an interrupt is served on a stack of its own, which mscratch holds and whose lines in the cache are
# none of the program's. The handler has no floating point, so none is saved. Any other trap goes on to traps.c as it came.
  .section .text.on_interrupt, "ax"
  .globl on_interrupt
  .balign 4
on_interrupt:
  csrrw sp, mscratch, sp
  sd t0, -8(sp)
  csrr t0, mcause
  bgez t0, 1f
  sd t1, -16(sp)
  sd t2, -24(sp)
  sd t3, -32(sp)
  sd t4, -40(sp)
  sd t5, -48(sp)
  sd t6, -56(sp)
  sd ra, -64(sp)
  sd a0, -72(sp)
  sd a1, -80(sp)
  sd a2, -88(sp)
  sd a3, -96(sp)
  sd a4, -104(sp)
  sd a5, -112(sp)
  sd a6, -120(sp)
  sd a7, -128(sp)
  addi sp, sp, -128
  call serve_interrupt
  addi sp, sp, 128
  ld t1, -16(sp)
  ld t2, -24(sp)
  ld t3, -32(sp)
  ld t4, -40(sp)
  ld t5, -48(sp)
  ld t6, -56(sp)
  ld ra, -64(sp)
  ld a0, -72(sp)
  ld a1, -80(sp)
  ld a2, -88(sp)
  ld a3, -96(sp)
  ld a4, -104(sp)
  ld a5, -112(sp)
  ld a6, -120(sp)
  ld a7, -128(sp)
  ld t0, -8(sp)
  csrrw sp, mscratch, sp
  mret
1:
  ld t0, -8(sp)
  csrrw sp, mscratch, sp
  tail on_trap
