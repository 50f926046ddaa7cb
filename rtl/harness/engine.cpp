// Runs validation cases (docs/pl-machine.md) on the engine: engine FILE ...      (engine - : a session, session.hpp)
// Loads the microcode and fills the storage; per run sets the memory, starts the segment through the registers, waits for
// the interrupt, and compares the engine's own counter and every word of storage. Exits 0 only if all is equal, status and
// interrupt are those of a segment that ended, and no rule of a schedule was violated; 1 if not; 2 for what it cannot run.
#include <cinttypes>
#include <cstdio>
#include <memory>

#include "case_check.hpp"
#include "case_file.hpp"
#include "computer.hpp"
#include "session.hpp"
#include "start.hpp"

namespace {

constexpr int MATRIX_UPDATE = 1, THE_SEGMENT = 1, THE_SEQUENCE = 1, START = 1, FIRST_DIFFERENCES = 10;
constexpr uint32_t DONE_BIT = 2, COMPLETED = uint32_t(THE_SEQUENCE) << 24 | uint32_t(THE_SEGMENT) << 16;

using Lines = std::vector<std::string>;

// One line if status or interrupt are not as expected.
void demand(Computer &computer, uint32_t wanted, bool interrupt, const char *when, Lines &complaints) {
  const bool raised = computer.interrupt();
  const uint32_t status = computer.read_register(STATUS);
  if (status == wanted && raised == interrupt) return;
  char line[120];
  std::snprintf(line, sizeof line, "status %08" PRIx32 " interrupt %d %s, not %08" PRIx32 " %d", status, raised, when, wanted, interrupt);
  complaints.push_back(line);
}

// Run the segment through the registers, as the PS does; one line for each unexpected status or interrupt.
Lines launch(Computer &computer, const Run &run) {
  Lines complaints;
  const uint16_t entry = TABLE + 64 * THE_SEGMENT;
  for (uint16_t offset = 8; offset < 32; offset += 4) computer.write_register(uint16_t(entry + offset), 0);
  computer.write_register(uint16_t(entry + 4), uint32_t(run.start));
  computer.write_register(entry, MATRIX_UPDATE);
  computer.set_gaps(uint32_t(run.seed), uint32_t(run.level));
  demand(computer, 0, false, "before the frame", complaints);
  computer.write_register(MODULE, MATRIX_UPDATE);
  computer.write_register(SEGMENT, THE_SEGMENT);
  computer.write_register(SEQUENCE, THE_SEQUENCE);
  computer.write_register(CONTROL, START);
  for (uint64_t limit = 4 * run.cycles + 10000; !computer.interrupt() && limit > 0; --limit) computer.clock();
  demand(computer, COMPLETED | DONE_BIT, true, "after the segment", complaints);
  computer.write_register(IRQ_ACK, THE_SEQUENCE);
  demand(computer, COMPLETED, false, "after the acknowledgement", complaints);
  return complaints;
}

// Pseudo-random words, all different, that no program computes by chance.
uint64_t filling(uint64_t address) {
  uint64_t word = (address + 1) * 0x9e3779b97f4a7c15;
  word = (word ^ (word >> 29)) * 0xbf58476d1ce4e5b9;
  return (word ^ (word >> 32)) & WORD_MASK;
}

// Fill the storage before the first run; returns its expected content.
std::vector<uint64_t> filled(Computer &computer) {
  std::vector<uint64_t> storage(STORAGE_WORDS);
  computer.reset();
  for (uint64_t address = 0; address < STORAGE_WORDS; ++address) {
    storage[address] = filling(address);
    computer.write_word(address, storage[address]);
  }
  computer.settle();
  return storage;
}

bool execute(Computer &computer, const Run &run, std::vector<uint64_t> &storage) {
  computer.reset();
  for (const auto &[address, word] : run.memory) computer.write_word(address, storage[address] = word);
  computer.settle();
  const Lines complaints = launch(computer, run);
  const uint64_t cycles = computer.counted(), busy = computer.busy_cycles;

  for (const auto &[address, word] : run.expect) storage[address] = word;
  const std::vector<uint64_t> found = computer.read_storage();
  Lines differences;
  uint64_t different = 0;
  for (uint64_t address = 0; address < STORAGE_WORDS; ++address) {
    if (found[address] == storage[address]) continue;
    if (different++ < FIRST_DIFFERENCES) {
      char line[120];
      std::snprintf(line, sizeof line, "differ %" PRIx64 " expected %" PRIx64 " found %" PRIx64, address, storage[address], found[address]);
      differences.push_back(line);
    }
  }
  storage = found;  // differences are not reported again for the next run
  uint64_t asserted = 0;
  for (uint64_t count : computer.violations) asserted += count;
  std::printf("run %s cycles %" PRIu64 " expected %" PRIu64 " different %" PRIu64 " asserted %" PRIu64 "\n", run.name.c_str(),
              cycles, run.cycles, different, asserted);
  for (int i = 0; i < RULE_COUNT; ++i)
    if (computer.violations[i]) std::printf("assert %s %" PRIu64 "\n", RULES[i], computer.violations[i]);
  for (const auto &line : differences) std::printf("%s\n", line.c_str());
  for (const auto &line : complaints) std::printf("%s\n", line.c_str());
  if (cycles != busy) std::printf("counter %" PRIu64 " where busy was up for %" PRIu64 "\n", cycles, busy);
  return complaints.empty() && cycles == busy && cycles == run.cycles && different == 0 && asserted == 0;
}

}  // namespace

int main(int argc, char **argv) {
  begin_as_engine(Built::PARITY);
  Verilated::commandArgs(argc, argv);  // a test's RTL may ask for a +NAME
  bool good = argc > 1;
  if (!good) std::fprintf(stderr, "usage: engine FILE ... | engine -\n");
  try {
    if (argc > 1 && std::string(argv[1]) == "-") return std::make_unique<Session<Computer>>()->run(std::cin) ? 0 : 2;
    for (int i = 1; i < argc; ++i) {
      const Case c = CaseReader(argv[i]).read();
      check_case(c);
      const auto computer = std::make_unique<Computer>();
      for (std::size_t k = 0; k < c.templates.size(); ++k) computer->load_template(k, c.templates[k]);
      for (std::size_t k = 0; k < c.microcode.size(); ++k) computer->load_line(k, c.microcode[k]);
      std::vector<uint64_t> storage = filled(*computer);
      for (const Run &run : c.runs) good = execute(*computer, run, storage) && good;
    }
  } catch (const std::exception &error) {
    std::fprintf(stderr, "engine: %s\n", error.what());
    return 2;
  }
  return good ? 0 : 1;
}
