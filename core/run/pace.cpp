#include "run/pace.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <springnet/error.hpp>

namespace springnet {

namespace {

using Clock = std::chrono::steady_clock;

double system_now() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

void system_sleep_until(double time) {
  const double left = time - system_now();
  if (left > 0.0) std::this_thread::sleep_for(std::chrono::duration<double>(left));
}

}  // namespace

RunClock clock_or_system(const RunClock& clock) {
  if (clock.now && clock.sleep_until) return clock;
  return {system_now, system_sleep_until};
}

Pace::Pace(double factor, double begin, RunClock clock) : begin_(begin), clock_(std::move(clock)) {
  if (!(factor > 0.0) || !std::isfinite(factor)) {
    throw Error(ErrorKind::input, fmt::format("the multiple of real time must be above 0, but is {:g}", factor));
  }
  report_.factor = factor;
}

bool Pace::wait(double time, const std::function<bool()>& go_on) {
  constexpr double max_sleep = 0.1;  // s: a user who stops the run does not notice the delay
  double now = clock_.now();
  if (!std::exchange(started_, true)) start_ = now;
  const double end = clock_time(time);
  while (now < end) {
    clock_.sleep_until(std::min(end, now + max_sleep));
    now = clock_.now();
    if (now < end && !go_on()) return false;
  }
  return true;
}

void Pace::count_frame(double time) {
  const double delay = clock_.now() - clock_time(time);
  ++report_.frames;
  if (!(delay > 0.0)) return;
  ++report_.missed;
  report_.greatest_delay = std::max(report_.greatest_delay, delay);
}

}  // namespace springnet
