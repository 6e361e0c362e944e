// leaks: memory that a law takes and does not give back.
#include <fmt/format.h>

#include "check/child.hpp"
#include "check/heap.hpp"
#include "check/law_checks.hpp"

namespace springnet::check {

Outcome check_leaks(const LawSubject& subject) {
  if (!heap_in_use()) return {Result::passed, "not known on this system"};
  ReadyLaw ready(subject);
  const LawCall& call = ready.call();
  std::vector<Point> points = ready.points().several(3);
  for (Point& point : points) point[call.layout().time()] = points[0][call.layout().time()];
  constexpr int calls = 100;
  const auto outcome = [](const char* what, double bytes) {
    return Outcome{Result::failed,
                   fmt::format("{} keeps {:.0f} bytes: give back what it takes, or use the stack", what, bytes)};
  };
  now_doing("evaluating again and again");
  if (const double kept = kept_by_each([&] { static_cast<void>(call(points, {.derivatives = true})); }, calls);
      kept > 0.0)
    return outcome("each evaluation", kept);
  if (call.layout().states > 0) {
    now_doing("updating again and again");
    const How how{.derivatives = true, .time_step = 1e-3};
    if (const double kept = kept_by_each([&] { static_cast<void>(call(points, how)); }, calls); kept > 0.0)
      return outcome("each update", kept);
    const auto start = [&] { static_cast<void>(call.start_states(points[0], Memory::Layout::roomy)); };
    if (const double kept = kept_by_each(start, calls); kept > 0.0) return outcome("each start", kept);
  }
  if (call.law().table_count > 0) {
    now_doing("preparing its tables again and again");
    if (const double kept = kept_by_each([&] { const ReadyLaw another(subject); }, calls); kept > 0.0)
      return outcome("each preparation and release", kept);
  }
  return {};
}

}  // namespace springnet::check
