#include <algorithm>
#include <cmath>

#include "fuzzy/functions.hpp"

namespace springnet::fuzzy {
namespace {

OfTwo smaller(double a, double b) { return a <= b ? OfTwo{a, 1.0, 0.0} : OfTwo{b, 0.0, 1.0}; }
OfTwo larger(double a, double b) { return a >= b ? OfTwo{a, 1.0, 0.0} : OfTwo{b, 0.0, 1.0}; }

// n / d with the derivatives of both.
OfTwo quotient(const OfTwo& n, const OfTwo& d) {
  const double value = n.value / d.value;
  return {value, (n.by_first - value * d.by_first) / d.value, (n.by_second - value * d.by_second) / d.value};
}

}  // namespace

OfTwo combine(TNorm norm, double a, double b) {
  const OfTwo product{a * b, b, a};
  switch (norm) {
    case TNorm::minimum:
      return smaller(a, b);
    case TNorm::product:
      return product;
    case TNorm::bounded:
      return a + b > 1.0 ? OfTwo{a + b - 1.0, 1.0, 1.0} : OfTwo{};
    case TNorm::drastic:
      return std::max(a, b) == 1.0 ? smaller(a, b) : OfTwo{};
    case TNorm::einstein:
      return quotient(product, {2.0 - (a + b - a * b), b - 1.0, a - 1.0});
    case TNorm::hamacher:
      return a + b == 0.0 ? OfTwo{} : quotient(product, {a + b - a * b, 1.0 - b, 1.0 - a});
    case TNorm::nilpotent:
      return a + b > 1.0 ? smaller(a, b) : OfTwo{};
  }
  return {};
}

OfTwo combine(SNorm norm, double a, double b) {
  switch (norm) {
    case SNorm::maximum:
      return larger(a, b);
    case SNorm::sum:
      return {a + b - a * b, 1.0 - b, 1.0 - a};
    case SNorm::bounded:
      return a + b < 1.0 ? OfTwo{a + b, 1.0, 1.0} : OfTwo{1.0, 0.0, 0.0};
    case SNorm::normalised:  // as the quotient says, 1 from a + b = 1 on
      return a + b < 1.0 ? OfTwo{a + b, 1.0, 1.0} : OfTwo{1.0, 0.0, 0.0};
    case SNorm::drastic:
      return std::min(a, b) == 0.0 ? larger(a, b) : OfTwo{1.0, 0.0, 0.0};
    case SNorm::einstein:
      return quotient({a + b, 1.0, 1.0}, {1.0 + a * b, b, a});
    case SNorm::hamacher: {
      // As 1 - hamacher product of 1 - a and 1 - b: (a + b - 2 a b) / (1 - a b) loses all digits near a = b = 1.
      const OfTwo complement = combine(TNorm::hamacher, 1.0 - a, 1.0 - b);
      return {1.0 - complement.value, complement.by_first, complement.by_second};
    }
    case SNorm::nilpotent:
      return a + b < 1.0 ? larger(a, b) : OfTwo{1.0, 0.0, 0.0};
  }
  return {};
}

OfOne hedged(Hedge hedge, double m) {
  switch (hedge) {
    case Hedge::any:
      return {1.0, 0.0};
    case Hedge::negation:
      return {1.0 - m, -1.0};
    case Hedge::very:
      return {m * m, 2.0 * m};
    case Hedge::somewhat: {
      const double root = std::sqrt(m);
      return {root, m > 0.0 ? 0.5 / root : 0.0};
    }
    case Hedge::extremely:
      return m <= 0.5 ? OfOne{2.0 * m * m, 4.0 * m} : OfOne{1.0 - 2.0 * (1.0 - m) * (1.0 - m), 4.0 * (1.0 - m)};
    case Hedge::seldom: {
      const double root = std::sqrt(0.5 * (m <= 0.5 ? m : 1.0 - m));
      return {m <= 0.5 ? root : 1.0 - root, root > 0.0 ? 0.25 / root : 0.0};
    }
  }
  return {};
}

OfOne hedged(std::span<const Hedge> hedges, double m) {
  OfOne result{std::clamp(m, 0.0, 1.0), 1.0};  // a norm may leave that by its rounding
  for (auto hedge = hedges.rbegin(); hedge != hedges.rend(); ++hedge) {
    const OfOne next = hedged(*hedge, result.value);
    result = {next.value, next.derivative * result.derivative};
  }
  return result;
}

}  // namespace springnet::fuzzy
