// Runs validation cases (docs/pl-machine.md) on the engine: engine FILE ...      (engine - : a session, session.hpp)
// Loads the microcode; per run sets the memory, starts the segment through the registers, waits for the interrupt,
// and compares cycles and words. Exits 0 only if all is equal and no rule of a schedule was violated.
#include <cinttypes>
#include <cstdio>
#include <memory>

#include "case_file.hpp"
#include "computer.hpp"
#include "session.hpp"

namespace {

constexpr int MATRIX_UPDATE = 1, THE_SEGMENT = 1, START = 1, FIRST_DIFFERENCES = 10;
constexpr uint32_t BUSY_BIT = 1, DONE_BIT = 2, FAULT_BITS = 0xf00;

void check_config(const Case &c) {
  const std::map<std::string, uint64_t> built = {{"fp", PL_FP},
                                                 {"lanes", PL_LANES},
                                                 {"dividers", PL_DIVIDERS},
                                                 {"banks", PL_BANKS},
                                                 {"address_bits", PL_ADDRESS_BITS}};
  for (const auto &[key, value] : built) {
    if (c.config.at(key) != value)
      throw std::runtime_error("this engine has " + key + " " + std::to_string(value) + ", the case wants " +
                               std::to_string(c.config.at(key)));
  }
  const char *formats[] = {"flat", "compressed", "in_order"};
  if (c.format != formats[PL_SEQUENCER])
    throw std::runtime_error(std::string("this engine runs ") + formats[PL_SEQUENCER] + " microcode, the case has " + c.format);
}

// The segment through the registers, as the PS does it; false if it did not come to its end.
bool launch(Computer &computer, const Run &run) {
  const uint16_t entry = TABLE + 64 * THE_SEGMENT;
  for (uint16_t offset = 8; offset < 32; offset += 4) computer.write_register(uint16_t(entry + offset), 0);
  computer.write_register(uint16_t(entry + 4), uint32_t(run.start));
  computer.write_register(entry, MATRIX_UPDATE);
  computer.set_gaps(uint32_t(run.seed), uint32_t(run.level));
  computer.write_register(MODULE, MATRIX_UPDATE);
  computer.write_register(SEGMENT, THE_SEGMENT);
  computer.write_register(SEQUENCE, 1);
  computer.write_register(CONTROL, START);
  for (uint64_t limit = 4 * run.cycles + 100000; !computer.interrupt() && limit > 0; --limit) computer.clock();
  const uint32_t status = computer.read_register(STATUS);
  if ((status & DONE_BIT) == 0 || (status & (BUSY_BIT | FAULT_BITS)) != 0) {
    std::printf("status %08" PRIx32 " interrupt %d after %" PRIu64 " busy cycles\n", status, computer.interrupt(),
                computer.busy_cycles);
    return false;
  }
  computer.write_register(IRQ_ACK, 1);
  return !computer.interrupt();
}

bool execute(Computer &computer, const Run &run) {
  computer.reset();
  for (const auto &[address, word] : run.memory) computer.write_word(address, word);
  computer.settle();
  const bool ended = launch(computer, run);
  const uint64_t cycles = computer.busy_cycles;

  std::vector<std::string> differences;
  uint64_t different = 0;
  for (const auto &[address, word] : run.expect) {
    const uint64_t found = computer.read_word(address);
    if (found == word) continue;
    if (different++ < FIRST_DIFFERENCES) {
      char line[120];
      std::snprintf(line, sizeof line, "differ %" PRIx64 " expected %" PRIx64 " found %" PRIx64, address, word, found);
      differences.push_back(line);
    }
  }
  uint64_t asserted = 0;
  for (uint64_t count : computer.violations) asserted += count;
  std::printf("run %s cycles %" PRIu64 " expected %" PRIu64 " different %" PRIu64 " asserted %" PRIu64 "\n", run.name.c_str(),
              cycles, run.cycles, different, asserted);
  for (int i = 0; i < RULE_COUNT; ++i)
    if (computer.violations[i]) std::printf("assert %s %" PRIu64 "\n", RULES[i], computer.violations[i]);
  for (const auto &line : differences) std::printf("%s\n", line.c_str());
  if (computer.counted() != cycles) {
    std::printf("counter %" PRIu32 " where busy was up for %" PRIu64 "\n", computer.counted(), cycles);
    return false;
  }
  return ended && cycles == run.cycles && different == 0 && asserted == 0;
}

}  // namespace

int main(int argc, char **argv) {
  bool good = argc > 1;
  if (!good) std::fprintf(stderr, "usage: engine FILE ... | engine -\n");
  try {
    if (argc == 2 && std::string(argv[1]) == "-") return std::make_unique<Session>()->run(std::cin) ? 0 : 2;
    for (int i = 1; i < argc; ++i) {
      const Case c = CaseReader(argv[i]).read();
      check_config(c);
      const auto computer = std::make_unique<Computer>();
      for (std::size_t k = 0; k < c.templates.size(); ++k) computer->load_template(k, c.templates[k]);
      for (std::size_t k = 0; k < c.microcode.size(); ++k) computer->load_line(k, c.microcode[k]);
      for (const Run &run : c.runs) good = execute(*computer, run) && good;
    }
  } catch (const std::exception &error) {
    std::fprintf(stderr, "engine: %s\n", error.what());
    return 2;
  }
  return good ? 0 : 1;
}
