#include "proximity/shared_features.hpp"

#include <algorithm>

namespace springnet::proximity {
namespace {

template <class Primitive>
bool has_all(const Primitive& primitive, const std::array<NodeIndex, 3>& nodes, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (std::find(primitive.nodes.begin(), primitive.nodes.end(), nodes[i]) == primitive.nodes.end()) return false;
  return true;
}

}  // namespace

template <class List>
SharedFeatures::OfNodes SharedFeatures::of_nodes(const List& list) const {
  OfNodes result;
  result.begin.assign(balls_.size() + 1, 0);
  for (const auto& primitive : list)
    for (const NodeIndex node : primitive.nodes) ++result.begin[node + 1];
  for (std::size_t k = 0; k < balls_.size(); ++k) result.begin[k + 1] += result.begin[k];
  result.places.resize(result.begin.back());
  std::vector<std::uint32_t> next(result.begin.begin(), result.begin.end() - 1);
  for (std::uint32_t i = 0; i < list.size(); ++i)
    for (const NodeIndex node : list[i].nodes) result.places[next[node]++] = i;
  return result;
}

SharedFeatures::SharedFeatures(const Primitives& primitives) : primitives_(primitives) {
  balls_.assign(primitives.nodes().empty() ? 0 : primitives.nodes().back() + std::size_t{1}, none);
  for (std::uint32_t i = 0; i < primitives.balls().size(); ++i) balls_[primitives.balls()[i].node] = i;
  edges_ = of_nodes(primitives.edges());
  triangles_ = of_nodes(primitives.triangles());
}

void SharedFeatures::find(const std::array<NodeIndex, 3>& nodes, std::size_t count, Having& having) const {
  if (count == 1) having.ball = balls_[nodes[0]];
  const auto add = [&](const OfNodes& of, const auto& list, std::vector<std::uint32_t>& found) {
    for (std::uint32_t i = of.begin[nodes[0]]; i < of.begin[nodes[0] + 1]; ++i)
      if (has_all(list[of.places[i]], nodes, count)) found.push_back(of.places[i]);
  };
  add(edges_, primitives_.edges(), having.edges);
  add(triangles_, primitives_.triangles(), having.triangles);
}

}  // namespace springnet::proximity
