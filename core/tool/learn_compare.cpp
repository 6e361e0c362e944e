#include "learn_compare.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <springnet/error.hpp>

#include "text_table.hpp"

namespace springnet::tool {

namespace {

// Returns what it has told, also if it fails.
ToldProgress learn_by(const std::string& method, const Compared& both, std::vector<std::string>& notes) {
  ToldProgress told;
  const auto add_and = [&told](const std::function<bool(const LearnProgress&)>& own) {
    return [&told, own](const LearnProgress& now) {
      told.add(now);
      return own(now);
    };
  };
  try {
    if (method == "online") {
      static_cast<void>(
          learn_online(both.experiment, both.plugins, both.learnables, both.online, add_and(both.on_step)));
    } else {
      LearnOptions options = both.whole;
      options.on_iteration = add_and(both.on_iteration);
      static_cast<void>(learn({both.experiment}, both.plugins, both.learnables, options));
    }
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::plugin) throw;
    notes.push_back(fmt::format("The method '{}', to compare with, ends early: {}", method, error.what()));
  }
  return told;
}

}  // namespace

void ToldProgress::add(const LearnProgress& now) {
  constexpr std::size_t most = 128;
  last_ = now;
  if (++count_ % pitch_ != 0) return;
  kept_.push_back(now);
  if (kept_.size() < most) return;
  for (std::size_t k = 0; k < most / 2; ++k) kept_[k] = std::move(kept_[2 * k + 1]);
  kept_.resize(most / 2);
  pitch_ *= 2;
}

std::vector<LearnProgress> ToldProgress::points() const {
  std::vector<LearnProgress> result = kept_;
  if (count_ % pitch_ != 0) result.push_back(last_);
  return result;
}

void add_courses(LearnedNet& learned, const std::string& method, const ToldProgress& told, Compared both) {
  const std::string other = method == "online" ? "trajectory" : "online";
  both.whole.state.clear();
  both.whole.on_state = nullptr;
  both.whole.starts = 1;
  ToldProgress of_other;
  if (learned.stopped)
    learned.notes.push_back(fmt::format("The method '{}' was not compared, as the search was stopped.", other));
  else
    of_other = learn_by(other, both, learned.notes);
  for (const char* const name : {"trajectory", "online"})
    learned.courses.push_back(course_of(name, (name == method ? told : of_other).points(), both.experiment,
                                        both.plugins, both.learnables, both.whole));
}

std::string comparison_table(const std::vector<LearnCourse>& courses) {
  std::vector<std::vector<std::string>> rows{{"METHOD", "COST AT FIRST", "AT THE END", "WORK, WHOLE MOTIONS"}};
  for (const LearnCourse& each : courses) {
    const LearnCourse::Point& last = each.points.back();
    rows.push_back({each.method, fmt::format("{:.6g}", each.points.front().cost),
                    each.points.size() < 2  ? "not run"
                    : std::isnan(last.cost) ? "fails"
                                            : fmt::format("{:.6g}", last.cost),
                    fmt::format("{:.4g}", last.work)});
  }
  return "\n  Both methods from the same start, by the cost of the whole motion. Work: a motion counts 1, and so does "
         "each\n"
         "  derivative of it by a variable, or backwards.\n\n" +
         align_columns(rows);
}

}  // namespace springnet::tool
