#include "check/sharing.hpp"

#include <algorithm>

namespace springnet::check {
namespace {

// Columns that may be shared, in the order of the bits.
std::vector<std::size_t> columns_of(const LawCall& call) {
  const sdk::JacobianLayout& l = call.layout();
  std::vector<std::size_t> columns;
  if (!call.several()) columns.push_back(l.reference());
  for (std::size_t i = 0; i < l.parameters; ++i) columns.push_back(l.parameter(i));
  for (std::size_t i = 0; i < l.inputs; ++i) columns.push_back(l.input(i));
  return columns;
}

}  // namespace

std::vector<std::uint64_t> mixed_sharings(const LawCall& call) {
  constexpr std::uint64_t every_second = 0x5555555555555555;
  const std::size_t count = columns_of(call).size();
  std::vector<std::uint64_t> result;
  if (count > 1) result = {every_second << 1, every_second};
  for (const std::size_t column : columns_of(call)) {
    const std::uint64_t one = call.sharing_bit(column);
    for (const std::uint64_t shared : {one, ~one})
      if (count > 2 && std::find(result.begin(), result.end(), shared) == result.end()) result.push_back(shared);
  }
  return result;
}

std::vector<Point> with_shared(const LawCall& call, std::vector<Point> points, std::uint64_t shared) {
  const sdk::JacobianLayout& l = call.layout();
  const std::uint32_t invariant = call.law().invariant;
  const bool keeps_stretch = invariant != SPRINGNET_RELATIVE_SPEED && invariant != SPRINGNET_ANGLE;
  for (const std::size_t column : columns_of(call)) {
    if ((shared & call.sharing_bit(column)) == 0) continue;
    const double value = points.front()[column];
    for (Point& point : points) {
      if (column == l.reference() && keeps_stretch && point[column] > 0.0)
        for (const std::size_t scaled : {l.value(), l.rate(), l.start_value(), l.start_rate()})
          point[scaled] *= value / point[column];
      point[column] = value;
      if (column >= l.input(0))
        point[l.start_input(column - l.input(0))] = points.front()[l.start_input(column - l.input(0))];
    }
  }
  return points;
}

std::string told_sharing(const LawCall& call, std::uint64_t shared) {
  if (shared == share_nothing) return {};
  if (shared == share_all) return "strides of 0";
  std::string names;
  for (const std::size_t column : columns_of(call))
    if ((shared & call.sharing_bit(column)) != 0) names += (names.empty() ? "" : ", ") + call.column_name(column);
  return "strides of 0 of " + names;
}

}  // namespace springnet::check
