#include "simulation/torn_faces.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <unordered_set>

namespace springnet {
namespace {

using Corners = std::array<std::uint32_t, 3>;  // as the engine numbers nodes, ascending

Corners sorted(Corners corners) {
  std::sort(corners.begin(), corners.end());
  return corners;
}

std::uint64_t pair_of(std::uint32_t a, std::uint32_t b) {
  return (std::uint64_t{std::min(a, b)} << 32U) + std::max(a, b);
}

// The triangles among the corners of an element that is one, or fills a volume.
template <class Visit>
void for_triangles(const layers::ElementLayout& elements, std::uint32_t e, const Visit& visit) {
  const std::span<const std::uint32_t> n = elements.nodes(e);
  switch (elements.invariant(e)) {
    case Invariant::area:
    case Invariant::triangle:
      visit(sorted({n[0], n[1], n[2]}));
      return;
    case Invariant::volume:
    case Invariant::tetrahedron:
      for (std::size_t left_out = 0; left_out < 4; ++left_out)
        visit(sorted({n[(left_out + 1) % 4], n[(left_out + 2) % 4], n[(left_out + 3) % 4]}));
      return;
    default:
      return;
  }
}

}  // namespace

const std::vector<std::uint8_t>& TornFaces::of(const Network& network, const layers::Layout& layout) {
  if (revision_ == layout.revision() && torn_.size() == network.faces().size()) return torn_;
  torn_.assign(network.faces().size(), 0);
  revision_ = layout.revision();
  const layers::ElementLayout& elements = layout.elements();
  const layers::LoadedFaces& loaded = layout.loaded_faces();
  std::unordered_set<std::uint64_t> sides;
  for (std::uint32_t s = 0; layout.live_count() < layout.spring_count() && s < layout.spring_count(); ++s)
    if (!layout.alive(s)) sides.insert(pair_of(layout.first(s), layout.second(s)));
  std::set<Corners> gone;
  for (std::size_t f = 0; f < loaded.count(); ++f)
    if (!loaded.alive(f)) gone.insert(sorted(loaded.corners(f)));
  if (elements.live_count() < elements.count()) {
    std::set<Corners> of_elements;
    for (std::uint32_t e = 0; e < elements.count(); ++e)
      if (!elements.alive(e)) for_triangles(elements, e, [&](const Corners& c) { of_elements.insert(c); });
    for (std::uint32_t e = 0; e < elements.count() && !of_elements.empty(); ++e)
      if (elements.alive(e)) for_triangles(elements, e, [&](const Corners& c) { of_elements.erase(c); });
    gone.insert(of_elements.begin(), of_elements.end());
  }
  if (sides.empty() && gone.empty()) return torn_;
  const std::vector<std::uint32_t>& engine = layout.ordering().engine;
  for (std::size_t f = 0; f < torn_.size(); ++f) {
    const Face& face = network.faces()[f];
    const Corners c{engine[face[0]], engine[face[1]], engine[face[2]]};
    const bool torn = gone.contains(sorted(c)) ||
                      (!sides.empty() && (sides.contains(pair_of(c[0], c[1])) || sides.contains(pair_of(c[1], c[2])) ||
                                          sides.contains(pair_of(c[2], c[0]))));
    torn_[f] = torn ? 1 : 0;
  }
  return torn_;
}

}  // namespace springnet
