// The minimum of a convex function on a path.
#pragma once

namespace springnet {

struct PathMinimum {
  double share;  // of the path, 0 to 1
  double value;
};
// Golden section search over shares in [0, 1], up to `turns` iterations; stops early at a value below `enough`.
template <class Value>
[[nodiscard]] PathMinimum minimum_on_path(const Value& value, double enough, int turns) {
  constexpr double golden = 0.6180339887498949;
  double low = 0.0, high = 1.0, x1 = 1.0 - golden, x2 = golden, f1 = value(x1), f2 = value(x2);
  for (int i = 0; i < turns && f1 >= enough && f2 >= enough; ++i) {
    if (f1 < f2) {
      high = x2;
      x2 = x1;
      f2 = f1;
      f1 = value(x1 = high - golden * (high - low));
    } else {
      low = x1;
      x1 = x2;
      f1 = f2;
      f2 = value(x2 = low + golden * (high - low));
    }
  }
  if (f1 < enough) return {x1, f1};
  if (f2 < enough) return {x2, f2};
  return f1 < f2 ? PathMinimum{x1, f1} : PathMinimum{x2, f2};
}

}  // namespace springnet
