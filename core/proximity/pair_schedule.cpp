#include "proximity/pair_schedule.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "proximity/distance.hpp"

namespace springnet::proximity {

namespace {

constexpr std::int64_t slot_count = 256;
constexpr double slots_in_skin = 128.0;

}  // namespace

void PairSchedule::reset(const PairLists& pairs, double skin) {
  width_ = skin / slots_in_skin;
  far_ = 0.25 * skin;
  path_ = 0.0;
  first_ = 0;
  due_.assign(pairs.size(), 0.0);
  slots_.resize(static_cast<std::size_t>(slot_count));
  for (std::vector<std::uint32_t>& each : slots_) each.clear();
  slots_[0].resize(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) slots_[0][i] = static_cast<std::uint32_t>(i);
}

std::int64_t PairSchedule::slot_number(double due) const {
  constexpr double most = 1e15;
  const double number = due / width_;
  return number < most ? static_cast<std::int64_t>(std::floor(std::max(number, 0.0))) : static_cast<std::int64_t>(most);
}

std::vector<std::uint32_t>& PairSchedule::slot(std::int64_t number) {
  return slots_[static_cast<std::size_t>(number % slot_count)];
}

void PairSchedule::put(std::uint32_t item) {
  slot(std::clamp(slot_number(due_[item]), first_, first_ + slot_count - 1)).push_back(item);
}

void PairSchedule::find_close(const Primitives& primitives, const PairLists& pairs, const Positions& x, double moved,
                              double reach, PairLists& close) {
  reach = std::max(0.0, reach);
  path_ += moved;
  const std::array<std::size_t, 3> begins{0, pairs.of_kind[0].size(),
                                          pairs.of_kind[0].size() + pairs.of_kind[1].size()};
  seen_.clear();
  close_.clear();
  const double limit = path_ + reach;
  const std::int64_t last = std::min(slot_number(limit), first_ + slot_count - 1);
  for (std::int64_t number = first_; number <= last; ++number) {
    taken_.clear();
    std::swap(taken_, slot(number));
    for (const std::uint32_t item : taken_) {
      seen_.push_back(item);
      if (due_[item] > limit) continue;
      const std::size_t k = item < begins[1] ? 0 : item < begins[2] ? 1 : 2;
      const PairKind kind = pair_kinds[k];
      const Pair pair = pairs.of_kind[k][item - begins[k]];
      const std::array<Vector3, 4> corners = primitives.corners(kind, pair, x);
      const double thickness = primitives.thickness(kind, pair);
      const bool is_far = reach < far_ && is_surely_beyond(kind, corners, thickness + far_);
      const double gap = is_far ? far_ : separation(kind, corners).distance - thickness;
      due_[item] = path_ + gap;
      if (!(gap > reach)) close_.push_back(item);
    }
  }
  first_ = slot_number(path_);
  for (const std::uint32_t item : seen_) put(item);
  std::sort(close_.begin(), close_.end());
  for (std::vector<Pair>& each : close.of_kind) each.clear();
  for (const std::uint32_t item : close_) {
    const std::size_t k = item < begins[1] ? 0 : item < begins[2] ? 1 : 2;
    close.of_kind[k].push_back(pairs.of_kind[k][item - begins[k]]);
  }
}

}  // namespace springnet::proximity
