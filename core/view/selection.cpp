#include "view/selection.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include <fmt/format.h>

#include "view/pair.hpp"

namespace springnet::view {

namespace {

constexpr double face_bytes = 3 * 4 + 4;  // corners, and the frame from which it is torn

std::vector<SpringIndex> springs_on_faces(const Network& network) {
  std::unordered_set<std::uint64_t> edges;
  for (const Face& face : network.faces()) {
    for (std::size_t k = 0; k < 3; ++k) edges.insert(pair_of(face[k], face[(k + 1) % 3]));
  }
  std::vector<SpringIndex> on_faces;
  for (SpringIndex k = 0; k < network.springs().size(); ++k) {
    const Spring& spring = network.springs()[k];
    if (edges.count(pair_of(spring.first, spring.second)) == 1) on_faces.push_back(k);
  }
  return on_faces;
}

// Spread by the golden ratio rather than every n-th spring, because meshes number their springs in patterns.
void keep_share(std::vector<SpringIndex>& springs, double share) {
  std::erase_if(springs, [&](SpringIndex k) {
    const double place = static_cast<double>(k) * 0.6180339887498949;
    return place - std::floor(place) >= share;
  });
}

std::vector<bool> nodes_of(const Network& network, const std::vector<SpringIndex>& springs, bool faces) {
  std::vector<bool> used(network.nodes().size(), false);
  for (const SpringIndex k : springs) used[network.springs()[k].first] = used[network.springs()[k].second] = true;
  for (const Rigid& rigid : network.rigids()) used[rigid.first] = used[rigid.second] = true;
  if (faces) {
    for (const Face& face : network.faces()) {
      for (const NodeIndex node : face) used[node] = true;
    }
  }
  return used;
}

double count(const std::vector<bool>& used) { return static_cast<double>(std::count(used.begin(), used.end(), true)); }

void thin(const Network& network, double frames, double bytes, double more, Selection& selection,
          std::vector<bool>& used) {
  const Cost of_node = cost_of(1.0, 0.0), of_spring = cost_of(0.0, 1.0);
  const double node_bytes = of_node.once + frames * of_node.frame;
  const double spring_bytes = of_spring.once + frames * (of_spring.frame + more);
  const auto total = static_cast<double>(selection.springs.size());
  const auto all_faces = static_cast<double>(network.faces().size());
  if (all_faces * face_bytes > 0.5 * bytes) {
    selection.faces = false;
    selection.notes.push_back(
        fmt::format("the {} surface triangles are not drawn, because they would take most of the page; a larger "
                    "output.view_size shows them",
                    network.faces().size()));
  } else {
    bytes -= all_faces * face_bytes;
  }
  const std::size_t all = selection.springs.size();
  std::string which;
  if (std::vector<SpringIndex> on_faces = springs_on_faces(network); !on_faces.empty()) {
    which = ", on surfaces";
    selection.springs = std::move(on_faces);
  }
  used = nodes_of(network, selection.springs, selection.faces);
  // Each spring adds two nodes at most.
  const double max_springs =
      std::max((bytes - node_bytes * count(used)) / spring_bytes, bytes / (spring_bytes + 2.0 * node_bytes));
  const auto candidates = static_cast<double>(selection.springs.size());
  if (candidates > max_springs) {
    which += ", spread evenly";
    keep_share(selection.springs, max_springs / candidates);
    used = nodes_of(network, selection.springs, selection.faces);
  }
  if (static_cast<double>(selection.springs.size()) < total) {
    selection.notes.push_back(fmt::format("{} of {} springs are drawn{}; a larger output.view_size shows more",
                                          selection.springs.size(), all, which));
  }
}

template <class Index>
std::vector<std::uint32_t> places(const std::vector<Index>& shown, std::size_t total) {
  std::vector<std::uint32_t> place(total, not_shown);
  for (std::uint32_t k = 0; k < shown.size(); ++k) place[shown[k]] = k;
  return place;
}

}  // namespace

Cost cost_of(double nodes, double springs) {
  // Number, mass, kind; number, ends, rest length, material. A frame: position, speed, contact; tension.
  return {9.0 * nodes + 20.0 * springs, 8.125 * nodes + 2.0 * springs};
}

Selection select(const Network& network, double frames, double bytes, double more) {
  Selection selection;
  selection.springs.resize(network.springs().size());
  for (SpringIndex k = 0; k < selection.springs.size(); ++k) selection.springs[k] = k;
  std::vector<bool> used(network.nodes().size(), true);

  const Cost cost = cost_of(static_cast<double>(network.nodes().size()), static_cast<double>(network.springs().size()));
  const double whole = cost.once + frames * (cost.frame + more * static_cast<double>(network.springs().size())) +
                       static_cast<double>(network.faces().size()) * face_bytes;
  if (whole > bytes) thin(network, frames, bytes, more, selection, used);

  for (NodeIndex k = 0; k < used.size(); ++k) {
    if (used[k]) selection.nodes.push_back(k);
  }
  selection.node_place = places(selection.nodes, used.size());
  selection.spring_place = places(selection.springs, network.springs().size());
  return selection;
}

}  // namespace springnet::view
