// What the checks of a network share.
#pragma once

#include <cmath>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <springnet/error.hpp>
#include <springnet/network.hpp>

namespace springnet::checks {

[[noreturn]] inline void fail(const std::string& message) { throw Error(ErrorKind::input, message); }

inline std::string text(const Vector3& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); }

inline double distance(const Vector3& a, const Vector3& b) {
  return std::hypot(a.x() - b.x(), a.y() - b.y(), a.z() - b.z());
}

inline void check_finite(const Vector3& v, std::string_view what) {
  if (!v.allFinite()) fail(fmt::format("{} must be finite, is {}", what, text(v)));
}

}  // namespace springnet::checks
