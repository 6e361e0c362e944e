#include "profile_table.hpp"

#include <vector>

#include <fmt/format.h>

#include "text/counted.hpp"
#include "text_table.hpp"

namespace springnet::tool {

namespace {

constexpr double least_share = 0.001;  // of the whole, of a stage that the table shows

std::string percent(double share) { return fmt::format("{:5.1f} %", 100.0 * share); }

std::string duration(double seconds) {
  if (seconds >= 1.0) return fmt::format("{:.3g} s", seconds);
  return seconds >= 1e-3 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3g} us", 1e6 * seconds);
}

}  // namespace

std::string profile_text(const Profile& profile, std::uint64_t steps) {
  if (!(profile.seconds > 0.0)) return "";
  std::vector<std::vector<std::string>> rows{{"where time goes", "share", "own", "time", "a step", "calls"}};
  std::vector<std::size_t> depths;
  std::size_t hidden = 0;
  bool estimated = false;
  for (const ProfileStage& stage : profile.stages) {
    depths.push_back(stage.parent < 0 ? 0 : depths[static_cast<std::size_t>(stage.parent)] + 1);
    if (stage.seconds < least_share * profile.seconds) {
      ++hidden;
      continue;
    }
    estimated = estimated || stage.estimated;
    rows.push_back({std::string(2 * depths.back(), ' ') + label_of(stage), percent(stage.seconds / profile.seconds),
                    percent(stage.own_seconds / profile.seconds), duration(stage.seconds),
                    steps > 0 ? duration(stage.seconds / static_cast<double>(steps)) : "",
                    fmt::format("{}{}", stage.estimated ? "~" : "", stage.calls)});
  }
  std::string text = align_columns(rows);
  if (hidden > 0) text += fmt::format("  {} of less than 0.1 % left out\n", counted(hidden, "stage"));
  if (estimated) text += "  ~ estimated from some of the calls\n";
  return text;
}

}  // namespace springnet::tool
