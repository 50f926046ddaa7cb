// A session (session.hpp) with an engine all of whose variables can be written: the bits that radiation turns over.
//   scopes                   S S S …    all of them
//   bits SCOPE NAME          N          of a variable as it lies in memory, decimal; 0 if there is none
//   flip SCOPE NAME BIT      ok         turn a bit over, decimal, element by element from the first
// Logic behind a bit sees it before the next clock edge.
#include "computer.hpp"
#include "session.hpp"
#include "start.hpp"
#include "verilated.h"
#include "verilated_syms.h"

namespace {

class Upsets final : public Session<Computer> {
 protected:
  bool answer_more(const std::string &command, std::istringstream &words) override {
    if (command == "scopes") return scopes();
    if (command != "bits" && command != "flip") return false;
    std::string scope, name;
    uint64_t bit = 0;
    if (!(words >> scope >> name)) return false;
    if (command == "flip" && !(words >> std::dec >> bit)) return false;
    const VerilatedScope *const place = Verilated::threadContextp()->scopeFind(scope.c_str());
    const VerilatedVar *const variable = place ? place->varFind(name.c_str()) : nullptr;
    const uint64_t size = variable ? 8 * uint64_t(variable->totalSize()) : 0;
    if (command == "bits") {
      std::printf("%" PRIu64 "\n", size);
      return true;
    }
    if (bit >= size) return false;
    static_cast<uint8_t *>(variable->datap())[bit / 8] ^= uint8_t(1u << bit % 8);
    std::printf("ok\n");
    return true;
  }

 private:
  static bool scopes() {
    std::printf("scopes");
    for (const auto &[name, place] : *Verilated::threadContextp()->scopeNameMap())
      if (place->varsp()) std::printf(" %s", name);
    std::printf("\n");
    return true;
  }
};

}  // namespace

int main() {
  begin_as_engine(Built::PARITY);
  return std::make_unique<Upsets>()->run(std::cin) ? 0 : 2;
}
