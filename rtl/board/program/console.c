/* printf of picolibc to the board's serial line (board_registers.sv). */
#include <stdint.h>
#include <stdio.h>

static int put(char letter, FILE *file) {
  (void)file;
  *(volatile uint32_t *)0x10000000 = (uint8_t)letter;
  return (unsigned char)letter;
}

static FILE console = FDEV_SETUP_STREAM(put, NULL, NULL, _FDEV_SETUP_WRITE);
FILE *const stdin = &console;
FILE *const stdout = &console;
FILE *const stderr = &console;
