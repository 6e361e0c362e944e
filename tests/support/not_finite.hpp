#pragma once

#include <limits>

namespace springnet::testing {

inline constexpr double inf = std::numeric_limits<double>::infinity();
inline constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

}  // namespace springnet::testing
