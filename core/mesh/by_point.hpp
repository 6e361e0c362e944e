// Values grouped by a point of the mesh, in two arrays: a counting sort, in time and memory proportional to the values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <springnet/huge_pages.hpp>

namespace springnet::meshes {

template <class Value>
class ByPoint {
 public:
  // for_each(add) calls add(point, value) for each value; it is called twice, and must do the same both times.
  template <class ForEach>
  ByPoint(std::size_t points, const ForEach& for_each) : start_(points + 1, 0) {
    for_each([this](std::uint32_t point, const Value&) { ++start_[point + 1]; });
    for (std::size_t p = 0; p < points; ++p) start_[p + 1] += start_[p];
    reserve_huge(values_, start_[points]);
    values_.resize(start_[points]);
    for_each([this](std::uint32_t point, const Value& value) { values_[start_[point]++] = value; });
    for (std::size_t p = points; p > 0; --p) start_[p] = start_[p - 1];
    start_[0] = 0;
  }

  [[nodiscard]] std::size_t points() const noexcept { return start_.size() - 1; }
  // Of a point, in the order in which they were added.
  [[nodiscard]] std::span<Value> of(std::size_t point) {
    return std::span(values_).subspan(start_[point], start_[point + 1] - start_[point]);
  }

 private:
  std::vector<std::size_t> start_;  // [point + 1]
  std::vector<Value> values_;
};

}  // namespace springnet::meshes
