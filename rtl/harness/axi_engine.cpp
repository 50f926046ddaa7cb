// A session (session.hpp) with the engine behind AXI, whose PS is the driver in C: axi_engine - . Beside the session's commands:
//   image_template WORD | image_line WORD | image_literal ADDRESS WORD | image_segment MODULE START READS WRITES STALES |
//   image_instruction WORD FLAG        ok       the next one of the image
//   image_identity WORD | image_digest WORD     ok       of the image
//   image_next                         ok       begin another image; the next commands are about it
//   load | beside                      ERROR    of the image
//   switch NUMBER                      ERROR    to an image, by its number from 0 on; the next commands are about it; decimal
//   publish NUMBER | launch NUMBER | attempt ENTRY CLOSING WRITTEN | stop | rest      ERROR
//   limit CLOCKS                       ERROR    decimal
//   poll BUDGET                        ERROR    decimal
//   interrupt CLOCKS                   ERROR    clock until the line is up, at most that often, then the handler; decimal
//   bursts SEED SIZE                   COUNT CLOCKS CLOCKS    fill storage by bursts of 16 beats of 2^SIZE bytes, read it back at
//                                      once: words that differ, and the clocks of writing and reading; a seed 0 never waits
//   poke ADDRESS WORD                  RESPONSE        one beat of 64 bits at a byte address of the memories
//   peek ADDRESS                       RESPONSE DATA
//   stream LATENCY BEATS PER SEED      ok       of the memory behind streamed microcode (axi_stream_memory.hpp); decimal
//   stream_error BEAT                  ok       with which it errs, counted from here on; -1: none; decimal
// ERROR is the driver's, decimal; other numbers are hexadecimal.
#include <deque>
#include <memory>

#include "axi_computer.hpp"
#include "session.hpp"
#include "start.hpp"

extern "C" {
uint32_t orbsoc_pl_read(uintptr_t address) {
  AxiComputer &computer = *AxiComputer::current;
  if (address < AxiComputer::MEMORIES) return computer.lite_read(uint16_t(address - AxiComputer::REGISTERS));
  std::vector<uint64_t> beats;
  if (computer.read_burst(address - AxiComputer::MEMORIES, 2, 1, beats)) computer.die("a read of the memories was refused");
  return uint32_t(beats[0] >> 32 * (address / 4 % 2));
}
uint32_t orbsoc_pl_bus_address(const void *data) { return AxiComputer::current->placed(data); }
void orbsoc_pl_write(uintptr_t address, uint32_t value) {
  AxiComputer &computer = *AxiComputer::current;
  if (address < AxiComputer::MEMORIES) computer.lite_write(uint16_t(address - AxiComputer::REGISTERS), value);
  else if (computer.write_burst(address - AxiComputer::MEMORIES, 2, {uint64_t(value) << 32 | value}))
    computer.die("a write to the memories was refused");
}
}

namespace {

class DriverSession : public Session<AxiComputer> {
 private:
  bool answer_more(const std::string &command, std::istringstream &words) override {
    if (command.rfind("image_", 0) == 0) return image(command.substr(6), words);
    if (command == "load" || command == "beside") {
      const orbsoc_pl_image *made = now().finished();
      return error(command == "load" ? orbsoc_pl_load(&computer.pl, made) : orbsoc_pl_load_beside(&computer.pl, made));
    }
    if (command == "switch") return (words >> current) && current < images.size() && error(orbsoc_pl_switch(&computer.pl, &now().whole));
    if (command == "publish" || command == "launch") return with_segment(command, words);
    if (command == "attempt") {
      orbsoc_pl_attempt attempt{};
      return (words >> std::hex >> attempt.entry >> attempt.closing >> attempt.written) && error(orbsoc_pl_launch_attempt(&computer.pl, &attempt));
    }
    if (command == "stop") return error(orbsoc_pl_stop(&computer.pl));
    if (command == "rest") return error(orbsoc_pl_require_rest(&computer.pl));
    uint64_t first = 0;
    if (command == "limit") return (words >> first) && error(orbsoc_pl_limit(&computer.pl, uint32_t(first)));
    if (command == "poll") return (words >> first) && error(orbsoc_pl_poll(&computer.pl, uint32_t(first)));
    if (command == "interrupt") return (words >> first) && interrupt(first);
    if (command == "stream") return stream(words);
    if (command == "stream_error") return (words >> computer.stream.error_at) && computer.stream.count_from_here() && ok();
    if (command == "bursts") return (words >> first) && bursts(uint32_t(first), words);
    if (command == "poke" || command == "peek") return (words >> std::hex >> first) && raw(command, first, words);
    return false;
  }

  static bool ok() {
    std::printf("ok\n");
    return true;
  }
  bool stream(std::istringstream &words) {
    StreamMemory &memory = computer.stream;
    return (words >> memory.latency >> memory.beats >> memory.per >> memory.seed) && memory.latency > 0 && memory.beats > 0 && ok();
  }
  static bool error(orbsoc_pl_error found) {
    std::printf("%d\n", int(found));
    return true;
  }
  bool image(const std::string &part, std::istringstream &words) {
    std::string word;
    words >> std::hex;
    if (part == "next") {
      current = images.size();
      images.emplace_back();
    } else if (part == "template" && words >> word) now().templates.push_back(uint32_t(std::stoul(word, nullptr, 16)));
    else if (part == "line" && words >> word) {
      for (uint32_t piece : AxiComputer::pieces(word, Built::CODE_WIDTH)) now().microcode.push_back(piece);
    } else if (part == "literal") {
      uint64_t address, value;
      if (!(words >> address >> value)) return false;
      now().literal_addresses.push_back(uint32_t(address));
      now().literals.push_back(value);
    } else if (part == "segment") {
      orbsoc_pl_segment one{};
      if (!(words >> one.module >> one.start >> one.reads >> one.writes >> one.stales)) return false;
      now().segments.push_back(one);
    } else if (part == "identity" || part == "digest") {
      if (!(words >> (part == "identity" ? now().identity : now().digest))) return false;
    } else if (part == "instruction") {
      orbsoc_pl_instruction one{};
      if (!(words >> one.word >> one.flag)) return false;
      now().instructions.push_back(one);
    } else {
      return false;
    }
    std::printf("ok\n");
    return true;
  }
  bool with_segment(const std::string &command, std::istringstream &words) {
    std::size_t number = 0;
    if (!(words >> std::hex >> number) || number >= now().segments.size()) return false;
    const auto act = command == "publish" ? orbsoc_pl_publish : orbsoc_pl_launch;
    return error(act(&computer.pl, uint32_t(number), &now().segments[number]));
  }
  bool interrupt(uint64_t clocks) {
    for (; clocks > 0 && !computer.interrupt(); --clocks) computer.clock();
    if (computer.interrupt()) orbsoc_pl_on_interrupt(&computer.pl);
    return error(orbsoc_pl_await(&computer.pl, 1));
  }

  bool bursts(uint32_t seed, std::istringstream &words) {
    constexpr uint64_t BEATS = 16;
    uint32_t size = 3;
    if (!(words >> size)) return false;
    computer.eager(seed == 0);
    const uint64_t bytes = uint64_t(Built::DEPTH) * Built::BANKS * (Built::FP / 8), beat = uint64_t(1) << size;
    uint64_t different = 0, state = seed, clocks[2] = {0, 0};
    for (uint64_t at = 0; at < bytes; at += BEATS * beat) {
      std::vector<uint64_t> sent, got;
      for (uint64_t i = 0; i < BEATS; ++i) sent.push_back(state = state * 6364136223846793005u + 1442695040888963407u);
      const uint64_t before = computer.clocks;
      const uint32_t refused = computer.write_burst(at, size, sent);
      const uint64_t between = computer.clocks;
      if (refused | computer.read_burst(at, size, BEATS, got)) return false;
      clocks[0] += between - before;
      clocks[1] += computer.clocks - between;
      for (uint64_t i = 0; i < BEATS; ++i) {
        const uint64_t half = size == 3 ? ~uint64_t(0) : 0xffffffffull << 32 * ((at / 4 + i) % 2);
        different += (sent[i] & half) != (got[i] & half);
      }
    }
    computer.eager(false);
    std::printf("%" PRIx64 " %" PRIx64 " %" PRIx64 "\n", different, clocks[0], clocks[1]);
    return true;
  }
  bool raw(const std::string &command, uint64_t address, std::istringstream &words) {
    uint64_t word = 0;
    std::vector<uint64_t> beats;
    if (command == "poke") {
      if (!(words >> word)) return false;
      std::printf("%" PRIx32 "\n", computer.write_burst(address, 3, {word}));
    } else {
      const uint32_t response = computer.read_burst(address, 3, 1, beats);
      std::printf("%" PRIx32 " %" PRIx64 "\n", response, beats[0]);
    }
    return true;
  }

  // What the driver is given, and may keep the address of.
  struct Image {
    std::vector<uint32_t> microcode, templates, literal_addresses;
    std::vector<uint32_t> parts;  // of streamed microcode: lines as the ports read them
    std::vector<uint64_t> literals;
    std::vector<orbsoc_pl_segment> segments;
    std::vector<orbsoc_pl_instruction> instructions;
    uint32_t identity = 0, digest = 0;
    orbsoc_pl_image whole{};
    const orbsoc_pl_image *finished() {
      const uint32_t pieces = ORBSOC_PIECES(Built::CODE_WIDTH);
      if (Built::STREAM) split();
      whole = {Built::FP == 64, Built::ADDRESS_BITS, Built::CODE_WIDTH, Built::STREAM ? parts.data() : microcode.data(), uint32_t(microcode.size() / pieces),
               templates.data(), uint32_t(templates.size()), literal_addresses.data(), literals.data(), literals.size(),
               segments.data(), uint32_t(segments.size()), instructions.data(), uint32_t(instructions.size()), identity, digest};
      return &whole;
    }
    void split() {
      constexpr std::size_t LINE = ORBSOC_PIECES(Built::CODE_WIDTH), PORTS = Built::STREAM ? Built::STREAM : 1, PART = LINE / PORTS;
      const std::size_t lines = microcode.size() / LINE, align = ORBSOC_STREAM_ALIGN / 4, apart = (lines * PART + align - 1) / align * align;
      parts.assign(PORTS * apart, 0);
      for (std::size_t i = 0; i < microcode.size(); ++i)
        parts[i % LINE / PART * apart + i / LINE * PART + i % PART] = microcode[i];
      AxiComputer::current->place(parts.data(), 4 * parts.size());
    }
  };
  Image &now() { return images[current]; }

  std::deque<Image> images = std::deque<Image>(1);
  std::size_t current = 0;
};

}  // namespace

int main(int argc, char **argv) {
  if (argc != 2 || std::string(argv[1]) != "-") {
    std::fprintf(stderr, "usage: axi_engine -\n");
    return 2;
  }
  begin_as_engine(Built::PARITY);
  try {
    return std::make_unique<DriverSession>()->run(std::cin) ? 0 : 2;
  } catch (const std::exception &failure) {
    std::fprintf(stderr, "axi_engine: %s\n", failure.what());
    return 2;
  }
}
