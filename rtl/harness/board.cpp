// Runs the image memory.hex of the current folder on the board's computer: board LIMIT CLOCKS [RUNS], CLOCKS of a bit on the serial
// line. What comes over the line is the output. After a line PASS or FAIL a byte goes back, which begins it anew, until there were RUNS
// of them (default 1). Exit status: 0 where all were PASS, 1 where one was FAIL, 3 where the core trapped, 124 after LIMIT clocks.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "Vulx3s.h"
#include "serial.hpp"
#include "start.hpp"
#include "verilated.h"

int main(int count, char **arguments) {
  if (count < 3) {
    std::fprintf(stderr, "board LIMIT CLOCKS [RUNS]\n");
    return 2;
  }
  VerilatedContext context;
  begin_with_bits_of(seed_of_start(0), context);  // an FPGA's begin so, and the core is not ours
  Vulx3s top{&context};
  const uint64_t limit = std::strtoull(arguments[1], nullptr, 10);
  Serial serial{std::atoi(arguments[2])};
  int runs = count > 3 ? std::atoi(arguments[3]) : 1;
  std::string line;
  int code = 0;
  top.btn_pwr_n = 1;
  for (uint64_t clocks = 0; clocks < limit && runs > 0; ++clocks) {
    top.ftdi_txd = serial.out();
    top.clk_25mhz = 0;
    top.eval();
    top.clk_25mhz = 1;
    top.eval();
    if (clocks < 32) continue;  // the board's own reset
    if (top.led >> 7) {
      std::printf("trapped\n");
      return 3;
    }
    const int came = serial.in(top.ftdi_rxd);
    if (came < 0) continue;
    std::putchar(came);
    if (came != '\n') {
      line.push_back(char(came));
      continue;
    }
    if (line == "PASS" || line == "FAIL") {
      runs -= 1;
      if (line == "FAIL") code = 1;
      serial.send('\n');
    }
    line.clear();
  }
  std::fflush(stdout);
  top.final();
  return runs == 0 ? code : 124;
}
