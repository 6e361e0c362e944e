#include "network/kinks.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace springnet {
namespace {

template <class Value, class Size>
Kinks kinks(Motion::Interpolation interpolation, const std::vector<double>& times, const std::vector<Value>& values,
            const Size& size) {
  if (interpolation != Motion::Interpolation::linear) return {};
  const auto velocity = [&](std::size_t k) { return Value((values[k + 1] - values[k]) / (times[k + 1] - times[k])); };
  double fastest = 0.0;
  for (std::size_t k = 0; k + 1 < values.size(); ++k) fastest = std::max(fastest, size(velocity(k)));
  Kinks result{values.size(), 0, 0.0};
  for (std::size_t k = 0; k + 2 < values.size(); ++k) {
    const double jump = size(Value(velocity(k + 1) - velocity(k)));
    if (jump > 1e-6 * fastest) ++result.count;  // rounding of the table's entries is no kink
    result.greatest = std::max(result.greatest, jump);
  }
  return result;
}

}  // namespace

Kinks kinks_of(const Motion& motion) {
  return kinks(motion.interpolation, motion.times, motion.displacements, [](const Vector3& v) { return v.norm(); });
}

Kinks kinks_of(const Turn& turn) {
  return kinks(turn.interpolation, turn.times, turn.angles, [](double rate) { return std::abs(rate); });
}

}  // namespace springnet
