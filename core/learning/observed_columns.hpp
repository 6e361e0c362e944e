// What the columns of a table observe.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace springnet::learning {

// Numbers of columns, from 0.
struct ObservedColumns {
  static constexpr std::size_t none = SIZE_MAX;
  // A quantity with three components; some of them may be absent.
  struct Quantity {
    std::array<std::size_t, 3> values{none, none, none};
    std::array<std::size_t, 3> deviations{none, none, none};  // standard deviations
    [[nodiscard]] bool is_observed() const {
      return std::any_of(values.begin(), values.end(), [](std::size_t column) { return column != none; });
    }
  };

  std::size_t time = none, node = none, other = none, distance = none, weight = none;
  std::size_t deviation = none;  // of distances or surface points
  Quantity position;             // without a node: a surface point
  Quantity velocity, reaction;
  std::vector<std::size_t> numbers;  // all of these: the columns whose cells are numbers

  [[nodiscard]] bool has_surface_points() const noexcept { return node == none; }
};

// Decides by the names of the columns; core/docs/observations.md has the rules. Throws Error(input), "place: what; what
// to do", if they are not clear.
[[nodiscard]] ObservedColumns observed_columns(const std::vector<std::string>& names, std::string_view place);

}  // namespace springnet::learning
