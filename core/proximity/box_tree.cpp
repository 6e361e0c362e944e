#include "proximity/box_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <springnet/error.hpp>

namespace springnet::proximity {

namespace {

constexpr int least_exponent = -200;  // of the size of a box, also of a point

}  // namespace

void Box::include(const Box& other) {
  for (std::size_t i = 0; i < 3; ++i) {
    low[i] = std::min(low[i], other.low[i]);
    high[i] = std::max(high[i], other.high[i]);
  }
}

void Box::include(const Vector3& point) {
  for (std::size_t i = 0; i < 3; ++i) {
    const double coordinate = point[static_cast<Eigen::Index>(i)];
    low[i] = std::min(low[i], coordinate);
    high[i] = std::max(high[i], coordinate);
  }
}

Box Box::empty() {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return {{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};
}

void Effort::Share::take() {
  constexpr std::int64_t at_once = 256;
  left_ = at_once - 1;  // one is spent
  if (of_.left_.fetch_sub(at_once, std::memory_order_relaxed) < at_once)
    throw Error(
        ErrorKind::simulation,
        "the search for contacts compares far more primitives than meshes give: their boxes overlap each other. "
        "Positions have collapsed, the margin is large beside the distances of nodes, or there are many primitives "
        "much longer than their distances");
}

void BoxTree::build(std::span<const Box> boxes, std::span<const Group> groups) {
  const auto items = static_cast<std::uint32_t>(boxes.size());
  slots_.resize(items);
  group_of_.assign(groups.begin(), groups.end());
  branches_.clear();
  leaves_.clear();
  std::vector<Vector3> centres(items);
  for (std::uint32_t i = 0; i < items; ++i) {
    slots_[i].item = i;
    slots_[i].group = groups[i];
    for (std::size_t k = 0; k < 3; ++k)  // halves first: the sum of two great coordinates may overflow
      centres[i][static_cast<Eigen::Index>(k)] = 0.5 * boxes[i].low[k] + 0.5 * boxes[i].high[k];
  }
  std::stable_sort(slots_.begin(), slots_.end(), [](const Slot& a, const Slot& b) { return a.group < b.group; });
  if (items > 0) split(0, items, centres);
  refit(boxes);
  size_when_built_ = size_;
}

// Where to divide slots, which it puts in order for that.
std::uint32_t BoxTree::middle_of(std::uint32_t begin, std::uint32_t end, std::span<const Vector3> centres) {
  const std::uint32_t middle = begin + (end - begin) / 2;
  if (slots_[begin].group != slots_[end - 1].group) {
    // Between two groups: at the boundary that is nearest to the middle.
    std::uint32_t below = middle, above = middle;
    while (below > begin && slots_[below - 1].group == slots_[below].group) --below;
    while (above < end && slots_[above - 1].group == slots_[above].group) ++above;
    if (below == begin) return above;
    if (above == end) return below;
    return middle - below <= above - middle ? below : above;
  }
  Box box = Box::empty();
  for (std::uint32_t s = begin; s < end; ++s) box.include(centres[slots_[s].item]);
  Eigen::Index axis = 0;
  for (const Eigen::Index other : {1, 2}) {
    const auto a = static_cast<std::size_t>(axis), b = static_cast<std::size_t>(other);
    if (box.high[b] - box.low[b] > box.high[a] - box.low[a]) axis = other;
  }
  std::nth_element(slots_.begin() + begin, slots_.begin() + middle, slots_.begin() + end,
                   [&](const Slot& a, const Slot& b) { return centres[a.item][axis] < centres[b.item][axis]; });
  return middle;
}

void BoxTree::split(std::uint32_t begin, std::uint32_t end, std::span<const Vector3> centres) {
  const auto place = static_cast<std::uint32_t>(branches_.size());
  branches_.push_back({Box::empty(), 0, 0, none});
  if (end - begin <= leaf_items) {
    branches_[place].leaf = static_cast<std::uint32_t>(leaves_.size());
    Leaf& leaf = leaves_.emplace_back();
    leaf.count = end - begin;
    leaf.branch = place;
    for (std::uint32_t s = begin; s < end; ++s) {
      leaf.item[s - begin] = slots_[s].item;
      branches_[place].groups |= std::uint32_t{1} << (slots_[s].group % 32);
    }
  } else {
    const std::uint32_t middle = middle_of(begin, end, centres);
    split(begin, middle, centres);
    const auto second = static_cast<std::uint32_t>(branches_.size());
    split(middle, end, centres);
    branches_[place].groups = branches_[place + 1].groups | branches_[second].groups;
  }
  branches_[place].after = static_cast<std::uint32_t>(branches_.size());
}

void BoxTree::refit(std::span<const Box> boxes) {
  size_ = 0;
  for (std::size_t b = branches_.size(); b-- > 0;) {
    Branch& branch = branches_[b];
    branch.box = Box::empty();
    if (branch.is_leaf()) {
      Leaf& leaf = leaves_[branch.leaf];
      for (std::uint32_t i = 0; i < leaf_items; ++i) {
        const Box box = i < leaf.count ? boxes[leaf.item[i]] : Box::empty();
        for (std::size_t k = 0; k < 3; ++k) {
          leaf.low[k][i] = box.low[k];
          leaf.high[k][i] = box.high[k];
        }
        branch.box.include(box);
      }
    } else {
      branch.box.include(branches_[b + 1].box);
      branch.box.include(branches_[branches_[b + 1].after].box);
    }
    size_ += std::max(std::ilogb(branch.box.size()), least_exponent);
  }
}

}  // namespace springnet::proximity
