/* printf of picolibc to the board's console (soc_board.sv). */
#include <stdint.h>
#include <stdio.h>

static int put(char letter, FILE *file) {
  (void)file;
  *(volatile uint64_t *)0x11000000 = (uint8_t)letter;
  return (unsigned char)letter;
}

static FILE console = FDEV_SETUP_STREAM(put, NULL, NULL, _FDEV_SETUP_WRITE);
FILE *const stdin = &console;
FILE *const stdout = &console;
FILE *const stderr = &console;
