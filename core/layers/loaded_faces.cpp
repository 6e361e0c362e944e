#include "layers/loaded_faces.hpp"

#include <algorithm>

#include "layers/node_vectors.hpp"

namespace springnet::layers {
LoadedFaces::LoadedFaces(const Network& network, const std::vector<std::uint32_t>& engine)
    : node_count_(engine.size()) {
  for (const Load& load : network.loads()) {
    first_.push_back(corners_.size());
    follows_.push_back(load.follow && load.pressure != 0.0 ? 1 : 0);
    for (const Face& face : load.faces) {
      corners_.push_back({engine[face[0]], engine[face[1]], engine[face[2]]});
      load_.push_back(static_cast<std::uint32_t>(first_.size() - 1));
    }
  }
  alive_.assign(corners_.size(), 1);
  build();
}

void LoadedFaces::build() {
  const auto follows = [this](std::size_t f) { return alive(f) && follows_[load_[f]] != 0; };
  following_count_ = 0;
  for (std::size_t f = 0; f < count(); ++f) following_count_ += follows(f) ? 1 : 0;
  start_.assign(following_count_ == 0 ? 0 : node_count_ + 1, 0);
  node_faces_.resize(3 * following_count_);
  if (following_count_ == 0) return;
  for (std::size_t f = 0; f < count(); ++f) {
    if (!follows(f)) continue;
    for (const std::uint32_t node : corners_[f]) ++start_[node + 1];
  }
  for (std::size_t k = 0; k + 1 < start_.size(); ++k) start_[k + 1] += start_[k];
  std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
  for (std::size_t f = 0; f < count(); ++f) {
    if (!follows(f)) continue;
    const auto& [a, b, c] = corners_[f];
    node_faces_[next[a]++] = {b, c, load_[f]};
    node_faces_[next[b]++] = {c, a, load_[f]};
    node_faces_[next[c]++] = {a, b, load_[f]};
  }
}

Vector3 LoadedFaces::force(std::uint32_t node, const NodeArrays& nodes, const double* pressure) const noexcept {
  const Vector3 own = position_of(nodes, node);
  Vector3 sum = Vector3::Zero();
  for (const NodeFace& face : faces_at(node))
    sum -= pressure[face.load] / 6.0 * (position_of(nodes, face.next) - own).cross(position_of(nodes, face.last) - own);
  return sum;
}

Block LoadedFaces::stiffness(std::uint32_t node, const NodeArrays& nodes, const double* pressure) const noexcept {
  Vector3 sum = Vector3::Zero();
  for (const NodeFace& face : faces_at(node))
    sum += pressure[face.load] / 6.0 * (position_of(nodes, face.last) - position_of(nodes, face.next));
  return cross_matrix(sum);
}

bool LoadedFaces::is_surrounded(std::uint32_t node) const noexcept {
  const std::span<const NodeFace> faces = faces_at(node);
  const auto is_balanced = [&](std::uint32_t other, std::uint32_t load) {
    std::ptrdiff_t balance = 0;
    for (const NodeFace& face : faces) {
      if (face.load != load) continue;
      balance += face.next == other ? 1 : 0;
      balance -= face.last == other ? 1 : 0;
    }
    return balance == 0;
  };
  return std::all_of(faces.begin(), faces.end(), [&](const NodeFace& face) {
    return is_balanced(face.next, face.load) && is_balanced(face.last, face.load);
  });
}

std::array<Block, 3> LoadedFaces::blocks(std::uint32_t node, const NodeFace& face, const NodeArrays& nodes,
                                         double pressure) noexcept {
  const Vector3 a = position_of(nodes, node), b = position_of(nodes, face.next), c = position_of(nodes, face.last);
  const double weight = pressure / 6.0;
  return {cross_matrix(weight * (c - b)), cross_matrix(weight * (a - c)), cross_matrix(weight * (b - a))};
}

void LoadedFaces::add_neighbours(std::uint32_t node, std::vector<std::uint32_t>& neighbours) const {
  for (const NodeFace& face : faces_at(node)) {
    neighbours.push_back(face.next);
    neighbours.push_back(face.last);
  }
}

std::vector<std::size_t> LoadedFaces::broken_by(
    const std::vector<std::pair<std::uint32_t, std::uint32_t>>& springs) const {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> sides;
  for (const auto& [a, b] : springs) sides.emplace_back(std::minmax(a, b));
  std::sort(sides.begin(), sides.end());
  return crossed_by([&sides](std::uint32_t a, std::uint32_t b) {
    return std::binary_search(sides.begin(), sides.end(), std::pair<std::uint32_t, std::uint32_t>(std::minmax(a, b)));
  });
}

std::vector<std::size_t> LoadedFaces::remove(const std::vector<std::size_t>& faces) {
  std::vector<std::size_t> removed;
  for (const std::size_t f : faces) {
    if (!alive(f)) continue;
    alive_[f] = 0;
    removed.push_back(f);
  }
  if (!removed.empty()) build();
  return removed;
}

}  // namespace springnet::layers
