#include <algorithm>
#include <cmath>
#include <fstream>
#include <new>
#include <stdexcept>

#include <sys/resource.h>
#include <unistd.h>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/network.hpp>

#include "network/checks.hpp"

namespace springnet {
namespace {

using Step = std::array<int, 3>;

// Steps from a node to its neighbours of higher number, so that each spring is visited once.
constexpr std::array<Step, 3> axial{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
constexpr std::array<Step, 6> across_faces{{{1, 1, 0}, {-1, 1, 0}, {1, 0, 1}, {-1, 0, 1}, {0, 1, 1}, {0, -1, 1}}};
constexpr std::array<Step, 4> through_cells{{{1, 1, 1}, {-1, 1, 1}, {1, -1, 1}, {-1, -1, 1}}};

// What a simulation takes at least, with its network: bytes.
constexpr double bytes_a_node = 150.0, bytes_a_spring = 40.0;

struct Direction {
  Step step;
  double length;  // m
};

std::vector<Direction> directions_of(const Lattice& lattice) {
  std::vector<Direction> directions;
  const auto add = [&](const auto& steps) {
    for (const Step& step : steps) {
      const double length =
          std::hypot(step[0] * lattice.spacing.x(), step[1] * lattice.spacing.y(), step[2] * lattice.spacing.z());
      directions.push_back({step, length});
    }
  };
  add(axial);
  if (lattice.diagonals == Diagonals::face || lattice.diagonals == Diagonals::all) add(across_faces);
  if (lattice.diagonals == Diagonals::space || lattice.diagonals == Diagonals::all) add(through_cells);
  return directions;
}

// Counts are double: a product of three 32-bit numbers can overflow an integer; a double is exact far beyond the limit.
double node_count(const Lattice& lattice) {
  return static_cast<double>(lattice.nodes[0]) * lattice.nodes[1] * lattice.nodes[2];
}

double spring_count(const Lattice& lattice, const std::vector<Direction>& directions) {
  double count = 0;
  for (const Direction& direction : directions) {
    double places = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      places *= static_cast<double>(lattice.nodes[axis]) - std::abs(direction.step[axis]);
    }
    count += places;
  }
  return count;
}

// Memory available to this process, bytes; infinity if unknown.
double available_memory() {
  const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
  double memory = std::numeric_limits<double>::infinity();
  if (pages > 0 && page > 0) memory = static_cast<double>(pages) * static_cast<double>(page);
  rlimit limit{};
  if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    memory = std::min(memory, static_cast<double>(limit.rlim_cur));
  }
  // Limits of a container.
  for (const char* file : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    double bytes = 0.0;
    if (std::ifstream(file) >> bytes) memory = std::min(memory, bytes);
  }
  return memory;
}

}  // namespace

void checks::check_lattice(const std::string& name, const Lattice& lattice, std::size_t existing_nodes,
                           std::size_t existing_springs) {
  const std::vector<Direction> directions = directions_of(lattice);
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorKind::input, fmt::format("lattice '{}': {}", name, what));
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const char letter = "xyz"[axis];
    if (lattice.nodes[axis] == 0) fail(fmt::format("it needs one node or more along {}", letter));
    const double spacing = lattice.spacing[static_cast<Eigen::Index>(axis)];
    if (!(std::isfinite(spacing) && spacing > 0)) {
      fail(fmt::format("its spacing along {} must be a finite number above 0 m, is {}", letter, spacing));
    }
    const double end = lattice.origin[static_cast<Eigen::Index>(axis)] + spacing * (lattice.nodes[axis] - 1.0);
    if (!std::isfinite(end))
      fail(fmt::format("origin and spacing must keep it finite, its end along {} is {}", letter, end));
  }
  for (const Direction& direction : directions) {
    if (!std::isfinite(direction.length)) fail("its spacing is so large that its diagonals are not finite");
  }
  constexpr double limit = std::numeric_limits<std::uint32_t>::max();
  const double nodes = static_cast<double>(existing_nodes) + node_count(lattice);
  const double springs = static_cast<double>(existing_springs) + spring_count(lattice, directions);
  if (nodes > limit || springs > limit) {
    fail(fmt::format(
        "the network would have {:.4g} nodes and {:.4g} springs, but the limit is {:.0f} of each: use fewer nodes",
        nodes, springs, limit));
  }
  const double needed = nodes * bytes_a_node + springs * bytes_a_spring, available = available_memory();
  if (needed > available) {
    fail(
        fmt::format("the network would have {:.4g} nodes and {:.4g} springs, whose simulation needs more than {:.3g} "
                    "GB, but this machine has {:.3g} GB: use fewer nodes",
                    nodes, springs, needed * 1e-9, available * 1e-9));
  }
}

namespace {

// The boundary of a lattice as outward triangles. A lattice one node thick gives its quadrilaterals, a single row
// nothing. Quadrilaterals are divided along the diagonal from their lowest corner.
class Boundary {
 public:
  Boundary(const Lattice& lattice, NodeIndex first) : nodes_(lattice.nodes), first_(first) {}

  void add_to(Network& network) const {
    const auto thick = std::count_if(nodes_.begin(), nodes_.end(), [](std::uint32_t count) { return count > 1; });
    if (thick < 2) return;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (thick == 2 && nodes_[axis] > 1) continue;
      add_side(network, axis, nodes_[axis] - 1, true);
      if (thick == 3) add_side(network, axis, 0, false);
    }
  }

 private:
  // Adds the side at `place` along `axis`, facing the axis' upper or lower end.
  void add_side(Network& network, std::size_t axis, std::uint32_t place, bool from_above) const {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const std::array<NodeIndex, 3> strides{1, nodes_[0], nodes_[0] * nodes_[1]};
    for (std::uint32_t j = 0; j + 1 < nodes_[v]; ++j) {
      for (std::uint32_t i = 0; i + 1 < nodes_[u]; ++i) {
        const NodeIndex a = first_ + place * strides[axis] + i * strides[u] + j * strides[v];
        const NodeIndex b = a + strides[u], c = b + strides[v], d = a + strides[v];
        network.add_face(from_above ? Face{a, b, c} : Face{a, c, b});
        network.add_face(from_above ? Face{a, c, d} : Face{a, d, c});
      }
    }
  }

  std::array<std::uint32_t, 3> nodes_;
  NodeIndex first_;
};

// The springs of the nodes of one layer of a lattice, in the order of the nodes, then of the directions.
class Layer {
 public:
  Layer(const Lattice& lattice, const std::vector<Direction>& directions, std::uint32_t k)
      : lattice_(lattice), directions_(directions), k_(k) {}

  [[nodiscard]] std::size_t spring_count() const {
    std::size_t count = 0;
    for (const Direction& direction : directions_) {
      const auto places = [&](std::size_t axis) {
        const auto steps = static_cast<std::uint32_t>(std::abs(direction.step[axis]));
        return lattice_.nodes[axis] > steps ? std::size_t{lattice_.nodes[axis]} - steps : 0;
      };
      if (k_ + static_cast<std::uint32_t>(direction.step[2]) < lattice_.nodes[2]) count += places(0) * places(1);
    }
    return count;
  }

  // Calls visit(node, other, direction's number); nodes are numbered from that of place (0, 0, 0).
  template <class Visit>
  void for_each_spring(NodeIndex first, const Visit& visit) const {
    const auto [nx, ny, nz] = lattice_.nodes;
    // A step below 0 wraps to a large number, which is outside as well.
    const auto inside = [](std::uint32_t place, int step, std::uint32_t count) {
      return place + static_cast<std::uint32_t>(step) < count;
    };
    NodeIndex here = first + k_ * nx * ny;
    for (std::uint32_t j = 0; j < ny; ++j) {
      for (std::uint32_t i = 0; i < nx; ++i, ++here) {
        for (std::size_t d = 0; d < directions_.size(); ++d) {
          const Step& step = directions_[d].step;
          if (!inside(i, step[0], nx) || !inside(j, step[1], ny) || !inside(k_, step[2], nz)) continue;
          const std::int64_t ahead =
              step[0] + static_cast<std::int64_t>(nx) * (step[1] + static_cast<std::int64_t>(ny) * step[2]);
          visit(here, static_cast<NodeIndex>(here + ahead), d);
        }
      }
    }
  }

 private:
  const Lattice& lattice_;
  const std::vector<Direction>& directions_;
  std::uint32_t k_;
};

}  // namespace

void Network::add_lattice(const std::string& name, const Lattice& lattice, const Node& prototype,
                          MaterialIndex material) {
  const std::vector<Direction> directions = directions_of(lattice);
  checks::check_lattice(name, lattice, nodes_.size(), springs_.size());
  Node node = prototype;
  node.position = lattice.origin;
  check_node(node, static_cast<NodeIndex>(nodes_.size()));
  if (node.fixed) node.velocity.setZero();
  check_material(material);

  const double nodes = node_count(lattice), springs = spring_count(lattice, directions);
  const auto out_of_memory = [&] {
    const double gigabytes = (nodes * sizeof(Vector3) + springs * (sizeof(SpringList::Ends) + sizeof(double))) * 1e-9;
    throw Error(ErrorKind::input, fmt::format("lattice '{}': its {:.4g} nodes and {:.4g} springs need {:.3g} GB, which "
                                              "this machine cannot provide: use fewer nodes",
                                              name, nodes, springs, gigabytes));
  };
  try {
    reserve_nodes(nodes_.size() + static_cast<std::size_t>(nodes));
    reserve_springs(springs_.size() + static_cast<std::size_t>(springs));
  } catch (const std::bad_alloc&) {
    out_of_memory();
  } catch (const std::length_error&) {
    out_of_memory();
  }

  begin_body(name);
  const auto first = static_cast<NodeIndex>(nodes_.size());
  // No structured binding: Clang cannot share one with the threads of a parallel region.
  const std::uint32_t nx = lattice.nodes[0], ny = lattice.nodes[1], nz = lattice.nodes[2];
  Vector3* const positions = nodes_.append(static_cast<std::size_t>(nodes), node);
  const bool one_length = std::all_of(directions.begin(), directions.end(), [&](const Direction& direction) {
    return detail::SameBits<double>::of(direction.length, directions.front().length);
  });
  const auto spring_total = static_cast<std::size_t>(springs);
  SpringList::Ends* const ends = springs_.append(spring_total, material);
  double* lengths = nullptr;
  if (one_length)
    springs_.rest_length_.append(spring_total, directions.front().length);
  else
    lengths = springs_.rest_length_.append_each(spring_total);
  // All layers but the last have as many springs as the first.
  const std::size_t springs_a_layer = Layer(lattice, directions, 0).spring_count();
#pragma omp parallel for schedule(static) if (springs > 1e5)
  for (std::int64_t layer = 0; layer < std::int64_t{nz}; ++layer) {
    const auto k = static_cast<std::uint32_t>(layer);
    Vector3* position = positions + std::size_t{k} * nx * ny;
    for (std::uint32_t j = 0; j < ny; ++j)
      for (std::uint32_t i = 0; i < nx; ++i)
        *position++ = lattice.origin + lattice.spacing.cwiseProduct(Vector3(i, j, k));
    std::size_t at = k * springs_a_layer;
    Layer(lattice, directions, k).for_each_spring(first, [&](NodeIndex here, NodeIndex other, std::size_t direction) {
      ends[at] = {here, other};
      if (lengths != nullptr) lengths[at] = directions[direction].length;
      ++at;
    });
  }
  Boundary(lattice, first).add_to(*this);
  end_body();
}

}  // namespace springnet
