// The register file alone, driven by a script on standard input, one access or event a line and a clock:
//   reset | write ADDRESS VALUE | read ADDRESS | end | upset   (hexadecimal; end: the segment's last busy cycle; upset: a bit
//   that turned over has been read)
// After each line: the answer of a read (else 0), STATUS, the interrupt, and whether a segment was started with where.
#include <cinttypes>
#include <cstdio>
#include <iostream>
#include <string>

#include "Vregisters.h"
#include "start.hpp"

int main() {
  begin_with_bits_of(seed_of_start());
  Vregisters dut;
  dut.clock = dut.run = dut.run_segment = dut.finished = 0;
  constexpr uint16_t STATUS = 0x10;
  std::string line;
  while (std::cin >> line) {
    uint32_t address = 0, value = 0, answer = 0;
    if (line == "write") std::cin >> std::hex >> address >> value;
    if (line == "read") std::cin >> std::hex >> address;
    dut.reset = line == "reset";
    dut.write = line == "write";
    dut.read = line == "read";
    dut.ended = line == "end";
    dut.wrong_parity = line == "upset";
    dut.address = uint16_t(address);
    dut.value = value;
    dut.clock = 0;
    dut.eval();
    if (dut.read) answer = dut.answer;
    const bool start = dut.start;
    const uint32_t first = start ? dut.start_address : 0;
    dut.clock = 1;
    dut.eval();
    dut.reset = dut.write = dut.read = dut.ended = dut.wrong_parity = 0;
    dut.address = STATUS;
    dut.eval();
    std::printf("%" PRIx32 " %" PRIx32 " %d %d %" PRIx32 "\n", answer, dut.answer, dut.irq, start, first);
  }
  return 0;
}
