// Test operands for floating-point units: seeded, the same on every machine.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "reference.hpp"

class Vectors {
 public:
  Vectors(Format format, Op op, uint64_t seed) : f(format), op(op), state(seed) {
    const uint64_t one = ((1ull << (f.exp - 1)) - 1) << f.man, inf = f.infinity(), low = 1ull << f.man;
    for (uint64_t magnitude : {uint64_t(0), uint64_t(1), uint64_t(2), low / 2, low - 1, low, low + 1, 2 * low, one - 1, one,
                               one + 1, one + low / 2, one + low - 1, one + low, inf - low, inf - 1, inf, inf + 1,
                               inf + low / 2, inf + low - 1}) {
      special.push_back(magnitude);
      special.push_back(magnitude | f.sign());
    }
  }

  // The i-th pair: all pairs of special values first, then the categories in turn; roots mostly of positive numbers.
  std::pair<uint64_t, uint64_t> pair(uint64_t i) {
    const uint64_t n = special.size();
    if (i < n * n) return {special[i / n], special[i % n]};
    auto drawn = draw(i);
    if (op == Op::sqrt && next() % 16 != 0) drawn.first &= ~f.sign();
    return drawn;
  }

 private:
  std::pair<uint64_t, uint64_t> draw(uint64_t i) {
    const uint64_t n = special.size();
    switch (i % 8) {
      case 0: return {word(), word()};
      case 1: return {special[next() % n], word()};
      case 2: return {word(), special[next() % n]};
      case 3: return near_exponents();
      case 4: return subnormals();
      case 5: return edge_of_range();
      case 6: return few_bits();
      default: return halfway();
    }
  }
  uint64_t next() {  // splitmix64
    uint64_t z = state += 0x9e3779b97f4a7c15ull;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ z >> 27) * 0x94d049bb133111ebull;
    return z ^ z >> 31;
  }
  uint64_t word() { return next() & f.mask(); }
  uint64_t sign() { return next() & f.sign(); }
  uint64_t fraction() { return next() & ((1ull << f.man) - 1); }
  int largest() const { return (1 << f.exp) - 2; }
  int bias() const { return (1 << (f.exp - 1)) - 1; }
  int uniform(int low, int high) { return low + int(next() % uint64_t(high - low + 1)); }
  uint64_t make(int exponent, uint64_t man) {
    exponent = exponent < 0 ? 0 : exponent > largest() ? largest() : exponent;
    return sign() | uint64_t(exponent) << f.man | man;
  }
  // A fraction that begins and ends in runs.
  uint64_t runs() {
    const uint64_t all = (1ull << f.man) - 1, cut = all >> uniform(0, f.man - 1);
    switch (next() % 4) {
      case 0: return cut;
      case 1: return all & ~cut;
      case 2: return cut ^ (1ull << uniform(0, f.man - 1));
      default: return (1ull << uniform(0, f.man - 1)) | (1ull << uniform(0, f.man - 1));
    }
  }
  // Cancellation and alignment: exponents within the significand, fractions often nearly equal.
  std::pair<uint64_t, uint64_t> near_exponents() {
    const int e = uniform(0, largest()), gap = next() % 2 ? uniform(-2, 2) : uniform(-f.man - 4, f.man + 4);
    const uint64_t man = fraction();
    const uint64_t other = next() % 2 ? man ^ (fraction() >> uniform(0, f.man)) : fraction();
    return {make(e, man), make(e + gap, other)};
  }
  std::pair<uint64_t, uint64_t> subnormals() {
    const uint64_t tiny = sign() | fraction() >> uniform(0, f.man);
    const uint64_t other = next() % 2 ? make(uniform(0, 3), runs()) : make(uniform(0, largest()), fraction());
    return next() % 2 ? std::make_pair(tiny, other) : std::make_pair(other, tiny);
  }
  // Products and quotients that overflow, underflow, or are just subnormal.
  std::pair<uint64_t, uint64_t> edge_of_range() {
    const int target = next() % 3 == 0 ? uniform(largest() - 3, largest() + 3) : uniform(-f.man - 4, 4);
    const int a = uniform(0, largest());
    const int b = op == Op::div ? a - target + bias() : target - a + bias();
    return {make(a, next() % 2 ? runs() : fraction()), make(b, next() % 2 ? runs() : fraction())};
  }
  std::pair<uint64_t, uint64_t> few_bits() {
    const int a = uniform(0, largest());
    return {make(a, runs()), make(next() % 2 ? a + uniform(-f.man - 4, f.man + 4) : uniform(0, largest()), runs())};
  }
  // Exact ties, and their neighbours in the last place.
  std::pair<uint64_t, uint64_t> halfway() {
    const int e = uniform(f.man + 8, largest());
    const int p = f.man + 1;
    if (op == Op::mul) {  // factors of k and p + 1 - k bits: the product has p or p + 1 bits
      const int k = uniform(2, p - 1), l = p + 1 - k;
      const uint64_t a = odd(k), b = odd(l);
      const int low = next() % 4 == 0 ? uniform(-f.man - 2, 2) : uniform(1, largest());
      const int ea = uniform(1, largest());
      return {make(ea, a), make(low - ea + bias(), b ^ (next() % 4 == 0))};
    }
    if (op == Op::sqrt) {  // squares of p/2-bit numbers, and their neighbours
      const uint64_t root = (1ull << (p / 2 - 1)) | (next() & ((1ull << (p / 2 - 1)) - 1));
      const double square = double(root) * double(root);
      int power;
      const double m = std::frexp(square, &power);
      const uint64_t man = uint64_t(std::ldexp(m, p)) & ((1ull << f.man) - 1);
      return {(make(uniform(1, largest()), man) & ~f.sign()) + uint64_t(uniform(-1, 1)), word()};
    }
    if (op == Op::div) {  // (q b) / b with short b, and neighbours
      const int k = uniform(2, p - 2);
      const uint64_t q = (1ull << (p - k - 1)) | (next() & ((1ull << (p - k - 1)) - 1)), b = odd(k);
      const double product = double(q) * std::ldexp(double(b | 1ull << f.man), -f.man);
      int power;
      const double m = std::frexp(product, &power);
      const uint64_t man = uint64_t(std::ldexp(m, p)) & ((1ull << f.man) - 1);
      return {make(e, man) + uint64_t(uniform(-1, 1)), make(uniform(1, largest()), b)};
    }
    // a + half a unit in the last place of a, give or take
    const uint64_t half = uint64_t(e - f.man - 1) << f.man;
    return {make(e, next() % 2 ? fraction() : runs()), sign() | (half + uint64_t(uniform(-1, 1)))};
  }
  // The fraction of a number with k significant bits, the last of them one.
  uint64_t odd(int k) {
    const int below = k - 1;  // bits after the leading one
    const uint64_t bits = below ? (next() & ((1ull << below) - 1)) | 1 : 0;
    return bits << (f.man - below);
  }

  Format f;
  Op op;
  uint64_t state;
  std::vector<uint64_t> special;
};
