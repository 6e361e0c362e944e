#include "wavefront.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace springnet::recurrent {
namespace {

constexpr std::uint32_t none = 0xffffffffu;
// Orders to find again, and their nodes; the newest is kept anyway.
constexpr std::size_t max_found = 64, max_found_nodes = std::size_t{1} << 16;

// Whether node a precedes node b as the start of the wave.
bool precedes(const springnet_network& network, const springnet_const_vectors& force, std::uint32_t a,
              std::uint32_t b) {
  const bool a_free = network.fixed[a] == 0 && network.held[a] == 0;
  const bool b_free = network.fixed[b] == 0 && network.held[b] == 0;
  if (a_free != b_free) return a_free;
  const auto square = [&](std::uint32_t k) {
    const double sum = force.x[k] * force.x[k] + force.y[k] * force.y[k] + force.z[k] * force.z[k];
    return std::isnan(sum) ? std::numeric_limits<double>::infinity() : sum;  // keeps the order total
  };
  const double a2 = square(a), b2 = square(b);
  if (a2 != b2) return a2 > b2;
  return network.user_number[a] < network.user_number[b];
}

}  // namespace

void Wavefront::attach(const springnet_network& network) {
  const std::uint32_t count = network.node_count;
  if (network.connection_revision == revision_) return;
  revision_ = network.connection_revision;
  part_.assign(count, none);
  order_.clear();
  order_.reserve(count);
  reached_.assign(count, 0);
  std::uint32_t parts = 0;
  for (std::uint32_t node = 0; node < count; ++node) {
    if (part_[node] != none) continue;
    const std::size_t begin = order_.size();
    spread(network, node);
    for (std::size_t i = begin; i < order_.size(); ++i) part_[order_[i]] = parts;
    ++parts;
  }
  starts_.assign(parts, none);
  found_count_ = 0;
  found_.resize(std::clamp<std::size_t>(max_found_nodes / std::max(count, 1u), 1, max_found));
  for (Found& found : found_) {
    found.starts.reserve(parts);
    found.order.reserve(count);
  }
}

std::uint32_t Wavefront::strongest(const springnet_network& network, const springnet_const_vectors& force) const {
  std::uint32_t best = 0;
  for (std::uint32_t node = 1; node < network.node_count; ++node) {
    if (precedes(network, force, node, best)) best = node;
  }
  return best;
}

std::span<const std::uint32_t> Wavefront::order(const springnet_network& network, std::uint32_t start,
                                                const springnet_const_vectors& force) {
  choose_starts(network, start, force);
  const auto end = found_.begin() + static_cast<std::ptrdiff_t>(found_count_);
  const auto found = std::find_if(found_.begin(), end, [&](const Found& f) { return f.starts == starts_; });
  if (found != end) {
    std::rotate(found_.begin(), found, found + 1);
    return found_.front().order;
  }
  std::fill(reached_.begin(), reached_.end(), std::uint8_t{0});
  order_.clear();
  for (const std::uint32_t node : starts_) spread(network, node);
  // In place of the one used least recently, if there are too many.
  found_count_ = std::min(found_count_ + 1, found_.size());
  const auto last = found_.begin() + static_cast<std::ptrdiff_t>(found_count_ - 1);
  std::rotate(found_.begin(), last, last + 1);
  found_.front().starts.assign(starts_.begin(), starts_.end());
  found_.front().order.assign(order_.begin(), order_.end());
  return found_.front().order;
}

void Wavefront::choose_starts(const springnet_network& network, std::uint32_t start,
                              const springnet_const_vectors& force) {
  if (starts_.size() == 1) {
    starts_[0] = start;
    return;
  }
  std::fill(starts_.begin(), starts_.end(), none);
  for (std::uint32_t node = 0; node < network.node_count; ++node) {
    std::uint32_t& best = starts_[part_[node]];
    if (best == none || precedes(network, force, node, best)) best = node;
  }
  starts_[part_[start]] = start;
  std::sort(starts_.begin(), starts_.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (a == start || b == start) return a == start && b != start;
    return precedes(network, force, a, b);
  });
}

void Wavefront::spread(const springnet_network& network, std::uint32_t start) {
  std::size_t next = order_.size();
  order_.push_back(start);
  reached_[start] = 1;
  for (; next < order_.size(); ++next) {
    const std::uint32_t node = order_[next];
    for (std::uint32_t i = network.neighbour_start[node]; i < network.neighbour_start[node + 1]; ++i) {
      const std::uint32_t neighbour = network.neighbours[i];
      if (reached_[neighbour] != 0) continue;
      reached_[neighbour] = 1;
      order_.push_back(neighbour);
    }
  }
}

}  // namespace springnet::recurrent
