/* What a program needs of the board: bytes, halves and words of memory, products, an access to the engine's two ports that is answered
 * and one that is refused, and a byte from the serial line. PASS, then PASS again where the byte was a line's end; else FAIL. */
#include <stdint.h>

#include "orbsoc_registers.h"

#define SERIAL (*(volatile uint32_t *)0x10000000)
#define REFUSED (*(volatile uint32_t *)0x10000004)
#define AT(kind, address) (*(volatile kind *)(address))

static volatile uint32_t words[4] = {0x01020304u, 5u, 6u, 7u}; /* .data: copied at each start */
static volatile uint32_t zeros[4];

static void line(const char *text) {
  while (*text) SERIAL = (uint32_t)*text++;
  SERIAL = '\n';
}

static int memory_is_right(void) {
  const int fresh = words[0] == 0x01020304u && words[3] == 7u && zeros[2] == 0u;
  ((volatile uint8_t *)words)[1] = 0xaau;
  ((volatile uint16_t *)words)[1] = 0xbbccu;
  zeros[2] = words[1] * words[2] * 0x10001u + words[0] % 1000u;
  return fresh && words[0] == 0xbbccaa04u && zeros[2] == 30u * 0x10001u + 0xbbccaa04u % 1000u;
}

static int engine_is_right(void) {
  const uint32_t storage = ORBSOC_PL_MEMORIES + 4u * 77u;
  AT(uint32_t, storage) = 0x3f800000u;
  AT(uint32_t, storage + 4u) = 0x40000000u;
  const int right = (AT(uint32_t, ORBSOC_PL_REGISTERS + ORBSOC_REG_ENGINE) & 0xffu) == 1u && AT(uint32_t, storage) == 0x3f800000u &&
                    AT(uint32_t, storage + 4u) == 0x40000000u && REFUSED == 0u;
  AT(uint8_t, ORBSOC_PL_REGISTERS + ORBSOC_REG_LIMIT) = 1u; /* not all of its strobes */
  return right && AT(uint32_t, ORBSOC_PL_REGISTERS + ORBSOC_REG_LIMIT) == 0u && REFUSED == 1u;
}

int __wrap_main(void) {
  uint32_t byte;
  line(memory_is_right() && engine_is_right() ? "PASS" : "FAIL");
  while (((byte = SERIAL) & 0x100u) == 0u) {
  }
  line(byte == (0x100u | '\n') && (SERIAL & 0x100u) == 0u ? "PASS" : "FAIL");
  for (;;) {
  }
}
