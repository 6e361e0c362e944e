// The naive net (naive.h) of a network: the same springs and elements between nodes numbered as the engine's, springs
// in the order in which the engine keeps them, so that a comparison is not one of numberings.
#pragma once

#include <cstdint>
#include <vector>

#include <springnet/network.hpp>

#include "layers/layout.hpp"  // internal: the engine's order
#include "naive.h"

namespace springnet::benchmark {

class PlainNet {
 public:
  // In which nodes and springs are numbered.
  enum class Order { engine, file };

  // Loads, obstacles, motions, cuts and rigid connections are left out, moved nodes stand. Throws Error(input) for
  // laws, elements or neurons that naive.c does not have: springs of `linear` or, as long as none breaks, `rupturing`;
  // viscosities `linear` or `relative`; undamped linear hinges and one enclosed volume; all nodes of one neuron,
  // `point_mass` or `dragged`.
  PlainNet(const Network& network, const layers::Layout& layout, Order order = Order::engine);
  PlainNet(const PlainNet&) = delete;
  PlainNet& operator=(const PlainNet&) = delete;

  void add_forces() { naive_forces(&net_); }
  void step(double time_step) { naive_step(&net_, time_step); }
  // [node] in its order
  [[nodiscard]] const std::vector<NaiveNode>& nodes() const noexcept { return nodes_; }

 private:
  void take_nodes(const Network& network, const layers::Layout& layout);
  void take_springs(const layers::Layout& layout);
  void take_spring(const layers::Layout& layout, std::uint32_t first, std::uint32_t second, std::uint32_t spring);
  void number_as_file(const Network& network, const layers::Layout& layout);
  void take_elements(const Network& network, const layers::Layout& layout);

  NaiveNet net_{};
  std::size_t relative_ = 0;
  std::vector<NaiveNode> nodes_;
  std::vector<NaiveSpring> springs_;
  std::vector<NaiveHinge> hinges_;
  std::vector<NaiveTriangle> triangles_;
};

}  // namespace springnet::benchmark
