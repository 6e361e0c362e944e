#include "progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include <fmt/format.h>

#include "process.hpp"

namespace springnet::tool {

namespace {

std::string readable_duration(double seconds) {
  if (seconds < 90.0) return fmt::format("{:.0f} s", seconds);
  if (seconds < 5400.0) return fmt::format("{:.0f} min", seconds / 60.0);
  return fmt::format("{:.1f} h", seconds / 3600.0);
}

// "[====    ]  50 %", from the start of the line.
std::string bar(double share) {
  constexpr std::size_t width = 32;
  const auto filled = static_cast<std::size_t>(share * static_cast<double>(width));
  return fmt::format("\r[{}{}] {:3.0f} %", std::string(filled, '='), std::string(width - filled, ' '), 100.0 * share);
}

}  // namespace

Progress::Progress(bool silent) : silent_(silent), terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() { finish(); }

void Progress::load(std::string_view stage, double share) {
  if (silent_) return;
  const auto now = Clock::now();
  const std::chrono::duration<double> since_last = now - last_;
  // A stage of unknown share is shown at once: nothing else is told before it ends.
  const bool begins = stage != stage_ && std::isnan(share);
  stage_ = stage;
  if (terminal_ ? !begins && since_last.count() < 0.1 : since_last.count() < 5.0) return;
  last_ = now;
  const std::string percent = std::isnan(share) ? "" : fmt::format(", {:.0f} %", 100.0 * share);
  if (!terminal_) {
    print(fmt::format("{}{}\n", stage, percent));
    return;
  }
  print(std::isnan(share) ? fmt::format("\r{} …\033[K", stage) : bar(share) + fmt::format("  {}\033[K", stage));
  drawn_ = true;
}

bool Progress::update(double time, double duration) {
  if (!running_) start_ = last_ = Clock::now();
  running_ = true;
  if (!silent_ && time < duration) show(time, duration);  // nothing to show at the end
  return !interrupted();
}

void Progress::show(double time, double duration) {
  const auto now = Clock::now();
  const std::chrono::duration<double> since_last = now - last_, since_start = now - start_;
  if (since_last.count() < (terminal_ ? 0.1 : 5.0)) return;
  last_ = now;
  const double share = std::clamp(time / duration, 0.0, 1.0);
  const std::string left =
      share > 0.0 ? readable_duration(since_start.count() * (1.0 - share) / share) + " left" : "starting";
  if (!terminal_) {
    print(fmt::format("{:.4g} s of {:g} s simulated ({:.0f} %), about {}\n", time, duration, 100.0 * share, left));
    return;
  }
  print(bar(share) + fmt::format("  {:.4g} of {:g} s, {}\033[K", time, duration, left));
  drawn_ = true;
}

bool Progress::search(double share, std::string_view text) {
  if (!silent_ && terminal_) {
    print(bar(std::clamp(share, 0.0, 1.0)) + fmt::format("  {}\033[K", text));
    drawn_ = true;
  } else if (!silent_) {
    print(fmt::format("{}\n", text));
  }
  return !interrupted();
}

void Progress::finish() {
  if (drawn_) print("\r\033[K");
  drawn_ = running_ = false;
}

// A reader that has gone, or a full disk, ends the progress display, not the run.
void Progress::print(const std::string& text) {
  if (std::fputs(text.c_str(), stderr) < 0 || std::fflush(stderr) != 0) silent_ = true;
}

}  // namespace springnet::tool
