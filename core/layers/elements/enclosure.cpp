#include "layers/elements/enclosure.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <unordered_map>

#include "layers/node_vectors.hpp"

namespace springnet::layers {
namespace {

std::uint64_t directed(std::uint32_t from, std::uint32_t to) { return std::uint64_t{from} << 32 | to; }

}  // namespace

Enclosure::Enclosure(const std::vector<std::uint32_t>& triangles) : nodes_(triangles) {
  std::sort(nodes_.begin(), nodes_.end());
  nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
  std::unordered_map<std::uint64_t, std::uint32_t> left;
  left.reserve(triangles.size());
  start_.assign(nodes_.size() + 1, 0);
  const auto place_of = [this](std::uint32_t node) {
    return static_cast<std::size_t>(std::lower_bound(nodes_.begin(), nodes_.end(), node) - nodes_.begin());
  };
  const auto for_each_side = [&triangles](auto&& what) {
    for (std::size_t t = 0; t < triangles.size(); t += 3)
      for (std::size_t k = 0; k < 3; ++k)
        what(triangles[t + k], triangles[t + (k + 1) % 3], triangles[t + (k + 2) % 3]);
  };
  for_each_side([&](std::uint32_t from, std::uint32_t to, std::uint32_t apex) {
    left.emplace(directed(from, to), apex);
    ++start_[place_of(from) + 1];
  });
  for (std::size_t k = 0; k + 1 < start_.size(); ++k) start_[k + 1] += start_[k];
  spokes_.resize(start_.back());
  std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
  for_each_side([&](std::uint32_t from, std::uint32_t to, std::uint32_t apex) {
    spokes_[next[place_of(from)]++] = {to, apex, left.at(directed(to, from))};
  });
}

bool Enclosure::has_side(std::uint32_t first, std::uint32_t second) const noexcept {
  const auto at = std::lower_bound(nodes_.begin(), nodes_.end(), first);
  if (at == nodes_.end() || *at != first) return false;
  const std::span<const Spoke> around = spokes(static_cast<std::size_t>(at - nodes_.begin()));
  return std::any_of(around.begin(), around.end(), [second](const Spoke& s) { return s.other == second; });
}

// 1/6 sum (b - o) x (c - o) over the ring of neighbours, with one of them as the origin o.
Vector3 Enclosure::gradient(std::size_t place, const NodeArrays& nodes) const noexcept {
  const std::span<const Spoke> around = spokes(place);
  const Vector3 origin = position_of(nodes, around[0].other);
  Vector3 sum = Vector3::Zero();
  for (const Spoke& s : around)
    sum += (position_of(nodes, s.other) - origin).cross(position_of(nodes, s.left) - origin);
  return sum / 6.0;
}

Vector3 Enclosure::rate_gradient(std::size_t place, const NodeArrays& nodes) const noexcept {
  const std::span<const Spoke> around = spokes(place);
  const Vector3 origin = position_of(nodes, around[0].other), moving = velocity_of(nodes, around[0].other);
  Vector3 sum = Vector3::Zero();
  for (const Spoke& s : around) {
    sum += (velocity_of(nodes, s.other) - moving).cross(position_of(nodes, s.left) - origin);
    sum += (position_of(nodes, s.other) - origin).cross(velocity_of(nodes, s.left) - moving);
  }
  return sum / 6.0;
}

// V has the terms a . (b x c) / 6 + b . (a x d) / 6; their derivative with respect to a and b is [d - c]x / 6.
Vector3 Enclosure::across(const Spoke& spoke, const NodeArrays& nodes) noexcept {
  return (position_of(nodes, spoke.right) - position_of(nodes, spoke.left)) / 6.0;
}

Enclosure::Values Enclosure::partial_values(std::size_t begin, std::size_t end, const NodeArrays& nodes,
                                            Vector3* gradients) const noexcept {
  const Vector3 origin = position_of(nodes, nodes_[0]), moving = velocity_of(nodes, nodes_[0]);
  Values sum;
  for (std::size_t place = begin; place < end; ++place) {
    const Vector3 g = gradient(place, nodes);
    if (gradients != nullptr) gradients[place] = g;
    sum.volume += g.dot(position_of(nodes, nodes_[place]) - origin);
    sum.rate += g.dot(velocity_of(nodes, nodes_[place]) - moving);
  }
  sum.volume /= 3.0;
  return sum;
}

Enclosure::Values Enclosure::values(const NodeArrays& nodes) const noexcept {
  Values sum;
  for (std::size_t begin = 0; begin < size(); begin += enclosure_chunk) {
    const Values part = partial_values(begin, std::min(size(), begin + enclosure_chunk), nodes, nullptr);
    sum.volume += part.volume;
    sum.rate += part.rate;
  }
  return sum;
}

}  // namespace springnet::layers
