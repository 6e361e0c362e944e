// An axis of a figure: from values to places, and its ticks.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

namespace springnet::figure {

struct Interval {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] bool empty() const { return !(low <= high); }
};

struct Tick {
  double value;
  bool is_labelled;
};

// Of values from..to, which lie at the places `first` and `last`. A logarithmic one shows a third of a decade around
// its values, which are above 0, and one decade at least.
class Axis {
 public:
  Axis(Interval values, bool is_logarithmic, double first, double last, double wanted_ticks);

  [[nodiscard]] double place(double value) const {
    return first_ + (scaled(value) - low_) / (high_ - low_) * (last_ - first_);
  }
  // The values at both ends.
  [[nodiscard]] double low() const;
  [[nodiscard]] double high() const;
  // Round values within the range.
  [[nodiscard]] std::vector<Tick> ticks() const { return is_logarithmic_ ? ticks_of_decades() : even_ticks(); }

 private:
  [[nodiscard]] double scaled(double value) const;
  [[nodiscard]] std::vector<Tick> even_ticks() const;
  [[nodiscard]] std::vector<Tick> ticks_of_decades() const;

  bool is_logarithmic_;
  double low_, high_;  // as scaled() gives them
  double first_, last_;
  double wanted_ticks_;
};

}  // namespace springnet::figure
