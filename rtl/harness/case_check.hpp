// Check that a case fits this engine: configuration and format, and every word, address and run.
#pragma once
#include <set>
#include <stdexcept>
#include <string>

#include "case_file.hpp"
#include "computer.hpp"

inline void check_config(const Case &c) {
  const std::map<std::string, uint64_t> built = {{"fp", Built::FP},
                                                 {"lanes", Built::LANES},
                                                 {"dividers", Built::DIVIDERS},
                                                 {"banks", Built::BANKS},
                                                 {"clusters", Built::CLUSTERS},
                                                 {"address_bits", Built::ADDRESS_BITS}};
  for (const auto &[key, value] : built) {
    if (c.config.at(key) != value)
      throw std::runtime_error("this engine has " + key + " " + std::to_string(value) + ", the case wants " +
                               std::to_string(c.config.at(key)));
  }
  const char *formats[] = {"flat", "compressed", "in_order"};
  if (c.format != formats[Built::SEQUENCER])
    throw std::runtime_error(std::string("this engine runs ") + formats[Built::SEQUENCER] + " microcode, the case has " + c.format);
}

// Significant bits of hexadecimal digits.
inline uint64_t bits_of(const std::string &hex) {
  const std::size_t first = hex.find_first_not_of('0');
  if (first == std::string::npos) return 0;
  uint64_t bits = 4 * (hex.size() - first);
  for (int digit = std::stoi(hex.substr(first, 1), nullptr, 16); digit < 8; digit <<= 1) --bits;
  return bits;
}

inline void check_widths(const std::string &what, const std::vector<std::string> &words, uint64_t width) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (bits_of(words[i]) > width)
      throw std::runtime_error(what + " " + std::to_string(i) + ": '" + words[i] + "' has " + std::to_string(bits_of(words[i])) +
                               " bits, this engine's have " + std::to_string(width));
  }
}

inline void check_words(const Run &run, const std::string &list, const std::vector<std::pair<uint64_t, uint64_t>> &words) {
  char token[20];
  for (const auto &[address, word] : words) {
    std::snprintf(token, sizeof token, "%llx", static_cast<unsigned long long>(address >= STORAGE_WORDS ? address : word));
    if (address >= STORAGE_WORDS)
      throw std::runtime_error("run " + run.name + ", " + list + ": address '" + token + "' is beyond the storage, which has " +
                               std::to_string(STORAGE_WORDS) + " words");
    if ((word & ~WORD_MASK) != 0)
      throw std::runtime_error("run " + run.name + ", " + list + ": word '" + token + "' is wider than " + std::to_string(Built::FP) + " bits");
  }
}

// Runs partition the microcode: each starts at the first line or where another ends, and ends at the last line or where
// another starts.
inline void check_runs(const Case &c) {
  const uint64_t lines = c.microcode.size();
  std::set<uint64_t> starts = {lines}, ends = {0};
  for (const Run &run : c.runs) {
    const std::string start = "run " + run.name + ": start '" + std::to_string(run.start) + "'";
    const std::string words = "run " + run.name + ": words '" + std::to_string(run.words) + "'";
    if (run.start >= lines) throw std::runtime_error(start + " is beyond the microcode, which has " + std::to_string(lines) + " lines");
    if (run.words == 0 || run.words > lines - run.start)
      throw std::runtime_error(words + ": allowed is 1 to " + std::to_string(lines - run.start) + " from its start on");
    if (run.seed == 0 || run.seed > UINT32_MAX)
      throw std::runtime_error("run " + run.name + ": seed '" + std::to_string(run.seed) + "': allowed is 1 to 2^32 - 1");
    if (run.level > 255) throw std::runtime_error("run " + run.name + ": level '" + std::to_string(run.level) + "': allowed is 0 to 255");
    starts.insert(run.start);
    ends.insert(run.start + run.words);
  }
  for (const Run &run : c.runs) {
    if (!ends.count(run.start))
      throw std::runtime_error("run " + run.name + ": start '" + std::to_string(run.start) + "' is where no run ends");
    if (!starts.count(run.start + run.words))
      throw std::runtime_error("run " + run.name + ": words '" + std::to_string(run.words) + "' end where no run starts");
  }
}

inline void check_case(const Case &c) {
  check_config(c);
  if (c.templates.size() > Built::TEMPLATES)
    throw std::runtime_error("templates '" + std::to_string(c.templates.size()) + "': this engine holds " + std::to_string(Built::TEMPLATES));
  check_widths("template", c.templates, Built::TEMPLATE_WIDTH);
  check_widths("microcode line", c.microcode, Built::CODE_WIDTH);
  for (const Run &run : c.runs) {
    check_words(run, "memory", run.memory);
    check_words(run, "expect", run.expect);
  }
  check_runs(c);
}
