// Reference arithmetic of the units: the host's binary64 and binary32 arithmetic, with canonical NaNs; for
// other formats, binary64 arithmetic rounded once more, which is exact where 2 P + 2 <= 53 (P: significand bits).
#pragma once
#include <cmath>
#include <cstdint>
#include <cstring>

struct Format {
  int exp, man;
  int bits() const { return 1 + exp + man; }
  uint64_t mask() const { return bits() == 64 ? ~0ull : (1ull << bits()) - 1; }
  uint64_t sign() const { return 1ull << (exp + man); }
  uint64_t infinity() const { return ((1ull << exp) - 1) << man; }
  uint64_t nan() const { return infinity() | 1ull << (man - 1); }
  bool is_nan(uint64_t x) const { return (x & ~sign() & mask()) > infinity(); }
};

enum class Op { add, sub, mul, div, sqrt, less };
constexpr const char *OP_NAME[] = {"add", "sub", "mul", "div", "sqrt", "less"};

template <class To, class From> To same_bits(From from) {
  static_assert(sizeof(To) == sizeof(From), "sizes differ");
  To to;
  std::memcpy(&to, &from, sizeof to);
  return to;
}

template <class T> T host(Op op, T a, T b) {
  // The volatiles keep the compiler from folding, fusing or widening.
  volatile T x = a, y = b;
  switch (op) {
    case Op::add: return x + y;
    case Op::sub: return x - y;
    case Op::mul: return x * y;
    case Op::div: return x / y;
    case Op::sqrt: return std::sqrt(static_cast<T>(x));
    default: return x < y ? T(1) : T(0);
  }
}

// A word of a format of at most binary64's exponents as a double, exactly.
inline double widen(Format f, uint64_t x) {
  const uint64_t field = (x >> f.man) & ((1ull << f.exp) - 1), fraction = x & ((1ull << f.man) - 1);
  const double sign = x & f.sign() ? -1.0 : 1.0;
  const int bias = (1 << (f.exp - 1)) - 1;
  if (field == (1ull << f.exp) - 1) return fraction ? std::nan("") : sign * INFINITY;
  if (field == 0) return sign * std::ldexp(double(fraction), 1 - bias - f.man);
  return sign * std::ldexp(double(fraction | 1ull << f.man), int(field) - bias - f.man);
}

// A double rounded to nearest even into the format.
inline uint64_t narrow(Format f, double x) {
  if (std::isnan(x)) return f.nan();
  const uint64_t sign = std::signbit(x) ? f.sign() : 0;
  const double magnitude = std::fabs(x);
  if (std::isinf(x)) return sign | f.infinity();
  if (magnitude == 0) return sign;
  const int bias = (1 << (f.exp - 1)) - 1;
  int power;
  std::frexp(magnitude, &power);  // magnitude in [2^(power-1), 2^power)
  const int place = power - 1 < 1 - bias ? 1 - bias : power - 1;
  // The significand as an integer; nearbyint rounds to nearest even, and a carry runs on into the exponent.
  const uint64_t integer = uint64_t(std::nearbyint(std::ldexp(magnitude, f.man - place)));
  const uint64_t word = (uint64_t(place + bias - 1) << f.man) + integer;
  return sign | (word >= f.infinity() ? f.infinity() : word);
}

inline uint64_t reference(Format f, Op op, uint64_t a, uint64_t b) {
  uint64_t result;
  if (op == Op::less) return host(op, widen(f, a), widen(f, b)) != 0;
  if (f.exp == 11 && f.man == 52)
    result = same_bits<uint64_t>(host(op, same_bits<double>(a), same_bits<double>(b)));
  else if (f.exp == 8 && f.man == 23)
    result = same_bits<uint32_t>(host(op, same_bits<float>(uint32_t(a)), same_bits<float>(uint32_t(b))));
  else
    result = narrow(f, host(op, widen(f, a), widen(f, b)));
  return f.is_nan(result) ? f.nan() : result;
}
