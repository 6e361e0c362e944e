// Input signals of a network.
#include <algorithm>
#include <cmath>

#include <springnet/printable.hpp>

#include "network/checks.hpp"

namespace springnet {
namespace {

using namespace checks;

void check_signal(const Signal& signal, const std::string& what) {
  const bool table = !signal.times.empty() || !signal.values.empty();
  if (table && signal.frequency != 0.0) fail(fmt::format("{} has a table and a frequency: give one", what));
  using enum Signal::Interpolation;
  if (signal.interpolation != hold && signal.interpolation != linear && signal.interpolation != cubic)
    fail(fmt::format("{} has the unknown interpolation {}: give hold, linear or cubic", what,
                     static_cast<int>(signal.interpolation)));
  if (table) {
    check_times(signal.times, signal.values.size(), "values", what);
    for (std::size_t k = 0; k < signal.values.size(); ++k) {
      if (!std::isfinite(signal.values[k]))
        fail(fmt::format("{}: a value must be finite, entry {} of its table has {}", what, k, signal.values[k]));
      if (k > 0 && !std::isfinite(signal.times[k] - signal.times[k - 1]))
        fail(fmt::format("{}: entries {} and {} of its table are too far apart: their difference is not finite", what,
                         k - 1, k));
    }
    for (std::size_t k = 1; k < signal.values.size() && signal.interpolation != hold; ++k) {
      const double step = signal.values[k] - signal.values[k - 1];
      // Three times as much stands in Hermite's cubic.
      if (!std::isfinite(3.0 * step) || !std::isfinite(3.0 * (step / (signal.times[k] - signal.times[k - 1])))) {
        fail(fmt::format(
            "{}: from entry {} of its table to the next it changes too fast, from {} to {} in {}; give "
            "smaller values, or times that are farther apart",
            what, k - 1, signal.values[k - 1], signal.values[k], seconds(signal.times[k] - signal.times[k - 1])));
      }
    }
  }
  constexpr double fastest = 1e300;  // Hz: its angular frequency is finite
  if (!(signal.frequency <= fastest && signal.frequency >= 0.0))
    fail(fmt::format("{}: its frequency must be from 0 to {} Hz, is {}", what, fastest, signal.frequency));
  for (const double value : {signal.mean, signal.amplitude, signal.phase}) {
    if (!std::isfinite(value))
      fail(fmt::format("{}: mean, amplitude and phase must be finite, one is {}", what, value));
  }
}

template <class Index>
void sort_members(std::vector<Index>& members, std::size_t count, const char* kind, const std::string& what) {
  std::sort(members.begin(), members.end());
  members.erase(std::unique(members.begin(), members.end()), members.end());
  if (!members.empty() && members.back() >= count)
    fail(fmt::format("{} is for {} {}: there are only {} {}s", what, kind, members.back(), count, kind));
}

}  // namespace

InputIndex Network::add_input(const Input& input) {
  if (input.input.empty()) fail("an input signal does not say which input of laws it is for: give `input`");
  const std::string what = input.name.empty() ? fmt::format("the signal for the input '{}'", printable(input.input))
                                              : fmt::format("the input signal '{}'", printable(input.name));
  if (!input.name.empty() && input_names_.contains(input.name))
    fail(fmt::format("two input signals have the name '{}': rename one", printable(input.name)));
  check_signal(input.signal, what);
  Input added = input;
  sort_members(added.springs, springs_.size(), "spring", what);
  sort_members(added.elements, elements_.size(), "element", what);
  if (added.springs.empty() && added.elements.empty())
    fail(fmt::format("{} is for no spring and no element: list some", what));
  if (!added.name.empty()) input_names_.insert(added.name);
  inputs_.push_back(std::move(added));
  return static_cast<InputIndex>(inputs_.size() - 1);
}

}  // namespace springnet
