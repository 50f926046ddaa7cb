// Session over a pipe, so that any program can be the engine's PS: `engine -`. One command a line, one answer
// line each; numbers are hexadecimal but for counts.
//   reset                    ok
//   identity                 WORD       of the engine: its programs' must be the same
//   template INDEX WORD      ok
//   code ADDRESS WORD        ok         a line of microcode
//   set ADDRESS WORD         ok         a word of storage, while nothing runs
//   get ADDRESS              WORD
//   write REGISTER VALUE     ok
//   read REGISTER            VALUE
//   gaps SEED LEVEL          ok         fetch gaps (in order), decimal; the seed not 0, the level below 256
//   wait CYCLES              IRQ BUSY   clocks up to CYCLES (decimal) until the interrupt is up; whether it is, and how
//                                       many cycles the segment was busy by the engine's own counter, decimal
//   clocks                   N          of everything since the session began, decimal: a word set and a register access take
//                                       one, a word got takes four
//   segments                 S:N S:N …  that have ended since the last such command: number and busy cycles, decimal
//   violations               N N N N N N N N   since the reset, in the order of the rules, decimal
#pragma once
#include <cinttypes>
#include <cstdio>
#include <iostream>
#include <sstream>
#include <string>

#include "rules.hpp"

// `Computer` has the engine in it: computer.hpp, or axi_computer.hpp.
template <class Computer> class Session {
 public:
  virtual ~Session() = default;

  // Until the end of the input; false at the first line that is no command.
  bool run(std::istream &input) {
    std::string line;
    while (std::getline(input, line)) {
      std::istringstream words(line);
      std::string command;
      words >> command;
      if (!answer(command, words)) {
        std::fprintf(stderr, "engine: no command '%s'\n", line.c_str());
        return false;
      }
      std::fflush(stdout);
    }
    return true;
  }

 protected:
  // Commands that only this computer has.
  virtual bool answer_more(const std::string &, std::istringstream &) { return false; }

  Computer computer;

 private:
  bool answer(const std::string &command, std::istringstream &words) {
    uint64_t first = 0;
    std::string second = "0";
    const bool decimal = command == "gaps" || command == "wait";
    if (answer_more(command, words)) return true;
    const bool alone = command == "reset" || command == "violations" || command == "clocks" || command == "segments" || command == "identity";
    if (!alone && !(words >> (decimal ? std::dec : std::hex) >> first)) return false;
    if (!alone && command != "get" && command != "read" && command != "wait" && !(words >> second)) return false;
    if (command == "get") return print_hex(computer.read_word(first));
    if (command == "read") return print_hex(computer.read_register(uint16_t(first)));
    if (command == "wait") return wait(first);
    if (command == "violations") return violations();
    if (command == "clocks") return clocks();
    if (command == "segments") return segments();
    if (command == "identity") return print_hex(computer.identity());
    if (command == "reset") computer.reset();
    else if (command == "template") computer.load_template(first, second);
    else if (command == "code") computer.load_line(first, second);
    else if (command == "set") computer.write_word(first, std::stoull(second, nullptr, 16));
    else if (command == "write") computer.write_register(uint16_t(first), uint32_t(std::stoull(second, nullptr, 16)));
    else if (command == "gaps") return gaps(first, std::stoul(second));
    else return false;
    std::printf("ok\n");
    return true;
  }
  static bool print_hex(uint64_t value) {
    std::printf("%" PRIx64 "\n", value);
    return true;
  }
  bool wait(uint64_t cycles) {
    for (; cycles > 0 && !computer.interrupt(); --cycles) computer.clock();
    std::printf("%d %" PRIu32 "\n", computer.interrupt(), computer.counted());
    return true;
  }
  bool gaps(uint64_t seed, uint64_t level) {
    if (seed == 0 || seed > UINT32_MAX || level > 255) return false;  // fetch would never deliver
    computer.set_gaps(uint32_t(seed), uint32_t(level));
    std::printf("ok\n");
    return true;
  }
  bool clocks() {
    std::printf("%" PRIu64 "\n", computer.clocks);
    return true;
  }
  bool segments() {
    std::printf("segments");
    for (const auto &[number, cycles] : computer.segments) std::printf(" %" PRIu32 ":%" PRIu32, number, cycles);
    std::printf("\n");
    computer.segments.clear();
    return true;
  }
  bool violations() {
    for (int i = 0; i < RULE_COUNT; ++i) std::printf("%s%" PRIu64, i ? " " : "", computer.violations[std::size_t(i)]);
    std::printf("\n");
    return true;
  }
};
