// Validation cases of docs/pl-machine.md: a configuration, microcode, and runs with memory and expected words.
#pragma once
#include <cstdint>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

struct Run {
  std::string name;
  uint64_t start = 0, words = 0, cycles = 0;
  uint64_t seed = 1, level = 0;
  std::vector<std::pair<uint64_t, uint64_t>> memory, expect;  // word address, content
};

struct Case {
  std::map<std::string, uint64_t> config;
  std::string format;
  std::vector<std::string> templates;  // of compressed microcode
  std::vector<std::string> microcode;  // hexadecimal, most significant digit first
  std::vector<Run> runs;
};

// Token reader; every error names the wrong token of the file.
class CaseReader {
 public:
  explicit CaseReader(const std::string &path) : file(path) {
    if (!file) throw std::runtime_error("cannot open " + path);
  }

  Case read() {
    Case c;
    expect("orbsoc-pl-case");
    expect("1");
    expect("config");
    for (const char *key : {"fp", "lanes", "dividers", "banks", "clusters", "address_bits"}) c.config[key] = named(key);
    expect("format");
    c.format = token();
    if (c.format == "compressed")
      for (uint64_t n = named("templates"); n > 0; --n) c.templates.push_back(digits(token(), 16));
    for (uint64_t n = named("microcode"); n > 0; --n) c.microcode.push_back(digits(token(), 16));
    std::string word;
    while (file >> word) {
      if (word != "run") throw std::runtime_error("expected 'run', found '" + word + "'");
      c.runs.push_back(run());
    }
    if (c.runs.empty()) throw std::runtime_error("no run in the case");
    return c;
  }

 private:
  Run run() {
    Run r;
    r.name = token();
    r.start = named("start");
    r.words = named("words");
    r.cycles = named("cycles");
    std::string word = token();
    if (word == "gaps") {
      r.seed = named("seed");
      r.level = named("level");
      word = token();
    }
    if (word != "memory") throw std::runtime_error("expected 'memory', found '" + word + "'");
    r.memory = words(number());
    r.expect = words(named("expect"));
    expect("end");
    return r;
  }
  std::vector<std::pair<uint64_t, uint64_t>> words(uint64_t n) {
    std::vector<std::pair<uint64_t, uint64_t>> list;
    for (; n > 0; --n) {
      const uint64_t address = number(16);
      list.emplace_back(address, number(16));
    }
    return list;
  }
  std::string token() {
    std::string word;
    if (!(file >> word)) throw std::runtime_error("the case ends too early");
    return word;
  }
  void expect(const std::string &wanted) {
    const std::string word = token();
    if (word != wanted) throw std::runtime_error("expected '" + wanted + "', found '" + word + "'");
  }
  // The token, if it is digits of that base and nothing else: no sign, no prefix.
  static const std::string &digits(const std::string &word, int base) {
    if (word.find_first_not_of(base == 16 ? "0123456789abcdefABCDEF" : "0123456789") != std::string::npos)
      throw std::runtime_error("'" + word + "' is not a number of base " + std::to_string(base));
    return word;
  }
  uint64_t number(int base = 10) {
    const std::string word = token();
    try {
      return std::stoull(digits(word, base), nullptr, base);
    } catch (const std::out_of_range &) {
      throw std::runtime_error("'" + word + "' has more than 64 bits");
    }
  }
  uint64_t named(const std::string &key) {
    expect(key);
    return number();
  }

  std::ifstream file;
};
