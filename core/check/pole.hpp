// Finds poles: where a function grows without bound, and is finite again beyond.
#pragma once

#include <functional>
#include <optional>
#include <vector>

namespace springnet::check {

struct Pole {
  double at;
  double below, above;  // values a little before and after it, by a millionth
};

// Values at increasing points, in one call.
using Curve = std::function<std::vector<double>(const std::vector<double>&)>;

// The first pole within a grid of increasing points, at which the curve has these values. Between neighbours it is
// sought where the sign changes and where the size is greatest, and narrowed down from both sides until the numbers
// end: only there does a pole differ from a steep place. Empty where the curve is not finite on both sides: the answer
// is then as it should be.
[[nodiscard]] std::optional<Pole> find_pole(const Curve& curve, const std::vector<double>& grid,
                                            const std::vector<double>& values);

}  // namespace springnet::check
