#include "constraints/same_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

namespace springnet {
namespace {

constexpr double rounding = 1e-12;  // of weights and directions, which are of order 1

// Nodes with a weight, in ascending order; first and second may be either way round.
struct Side {
  std::array<std::uint32_t, 4> nodes{UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX};
  std::array<double, 4> weights{};
  Vector3 normal = Vector3::Zero();
  double sign = 1.0;
};

Side side_of(const PairRow& row) {
  std::map<std::uint32_t, double> ends;
  for (std::size_t i = 0; i < static_cast<std::size_t>(row.count); ++i)
    if (std::abs(row.weights[i]) > rounding) ends[row.nodes[i]] = row.weights[i];
  Side side;
  if (!ends.empty() && ends.begin()->second < 0.0) side.sign = -1.0;
  std::size_t i = 0;
  for (const auto& [node, weight] : ends) {
    side.nodes[i] = node;
    side.weights[i++] = side.sign * weight;
  }
  side.normal = side.sign * row.normal;
  return side;
}

bool is_same(const Side& a, const Side& b) {
  for (std::size_t i = 0; i < a.weights.size(); ++i)
    if (std::abs(a.weights[i] - b.weights[i]) > rounding) return false;
  return (a.normal - b.normal).lpNorm<Eigen::Infinity>() <= rounding;
}

}  // namespace

std::size_t join_same(std::vector<PairRow>& rows) {
  struct Known {
    Side side;
    std::size_t row;
  };
  std::map<std::array<std::uint32_t, 4>, std::vector<Known>> known;
  std::size_t joined = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    PairRow& row = rows[r];
    if (row.is_blocked || row.is_done || row.count < 2) continue;
    const Side side = side_of(row);
    std::vector<Known>& there = known[side.nodes];
    const auto same = std::find_if(there.begin(), there.end(), [&](const Known& each) {
      const PairRow& other = rows[each.row];
      return is_same(each.side, side) && other.friction == row.friction && other.by_rate == row.by_rate &&
             other.lever == row.lever;
    });
    if (same == there.end()) {
      there.push_back({side, r});
      continue;
    }
    rows[same->row].impulse += side.sign * same->side.sign * row.impulse;
    row.impulse.setZero();
    row.is_blocked = true;
    ++joined;
  }
  return joined;
}

}  // namespace springnet
